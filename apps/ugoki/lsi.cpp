// `ugoki lsi`: creates, builds, tests and installs libraries of software LSIs.

#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <iostream>
#include <memory>
#include <set>
#include <sstream>
#include <thread>

#include "lsi_template.h"
#include "output.h"
#include "output_files.h"
#include "ugoki/circuit/class_json.h"
#include "ugoki/circuit/example.h"
#include "ugoki/files/files.h"
#include "ugoki/lsi/standard_library.h"
#include "ugoki/plugin/build.h"
#include "ugoki/plugin/guard.h"
#include "ugoki/plugin/inspect.h"
#include "ugoki/plugin/live_library.h"
#include "ugoki/plugin/load.h"
#include "ugoki/plugin/run_program.h"
#include "ugoki/plugin/shelf.h"
#include "verb.h"

namespace ugoki::cli {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string target, output, name, compiler, hash, shelf;
  bool cpp = false, start = false, install = false, yes = false, all = false, json = false;
};

std::string shelf_of(const Options& o) { return o.shelf.empty() ? plugin::default_shelf() : o.shelf; }

/// Description of a library, read in a child process, because the library is not trusted yet and may crash.
/// @param hash SHA-256 that the file must have; empty: any file
/// @param start true: also start and end an FMU, to check that it works on this machine
Result<Json> describe(const std::string& path, const std::string& hash = {}, bool start = false) {
  // A name that begins with '-' would be read as an option.
  std::vector<std::string> command{"/proc/self/exe", "lsi", "describe", path.starts_with('-') ? "./" + path : path};
  if (!hash.empty()) command.insert(command.end(), {"--hash", hash});
  if (start) command.push_back("--start");
  const Result<plugin::ProgramOutput> ran = plugin::run_program(command, {std::chrono::seconds(start ? 60 : 20)});
  if (!ran) return fail(ran.error());
  const Result<Json> json = json::parse_json(ran->out, path);
  if (ran->status == 0 && json) {
    if (hash.empty() || json->value("sha256", "") == hash) return *json;
    return fail(ErrorCode::conflict, path, "The description of the library is of another file than the one with the SHA-256 " + hash + ".",
                "Install it again.");
  }
  Error error;
  if (json && json->contains("problems") && (*json)["problems"].is_array())
    for (const Json& p : (*json)["problems"])
      error.add(ErrorCode::structure, p.value("location", path), p.value("message", ""), p.value("remedy", ""));
  if (error.empty())
    error.add(ErrorCode::structure, path,
              "The library could not be opened: the process that loaded it ended with status " + std::to_string(ran->status) + ".",
              "Build it again: ugoki lsi build FILE.c");
  return fail(std::move(error));
}

int run_describe(const Options& o) {
  const auto print_and_fail = [](const Error& error) {
    print_json_text(json::to_text(json::error_json(error)));
    return 1;
  };
  const Result<int> done = plugin::run_guarded([&] {
    plugin::set_phase("The library '" + o.target + "' was being loaded");
    const Result<std::string> text = plugin::describe_library(o.target, o.hash);
    plugin::set_phase({});
    if (!text) return print_and_fail(text.error());
    if (o.start)
      if (const Result<void> works = plugin::try_library(o.target, o.hash); !works) return print_and_fail(works.error());
    print_json_text(*text);
    return 0;
  });
  return done ? *done : print_and_fail(done.error());
}

std::string pins_text(const Json& pins) {
  std::string out;
  for (const Json& p : pins) {
    out += (out.empty() ? "" : ", ") + p.value("name", "");
    if (const std::string unit = p.value("unit", ""); !unit.empty()) out += " [" + unit + "]";
  }
  return out.empty() ? "-" : out;
}

void print_classes(const Json& classes) {
  std::vector<std::vector<std::string>> rows = {{"LSI", "inputs", "outputs", "parameters"}};
  for (const Json& c : classes)
    rows.push_back({c.value("name", ""), pins_text(c["inputs"]), pins_text(c["outputs"]), pins_text(c["parameters"])});
  print_table(rows);
}

/// The names that a library file states, for the question of consent: "The library 'springs' with the LSIs 'a', 'b'".
std::string stated_content(const plugin::Inspection& file) {
  constexpr std::size_t max_shown = 20;
  if (file.fmu) return "The FMU";
  std::string out = file.name.empty() ? "The library" : "The library '" + file.name + "'";
  for (std::size_t i = 0; i < std::min(file.lsis.size(), max_shown); ++i)
    out += (i > 0 ? ", '" : file.lsis.size() == 1 ? " with the LSI '" : " with the LSIs '") + file.lsis[i] + "'";
  if (file.lsis.size() > max_shown) out += " and " + std::to_string(file.lsis.size() - max_shown) + " more";
  return out;
}

