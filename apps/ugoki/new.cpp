// `ugoki new`: creates a project with the sample content, with content from a text file, or an empty one.

#include <filesystem>
#include <memory>

#include "output.h"
#include "ugoki/files/files.h"
#include "ugoki/project/project.h"
#include "ugoki/samples/samples.h"
#include "ugoki/studio/content_recipes.h"
#include "verb.h"

namespace ugoki::cli {
namespace {

struct Options {
  std::string path, name, from;
  bool empty = false, json = false;
};

int run_new(const Options& options) {
  content::Scenario scenario;
  content::Resources resources;
  if (!options.from.empty()) {
    const Result<std::string> text = files::read_file(options.from);
    if (!text) return print_error(text.error(), options.json);
    Result<content::ContentText> read = studio::make_content(*text, options.from);
    if (!read) return print_error(read.error(), options.json);
    scenario = std::move(read->scenario);
    resources = std::move(read->resources);
  } else if (!options.empty) {
    samples::Sample sample = samples::make_sample();
    Result<content::Scenario> document = content::read_scenario(sample.document, "sample");
    if (!document) return print_error(document.error(), options.json);
    scenario = std::move(*document);
    resources = std::move(sample.resources);
  }
  if (!options.name.empty())
    scenario.name = options.name;
  else if (options.empty)
    scenario.name = std::filesystem::path(options.path).stem().string();
  const Result<project::Project> made = project::Project::create(options.path, scenario, resources);
  if (!made) return print_error(made.error(), options.json);
  if (options.json)
    print_json({{"project", options.path},
                {"name", scenario.name},
                {"characters", scenario.characters.size()},
                {"mechanisms", resources.mechanisms.size()},
                {"motions", resources.motions.size()},
                {"duration_s", scenario.duration}});
  else
    print_line("Created " + options.path + " (" + scenario.name + "). Open it with: ugoki studio " + options.path);
  return 0;
}

}  // namespace

void add_new_verb(Verb app, Action& action) {
  auto options = std::make_shared<Options>();
  Verb verb = app.add_subcommand("new", "Create a project with the sample content, or an empty one.");
  verb.add_option("project", options->path, "The file to create, *.ugoki").required();
  verb.add_option("--name", options->name, "Name of the content");
  const Option empty = verb.add_flag("--empty", options->empty, "Without the sample content");
  verb.add_option("--from", options->from,
                  "JSON file with a scenario, mechanisms and motions, for example from the folder examples/content")
      .excludes(empty);
  verb.add_flag("--json", options->json, "Print one JSON object");
  verb.footer("Example:\n  ugoki new park.ugoki");
  verb.callback([options, &action] { action = [options] { return run_new(*options); }; });
}

}  // namespace ugoki::cli
