#include "ugoki/plugin/build.h"

#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "ugoki/base/number.h"
#include "ugoki/files/files.h"
#include "ugoki/files/temporary_folder.h"
#include "ugoki/plugin/inspect.h"
#include "ugoki/plugin/run_program.h"
#include "ugoki/plugin/wrapper.h"

namespace ugoki::plugin {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::seconds compile_limit{300};  // a file of plain functions takes a few seconds; a compiler above the limit is killed

/// Path of an executable: in PATH, or `name` itself if it has a slash. Empty: not found.
std::string find_program(const std::string& name) {
  if (name.find('/') != std::string::npos) return ::access(name.c_str(), X_OK) == 0 ? name : "";
  const char* all = ::getenv("PATH");
  std::string folders = std::string(all ? all : "/usr/bin:/bin") + ":";
  while (!folders.empty()) {
    const auto colon = folders.find(':');
    const std::string path = folders.substr(0, colon) + "/" + name;
    folders.erase(0, colon + 1);
    if (::access(path.c_str(), X_OK) == 0 && !fs::is_directory(path)) return path;
  }
  return {};
}

/// First line of a compiler message: "spring.c:3:5: error: text".
struct Diagnostic {
  std::string location, kind, text;
};
/// Reads the first line of a compiler message. @return false if the line does not begin a message
bool read_diagnostic(const std::string& line, Diagnostic& d) {
  for (const char* kind : {"fatal error", "error", "warning"}) {
    const auto at = line.find(": " + std::string(kind) + ": ");
    if (at == std::string::npos || line.starts_with(" ")) continue;
    d.location = line.substr(0, at);
    d.kind = kind;
    d.text = line.substr(at + std::string(kind).size() + 4);
    return true;
  }
  return false;
}

/// The line of `source` at a location such as "spring.c:3:5", without its indentation; empty if there is none.
std::string source_line(const std::string& source, const std::string& location) {
  const auto first = location.find(':');
  const auto line =
      first == std::string::npos ? std::nullopt : parse_long(location.substr(first + 1, location.find(':', first + 1) - first - 1));
  if (!line || *line < 1) return {};
  std::size_t at = 0;
  for (long i = 1; i < *line && at != std::string::npos; ++i) {
    at = source.find('\n', at);
    if (at != std::string::npos) ++at;
  }
  if (at == std::string::npos) return {};
  std::string text = source.substr(at, source.find('\n', at) - at);
  const auto begin = text.find_first_not_of(" \t");
  return begin == std::string::npos ? "" : text.substr(begin);
}

/// Sorts the compiler's messages into errors and warnings. In messages, the path that the user gave replaces the absolute path `full`.
void read_messages(const std::string& output, const BuildRequest& request, const std::string& full, const std::string& source,
                   Error& errors, std::vector<std::string>& warnings) {
  const std::string shown = request.source;
  for (std::size_t at = 0; at < output.size();) {
    const std::size_t end = std::min(output.find('\n', at), output.size());
    Diagnostic d;
    if (read_diagnostic(output.substr(at, end - at), d)) {
      const bool own = d.location.starts_with(full + ":");
      if (own) d.location.replace(0, full.size(), shown);
      if (d.kind == "warning") {
        if (d.location.starts_with(generated_file)) d.location.clear();  // no location, because the user cannot change generated code
        if (!d.location.empty()) warnings.push_back(d.location + ": " + d.text);
      } else {
        const std::string line = own ? source_line(source, d.location) : "";
        errors.add(ErrorCode::syntax, d.location, d.text + (d.text.ends_with('.') ? "" : "."),
                   line.empty() ? "Correct the source." : "The line is: " + line);
      }
    }
    at = end + 1;
  }
}

std::string library_name(const BuildRequest& request, const CSource& source) {
  if (!request.name.empty()) return request.name;
  if (const Annotation* a = source.file.find("library"); a && !a->doc.empty()) return a->doc.substr(0, a->doc.find(' '));
  std::string stem = fs::path(request.source).stem().string();
  for (char& c : stem)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-' && c != '_') c = '_';
  return stem.empty() ? "lsis" : stem.substr(0, 64);
}

}  // namespace

Result<std::string> find_compiler(bool cpp, const std::string& wanted) {
  if (!wanted.empty()) {
    const std::string path = find_program(wanted);
    if (!path.empty()) return path;
    return fail(ErrorCode::io, "--compiler", "The compiler '" + wanted + "' was not found.",
                "Give the name or path of an installed C or C++ compiler.");
  }
  using Names = std::array<const char*, 3>;
  const Names names = cpp ? Names{"clang++-19", "clang++", "g++"} : Names{"clang-19", "clang", "gcc"};
  for (const char* name : names)
    if (const std::string path = find_program(name); !path.empty()) return path;
  return fail(ErrorCode::io, "compiler", std::string("No compiler for ") + (cpp ? "C++" : "C") + " was found.",
              "Install one, on Debian as root: apt-get install clang-19 (or gcc g++).");
}