/// Sentence that names the libraries which the library file `file` loads; empty if it loads none.
std::string needed_text(const plugin::Inspection& file) {
  if (file.needed.empty()) return {};
  std::string out;
  for (const std::string& name : file.needed) out += (out.empty() ? "" : ", ") + name;
  return "It loads further libraries, whose content this SHA-256 does not cover: " + out +
         (file.search_path.empty() ? "" : " (searched in " + file.search_path + ")") + ".";
}

/// Sentence that names the installed library that the file would replace; empty if there is none.
std::string replaced_text(const Options& o, const plugin::Inspection& file) {
  for (const plugin::ShelfEntry& entry : plugin::read_shelf(shelf_of(o)))
    if (entry.name == file.name && entry.hash != file.hash)
      return "It replaces the installed library '" + entry.name + "' with the SHA-256 " + entry.hash + ", installed from " + entry.source +
             ".";
  return {};
}

/// Asks for consent to install a library. Without a terminal, --yes or --hash is required. No code of the file has run before.
Result<void> ask_consent(const Options& o, const plugin::Inspection& file, const std::string& path) {
  if (!o.hash.empty() && o.hash != file.hash)
    return fail(ErrorCode::conflict, path, "The SHA-256 of the file is " + file.hash + ", not the one given with --hash.",
                "Download the library again from the publisher of the hash.");
  const std::string needed = needed_text(file), replaced = replaced_text(o, file);
  if (o.yes || !o.hash.empty()) {
    for (const std::string* text : {&needed, &replaced})
      if (!text->empty()) print_message("warning: " + path + ": " + *text);
    return {};
  }
  if (isatty(STDIN_FILENO) == 0)
    return fail(ErrorCode::cancelled, path,
                "A library runs with all your rights; installing it needs your consent." + (needed.empty() ? "" : " " + needed) +
                    (replaced.empty() ? "" : " " + replaced),
                "If you trust it, add --yes, or --hash " + file.hash);
  print_line(stated_content(file) + " is a program that runs with all your rights.");
  print_line("SHA-256 " + file.hash);
  if (!needed.empty()) print_line(needed);
  if (!replaced.empty()) print_line(replaced);
  print_line("Install it? [y/N] ");
  std::string answer;
  std::getline(std::cin, answer);
  if (answer == "y" || answer == "Y" || answer == "yes") return {};
  return fail(ErrorCode::cancelled, path, "The library was not installed, because consent was refused.", "");
}

/// Installs a file. Its code is loaded only after the user has consented to the file's hash, and only if the file still has this hash.
Result<Json> install(const Options& o, const std::string& path) {
  const Result<plugin::Inspection> file = plugin::inspect_library(path);
  if (!file) return fail(file.error());
  if (Result<void> consent = ask_consent(o, *file, path); !consent) return fail(std::move(consent.error()));
  Result<Json> description = describe(path, file->hash, file->fmu);
  if (!description) return description;
  for (const std::string& w : plugin::writable_warnings(*file, path)) print_message("warning: " + w);
  const Result<plugin::ShelfEntry> entry = plugin::put_on_shelf(shelf_of(o), path, json::to_text(*description));
  if (!entry) return fail(entry.error());
  return description;
}

int run_new(const Options& o) {
  const Result<std::vector<std::string>> files = make_template(o.target, o.cpp);
  if (!files) return print_error(files.error(), o.json);
  if (o.json) {
    print_json({{"files", *files}});
  } else {
    for (const std::string& f : *files) print_line("wrote " + f);
    print_line("Build it and run its test with: ugoki lsi test " + o.target);
  }
  return 0;
}

int run_build(const Options& o) {
  const std::string output = o.output.empty() ? fs::path(o.target).replace_extension(".so").string() : o.output;
  if (Result<void> may = check_outputs({{"the source", o.target}}, {{"--output", output}}); !may) return print_error(may.error(), o.json);
  catch_interrupt();
  const Result<plugin::BuildReport> report = plugin::build_library({o.target, o.output, o.name, o.compiler, interrupted});
  if (interrupted()) return print_error(interrupted_error(), o.json);
  if (!report) return print_error(report.error(), o.json);
  const Result<Json> description = o.install ? install(o, report->output) : describe(report->output);
  if (!description) return print_error(description.error(), o.json);
  if (o.json) {
    print_json({{"library", report->name},
                {"output", report->output},
                {"compiler", report->compiler},
                {"sha256", (*description)["sha256"]},
                {"installed", o.install},
                {"classes", (*description)["classes"]},
                {"notes", report->notes},
                {"warnings", report->warnings}});
    return 0;
  }
  for (const std::string& w : report->warnings) print_line("warning: " + w);
  for (const std::string& n : report->notes) print_line("note: " + n);
  print_line("Built " + report->output + " with " + report->compiler + (o.install ? ", and installed it." : "."));
  print_classes((*description)["classes"]);
  return 0;
}

