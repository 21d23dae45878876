#include "motion_torques.h"

#include <memory>

#include "output.h"
#include "output_files.h"
#include "sources.h"
#include "ugoki/base/number.h"
#include "ugoki/content/torque_conversion.h"
#include "ugoki/project/project.h"

namespace ugoki::cli {
namespace {

struct Options {
  std::string target, out;
  SourceOptions source;
  content::ConversionOptions conversion;
  double step_rate = 500, assist_limit = -1;
  bool json = false;
};

Json to_json(const content::ConversionReport& c) {
  return {{"character", c.character},
          {"motion", c.motion},
          {"deviation_rms_deg", c.deviation.rms_deg},
          {"deviation_max_deg", c.deviation.max_deg},
          {"root_deviation_deg", c.deviation.root_deg},
          {"root_deviation_mm", c.deviation.root_mm},
          {"root_force_rms_bw", c.root_rms_bw},
          {"root_force_max_bw", c.root_max_bw},
          {"torques_over_effort", c.over_effort}};
}

std::string words(const content::ConversionReport& c, bool torques) {
  std::string text = c.character + ": " + to_fixed(c.deviation.rms_deg, 3) + " deg rms, " + to_fixed(c.deviation.max_deg, 2) +
                     " deg at most from the " + (torques ? "track" : "run") + "; root " + to_fixed(c.deviation.root_deg, 2) + " deg, " +
                     to_fixed(c.deviation.root_mm, 1) + " mm.";
  if (!torques) return text;
  return text + " Force on the root that no joint supplies: " + to_fixed(c.root_rms_bw, 4) + " body weights rms, " +
         to_fixed(c.root_max_bw, 3) + " at most. Torques beyond the limit of their joint: " + to_fixed(100 * c.over_effort, 2) + " %.";
}

/// Writes the project and prints the reports.
int finish(const Options& o, const content::ConvertedContent& content, const std::vector<content::ConversionReport>& characters,
           const bool* replays) {
  const Result<project::Project> made = project::Project::create(o.out, content.scenario, content.resources);
  if (!made) return print_error(made.error(), o.json);
  if (o.json) {
    Json rows = Json::array();
    for (const content::ConversionReport& c : characters) rows.push_back(to_json(c));
    Json json = {{"project", o.out}, {"characters", rows}};
    if (replays) json["replays_bit_for_bit"] = *replays;
    print_json(json);
    return 0;
  }
  for (const content::ConversionReport& c : characters) print_line(words(c, replays != nullptr));
  if (replays)
    print_line(*replays ? "The torques replay bit for bit." : "The replay of the torques has other bits than their computation.");
  print_line("Created " + o.out + ".");
  return 0;
}

int run_conversion(Options o, bool torques) {
  if (Result<void> may = check_outputs(input_files(o.target, o.source), {{"-o", o.out}}); !may) return print_error(may.error(), o.json);
  Result<SceneSource> scene = load_scene(o.target, o.source, 1 / o.step_rate);
  if (!scene) return print_error(scene.error(), o.json);
  if (o.assist_limit >= 0)
    for (content::ScenarioCharacter& c : scene->scenario.characters) c.control.assist_limit = o.assist_limit;
  catch_interrupt();
  Progress progress("motion " + std::string(torques ? "torques " : "angles ") + scene->name);
  o.conversion.progress = [&](double done) {
    progress.show(done);
    return !interrupted();
  };
  if (torques) {
    const Result<content::TorqueConversion> made = content::to_torques(scene->scenario, scene->resources, o.conversion);
    progress.clear();
    return made ? finish(o, made->content, made->characters, &made->replays) : print_error(made.error(), o.json);
  }
  const Result<content::AngleConversion> made = content::to_angles(scene->scenario, scene->resources, o.conversion);
  progress.clear();
  return made ? finish(o, made->content, made->characters, nullptr) : print_error(made.error(), o.json);
}

Verb add_operation(Verb motion, const char* name, const char* doc, const std::shared_ptr<Options>& o) {
  Verb verb = motion.add_subcommand(name, doc);
  verb.add_option("target", o->target, "Project, motion file, or motion of the library").required();
  verb.add_option("-o,--out", o->out, "Project (*.ugoki) to create").required().type_name("FILE");
  verb.add_option("--duration", o->conversion.duration, "Seconds to convert (default: the duration of the scenario)")
      .check(range(0.001, 86400.0));
  add_library_option(verb, o->source.library);
  verb.add_option("--skeleton", o->source.asf, "Skeleton (*.asf) of an AMC file");
  verb.add_flag("--json", o->json, "Print one JSON object");
  return verb;
}

}  // namespace

void add_torque_operations(Verb motion, Action& action) {
  const auto to = std::make_shared<Options>(), back = std::make_shared<Options>();
  Verb torques = add_operation(motion, "torques", "Convert tracks to joint torques from a first state.", to);
  torques.add_flag("--own-control", to->conversion.own_control,
                   "Drive the characters with the control of the content (default: servos follow the coordinates exactly)");
  torques.add_option("--assist-limit", to->assist_limit, "Limit of the root assist of all characters, body weights; with --own-control")
      .check(range(0.0, 10.0));
  torques.add_option("--rate", to->step_rate, "Steps per second of a motion that is not part of a project")
      .check(range(250.0, 2000.0))
      .capture_default_str();
  torques.footer("Example:\n  ugoki motion torques walk.bvh --own-control --assist-limit 0 -o walk-torques.ugoki");
  torques.callback([to, &action] { action = [to] { return run_conversion(*to, true); }; });
  Verb angles = add_operation(motion, "angles", "Convert torque-oriented motions to coordinates.", back);
  angles.add_option("--rate", back->conversion.rate, "Frames per second of the coordinates (default: one for each step)")
      .check(range(10.0, 2000.0));
  angles.footer("Example:\n  ugoki motion angles walk-torques.ugoki -o walk-angles.ugoki");
  angles.callback([back, &action] { action = [back] { return run_conversion(*back, false); }; });
}

}  // namespace ugoki::cli