Result<BuildReport> build_library(const BuildRequest& request) {
  const std::string extension = fs::path(request.source).extension().string();
  const bool cpp = extension == ".cpp" || extension == ".cc" || extension == ".cxx" || extension == ".C";
  if (!cpp && extension != ".c")
    return fail(ErrorCode::unsupported, request.source, "The LSI builder reads C and C++ files, not '" + extension + "'.",
                "Give a file *.c or *.cpp.");
  const Result<std::string> text = files::read_file(request.source, std::size_t{16} << 20);
  if (!text) return fail(text.error());
  std::error_code ec;
  const std::string full = fs::absolute(request.source, ec).lexically_normal().string();
  const CSource source = read_source(*text, cpp);
  BuildReport report;
  report.name = library_name(request, source);
  report.output = request.output.empty() ? fs::path(request.source).replace_extension(".so").string() : request.output;
  Wrapper wrapper;
  if (!source.declares_library) {
    Result<Wrapper> made = make_wrapper(source, full, report.name, cpp);
    if (!made) return fail(std::move(made.error()));
    wrapper = std::move(*made);
    report.notes = wrapper.notes;
  }
  const Result<std::string> compiler = find_compiler(cpp, request.compiler);
  if (!compiler) return fail(compiler.error());
  report.compiler = *compiler;

  const Result<files::TemporaryFolder> folder = files::TemporaryFolder::make("build", "temporary folder");
  if (!folder) return fail(folder.error());
  fs::create_directories(folder->path() + "/include/ugoki", ec);
  for (const Header& h : public_headers())
    if (Result<void> done = files::write_file(folder->path() + "/include/" + h.path, std::string_view(h.text)); !done)
      return fail(done.error());
  const std::string unit = folder->path() + (cpp ? "/lsis.cpp" : "/lsis.c");
  if (!source.declares_library)
    if (Result<void> done = files::write_file(unit, std::string_view(wrapper.code)); !done) return fail(done.error());
  const std::string made = folder->path() + "/" + report.name + ".so";
  // -ffp-contract=off: a * b + c is rounded twice on every machine, so that results are the same everywhere. Frame pointers allow stack
  // traces.
  const std::vector<std::string> arguments = {*compiler,
                                              cpp ? "-std=c++20" : "-std=gnu17",
                                              "-O2",
                                              "-g1",
                                              "-fPIC",
                                              "-shared",
                                              "-ffp-contract=off",
                                              "-fvisibility=hidden",
                                              "-fno-omit-frame-pointer",
                                              "-Wall",
                                              "-Wextra",
                                              "-Wno-unused-function",
                                              "-fno-diagnostics-color",
                                              "-I",
                                              folder->path() + "/include",
                                              "-I",
                                              fs::path(full).parent_path().string(),
                                              source.declares_library ? full : unit,
                                              "-o",
                                              made,
                                              "-lm"};
  const Result<ProgramOutput> ran = run_program(arguments, {compile_limit, folder->path(), request.cancelled});
  if (!ran) return fail(ran.error());
  Error errors;
  read_messages(ran->err, request, full, *text, errors, report.warnings);
  if (ran->status != 0) {
    if (ran->timed_out)
      return fail(ErrorCode::io, request.source, "The compiler did not finish within " + std::to_string(compile_limit.count()) + " s.",
                  "Make the file smaller.");
    if (errors.empty()) {
      std::string tail = ran->err.size() > 2000 ? ran->err.substr(ran->err.size() - 2000) : ran->err;
      std::ranges::replace(tail, '\n', ' ');  // the message is one line
      errors.add(ErrorCode::syntax, request.source, "The library cannot be linked: " + tail,
                 "Make sure that every function that is used is defined in the file.");
    }
    return fail(std::move(errors));
  }
  const Result<std::string> bytes = files::read_file(made);
  if (!bytes) return fail(bytes.error());
  if (const Result<Inspection> file = inspect_elf(*bytes, request.source); file)
    for (std::string& w : writable_warnings(*file, request.source)) report.warnings.push_back(std::move(w));
  if (Result<void> done = files::write_file(report.output, std::string_view(*bytes)); !done) return fail(done.error());
  return report;
}

}  // namespace ugoki::plugin