int run_install(const Options& o) {
  const Result<Json> description = install(o, o.target);
  if (!description) return print_error(description.error(), o.json);
  if (o.json) {
    print_json(*description);
  } else {
    print_line("Installed '" + description->value("name", "") + "' (SHA-256 " + description->value("sha256", "") + ").");
    std::istringstream doc(description->value("doc", ""));
    for (std::string line; std::getline(doc, line);) print_line(line);
    print_classes((*description)["classes"]);
  }
  return 0;
}

int run_list(const Options& o) {
  Error problems;
  const std::vector<plugin::ShelfEntry> shelf = plugin::read_shelf(shelf_of(o), &problems);
  if (!problems.empty()) print_error(problems, false);
  Json libraries = Json::array(), classes = Json::array();
  std::set<std::string> damaged;  // names of libraries whose copy on the shelf is missing or changed
  for (const plugin::ShelfEntry& e : shelf) {
    Json own = Json::array();
    for (const circuit::LsiClass& c : e.classes) {
      own.push_back(circuit::class_json(c));
      classes.push_back(circuit::class_json(c));
    }
    libraries.push_back({{"name", e.name},
                         {"version", e.version},
                         {"doc", e.doc},
                         {"sha256", e.hash},
                         {"file", e.file},
                         {"source", e.source},
                         {"classes", own}});
    const Result<void> intact = plugin::check_library_file(e.file, e.hash);
    libraries.back()["intact"] = intact.has_value();
    if (!intact) {
      damaged.insert(e.name);
      print_error(intact.error(), false);
    }
  }
  Json built_in = Json::array();
  if (o.all)
    for (const circuit::LsiClass& c : lsi::standard_library().classes()) built_in.push_back(circuit::class_json(c));
  if (o.json) {
    Json out = {{"folder", shelf_of(o)}, {"libraries", libraries}};
    if (o.all) out["built_in"] = built_in;
    print_json(out);
    return 0;
  }
  if (shelf.empty()) print_line("No library is installed in " + shelf_of(o) + ". Create one with: ugoki lsi new NAME");
  for (const plugin::ShelfEntry& e : shelf)
    print_line(e.name + (e.version.empty() ? "" : " " + e.version) + "  SHA-256 " + e.hash +
               (damaged.contains(e.name) ? "  (the file is missing or changed, and is not loaded)" : ""));
  if (!classes.empty()) print_classes(classes);
  if (o.all) print_classes(built_in);
  return 0;
}

int run_remove(const Options& o) {
  if (Result<void> done = plugin::remove_from_shelf(shelf_of(o), o.target); !done) return print_error(done.error(), o.json);
  if (o.json)
    print_json({{"removed", o.target}});
  else
    print_line("Removed '" + o.target + "'.");
  return 0;
}

/// Builds the sources in a folder and runs its tests (*.test.json).
int run_test(const Options& o) {
  std::vector<std::string> sources, tests;
  std::error_code ec;
  for (const fs::directory_entry& e : fs::directory_iterator(o.target, ec)) {
    const std::string path = e.path().string(), extension = e.path().extension().string();
    if (extension == ".c" || extension == ".cpp" || extension == ".cc" || extension == ".cxx") sources.push_back(path);
    if (path.ends_with(".test.json")) tests.push_back(path);
  }
  std::sort(sources.begin(), sources.end());
  std::sort(tests.begin(), tests.end());
  if (ec || sources.empty() || tests.empty())
    return print_error(Error(ErrorCode::io, o.target, "This is not a folder with a source and a test (*.test.json).",
                             "Create one with: ugoki lsi new NAME"),
                       o.json);
  std::vector<std::string> libraries;
  for (const std::string& source : sources) {
    const Result<plugin::BuildReport> report = plugin::build_library({source, {}, {}, o.compiler});
    if (!report) return print_error(report.error(), o.json);
    for (const std::string& w : report->warnings) print_line("warning: " + w);
    libraries.push_back(report->output);
  }
  const Result<int> done = plugin::run_guarded([&] {
    plugin::LiveLibrary live(lsi::standard_library(), {}, libraries);
    int failed = 0;
    for (const std::string& m : live.take_messages()) {
      print_message(m);
      failed = 1;
    }
    for (const std::string& path : tests) {
      if (path != tests.front()) (void)live.renew();  // reloads the library, so that earlier tests leave no changed global variables
      const Result<std::string> text = files::read_file(path);
      Result<circuit::Example> example = text ? circuit::read_example(*text, path) : fail(text.error());
      const Result<void> passed =
          example ? circuit::check_example(*example, *live.library(), path, nullptr, &plugin::process_activity()) : fail(example.error());
      if (passed)
        print_line("passed  " + path);
      else
        failed = print_error(passed.error(), false);
    }
    return failed;
  });
  if (!done) return print_error(done.error(), o.json);
  if (o.json) print_json({{"tests", tests.size()}, {"passed", *done == 0}});
  return *done;
}

