// `ugoki new`: creates a project with the sample content, with content from a text file, or an empty one.

#include <filesystem>
#include <memory>

#include "output.h"
#include "ugoki/files/files.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/json/json.h"
#include "ugoki/project/project.h"
#include "ugoki/samples/samples.h"
#include "verb.h"

namespace ugoki::cli {
namespace {

struct Options {
  std::string path, name, from;
  bool empty = false, json = false;
};

/// Reads content from a JSON file {"scenario": {...}, "mechanisms": {ID: {...}}, "circuit": {...}}. docs/scenario.md, docs/formats.md and
/// docs/circuit.md describe the three parts; `circuit` is optional.
Result<void> read_content_file(const std::string& path, content::Scenario& scenario, content::Resources& resources) {
  const Result<std::string> text = files::read_file(path);
  if (!text) return fail(text.error());
  const Result<Json> json = json::parse_json(*text, path);
  if (!json) return fail(json.error());
  const auto part = [&](const char* name) { return json->is_object() && json->contains(name) ? (*json)[name] : Json(); };
  const Json mechanisms = part("mechanisms"), circuit = part("circuit");
  if (!part("scenario").is_object() || !mechanisms.is_object())
    return fail(ErrorCode::structure, path, "The file has no objects `scenario` and `mechanisms`.", "docs/export.md shows an example.");
  Result<content::Scenario> document = content::read_scenario(json::to_text(part("scenario")), path + ", scenario");
  if (!document) return fail(std::move(document.error()));
  scenario = std::move(*document);
  for (const auto& [id, mechanism] : mechanisms.items()) {
    Result<MechanismPtr> read = formats::read_mechanism(json::to_text(mechanism), path + ", mechanism " + id);
    if (!read) return fail(std::move(read.error()));
    resources.mechanisms[id] = std::move(*read);
  }
  if (!circuit.is_null()) scenario.circuit = json::to_text(circuit);
  return {};
}

int run_new(const Options& options) {
  content::Scenario scenario;
  content::Resources resources;
  if (!options.from.empty()) {
    if (const Result<void> done = read_content_file(options.from, scenario, resources); !done)
      return print_error(done.error(), options.json);
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

void add_new_verb(CLI::App& app, Action& action) {
  auto options = std::make_shared<Options>();
  CLI::App* verb = app.add_subcommand("new", "Create a project with the sample content, or an empty one.");
  verb->add_option("project", options->path, "The file to create, *.ugoki")->required();
  verb->add_option("--name", options->name, "Name of the content");
  auto* empty = verb->add_flag("--empty", options->empty, "Without the sample content");
  verb->add_option("--from", options->from, "JSON file with scenario and mechanisms, for example from the folder examples/content")
      ->excludes(empty);
  verb->add_flag("--json", options->json, "Print one JSON object");
  verb->footer("Example:\n  ugoki new park.ugoki");
  verb->callback([options, &action] { action = [options] { return run_new(*options); }; });
}

}  // namespace ugoki::cli
