// `ugoki studio`: serves the studio's page until Ctrl+C. Also the hidden verb `interpret`, a child process in which the studio runs
// content.

#include "ugoki/studio/studio.h"

#include <unistd.h>

#include <filesystem>
#include <memory>

#include "output.h"
#include "sources.h"
#include "ugoki/samples/samples.h"
#include "ugoki/store/library.h"
#include "ugoki/studio/interpreter_child.h"
#include "ugoki/studio/launch_page.h"
#include "ugoki/studio/player_simulation.h"
#include "ugoki/studio/session_key.h"
#include "ugoki/studio/static_files.h"
#include "verb.h"

namespace ugoki::cli {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string project, web, library;
  std::uint16_t port = 0;
  bool no_open = false, json = false;
};

Result<project::Project> make_sample(const std::string& path) {
  samples::Sample sample = samples::make_sample();
  Result<content::Scenario> document = content::read_scenario(sample.document, "sample");
  if (!document) return fail(std::move(document.error()));
  return project::Project::create(path, *document, sample.resources);
}

/// Opens the sample project in the library's folder and creates it if it does not exist. If another studio has it open, the next of
/// sample-2.ugoki, sample-3.ugoki, ... is used.
Result<project::Project> open_sample(const std::string& library) {
  const fs::path folder = fs::path(library).parent_path();
  std::error_code ec;
  fs::create_directories(folder.empty() ? "." : folder, ec);
  if (ec)
    return fail(ErrorCode::io, folder.string(), "The folder for the sample content cannot be created: " + ec.message() + ".",
                "Name a project: ugoki studio PROJECT.");
  constexpr int maximum = 20;
  for (int n = 1;; ++n) {
    const std::string path = (folder / (n == 1 ? "sample.ugoki" : "sample-" + std::to_string(n) + ".ugoki")).string();
    Result<project::Project> opened = fs::exists(path, ec) ? project::Project::open(path) : make_sample(path);
    if (opened || n == maximum || opened.error().problems.front().code != ErrorCode::conflict) return opened;
  }
}

int run_studio(const Options& options) {
  studio::hold_signals();
  std::error_code ec;
  const fs::path program = fs::read_symlink("/proc/self/exe", ec);
  studio::StudioOptions service;
  service.port = options.port;
  service.library_path = options.library.empty() ? store::Library::default_path() : options.library;
  // Without a key the studio works, but open pages lose their access when the studio is restarted.
  if (Result<std::string> key = studio::read_or_make_key(studio::default_key_file())) service.key = std::move(*key);
  service.interpreter = {ec ? "/proc/self/exe" : program.string(), {"interpret"}};
  if (!options.web.empty()) {
    service.web = options.web;
  } else if (const auto found = studio::find_web_folder(program)) {
    service.web = *found;
  }
  if (!fs::is_regular_file(service.web / "index.html", ec)) {
    return print_error(Error(ErrorCode::io, options.web.empty() ? "web/dist" : options.web, "The studio's page was not found.",
                             "Build it with `npm ci && npm run build` in web/, or name its folder with --web."),
                       options.json);
  }
  Result<project::Project> project = options.project.empty() ? open_sample(service.library_path) : project::Project::open(options.project);
  if (!project) return print_error(project.error(), options.json);
  print_warning(project->warning());
  const std::string path = project->path();
  const Result<std::unique_ptr<studio::Studio>> started = studio::Studio::start(service, std::move(*project));
  if (!started) return print_error(started.error(), options.json);
  const std::string address = (*started)->address();
  if (options.json) {
    print_json({{"address", address}, {"port", (*started)->port()}, {"token", (*started)->token()}, {"project", path}});
  } else {
    print_line("Ugoki studio: " + address);
    print_line("Project: " + path + " (Ctrl+C ends the studio; every change is kept)");
  }
  std::unique_ptr<studio::LaunchPage> page;  // exists until the studio ends: a browser may need long to start
  if (!options.no_open && isatty(STDOUT_FILENO) != 0) {
    if (Result<std::unique_ptr<studio::LaunchPage>> written = studio::LaunchPage::write(address)) {
      page = std::move(*written);
      studio::open_browser(page->path());
    }
  }
  studio::wait_for_signal();
  return 0;
}

}  // namespace

void add_studio_verb(Verb app, Action& action) {
  auto options = std::make_shared<Options>();
  Verb verb = app.add_subcommand("studio", "Open the studio in the browser.");
  verb.add_option("project", options->project, "The project, *.ugoki (default: the sample content)");
  verb.add_option("--port", options->port, "Port on 127.0.0.1 (default: any free port)");
  verb.add_flag("--no-open", options->no_open, "Do not open a browser");
  verb.add_option("--web", options->web, "Folder of the built page");
  add_library_option(verb, options->library);
  verb.add_flag("--json", options->json, "Print the address as one JSON object");
  verb.footer("Example:\n  ugoki studio park.ugoki --port 8420");
  verb.callback([options, &action] { action = [options] { return run_studio(*options); }; });

  Verb interpret = app.add_subcommand("interpret", "Run content for a studio.");
  interpret.group("");  // an empty group hides the verb from the help
  interpret.callback([&action] { action = [] { return studio::run_interpreter(studio::open_player); }; });
}

}  // namespace ugoki::cli