/// Rebuilds and reinstalls a file whenever it changes, until Ctrl+C.
int run_watch(Options o) {
  catch_interrupt();
  o.yes = o.install = true;  // by watching the file, the user has consented to each of its versions
  fs::file_time_type seen{};
  for (std::error_code ec; !interrupted(); std::this_thread::sleep_for(std::chrono::milliseconds(200))) {
    const fs::file_time_type now = fs::last_write_time(o.target, ec);
    if (ec || now == seen) continue;
    seen = now;
    run_build(o);
  }
  return 0;
}

}  // namespace

void add_lsi_verb(Verb app, Action& action) {
  auto options = std::make_shared<Options>();
  Verb verb = app.add_subcommand("lsi", "Create, build, test and install libraries of software LSIs, and install FMUs.");
  verb.require_subcommand(1);
  const auto add = [&](const char* name, const char* doc, const char* target, const char* example, int (*run)(const Options&)) {
    Verb sub = verb.add_subcommand(name, doc);
    if (*target) sub.add_option("target", options->target, target).required();
    sub.add_flag("--json", options->json, "Print one JSON object");
    sub.add_option("--shelf", options->shelf, "Folder of installed libraries (default: $UGOKI_LSI or ~/.local/share/ugoki/lsi)");
    sub.footer(std::string("Example:\n  ") + example);
    sub.callback([options, run, &action] { action = [options, run] { return run(*options); }; });
    return sub;
  };
  add("new", "Create a template: source, test and README.", "Name of the library, and of its folder",
      "ugoki lsi new spring && ugoki lsi test spring", run_new)
      .add_flag("--cpp", options->cpp, "Use a C++ struct instead of a C function");
  const auto add_build_options = [&](Verb sub) {
    sub.add_option("-o,--output", options->output, "The library to write, *.so (default: in the folder of the source)");
    sub.add_option("--name", options->name, "Name of the library (default: @library in the source, or the file's name)");
    sub.add_option("--compiler", options->compiler, "Compiler (default: clang-19, clang, gcc; for C++ clang++-19, clang++, g++)");
  };
  Verb build =
      add("build", "Wrap the functions of a C or C++ file into a library.", "C or C++ file", "ugoki lsi build spring.c", run_build);
  add_build_options(build);
  build.add_flag("--install", options->install, "Install the library after building");
  build.add_flag("--yes", options->yes, "Install without asking");
  Verb install_verb = add("install", "Install a library or an FMU, after your consent.", "Library (*.so) or FMU (*.fmu)",
                          "ugoki lsi install spring.so", run_install);
  install_verb.add_flag("--yes", options->yes, "Install without asking");
  install_verb.add_option("--hash", options->hash, "Expected SHA-256 of the file; counts as consent if it matches");
  add("list", "List the installed libraries.", "", "ugoki lsi list --all", run_list)
      .add_flag("--all", options->all, "Also list the built-in LSIs");
  add("remove", "Remove an installed library.", "Its name", "ugoki lsi remove spring", run_remove);
  add("test", "Build the sources in a folder and run its tests (*.test.json).", "The folder", "ugoki lsi test spring", run_test)
      .add_option("--compiler", options->compiler, "Compiler");
  add_build_options(add("watch", "Build and install a file whenever it changes.", "C or C++ file", "ugoki lsi watch spring.c",
                        [](const Options& o) { return run_watch(o); }));
  Verb describe_verb =
      add("describe", "Print the description of a library.", "Library, *.so", "ugoki lsi describe spring.so", run_describe).group("");
  describe_verb.add_flag("--start", options->start, "Also start an FMU");
  describe_verb.add_option("--hash", options->hash, "SHA-256 that the file must have");
}

}  // namespace ugoki::cli
