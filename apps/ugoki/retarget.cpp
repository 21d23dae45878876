// `ugoki retarget`: transfers a motion to another body, animal or robot.

#include "ugoki/retarget/retarget.h"

#include <memory>

#include "motion_files.h"
#include "output.h"
#include "output_files.h"
#include "sources.h"
#include "target_body.h"
#include "ugoki/base/number.h"
#include "ugoki/files/files.h"
#include "ugoki/formats/mechanism_json.h"
#include "verb.h"

namespace ugoki::cli {
namespace {

struct Options {
  std::string motion, to, mapping, out, mechanism_out;
  double height = 0, path_scale = 0, gait_phase = 0.5;
  bool free_feet = false, free_hands = false, balance = false, slow = false, strict = false, json = false;
  SourceOptions source;
};

Result<retarget::RetargetOptions> retarget_options(const Options& o) {
  retarget::RetargetOptions out;
  out.keep_contacts = !o.free_feet;
  out.keep_holds = !o.free_hands;
  out.path_scale = o.path_scale;
  out.gait_phase = o.gait_phase;
  out.slow_down = o.slow;
  out.balance = o.balance;
  if (o.mapping.empty()) return out;
  const Result<std::string> text = files::read_file(o.mapping);
  if (!text) return fail(text.error());
  Result<retarget::Mapping> mapping = retarget::read_mapping(*text, o.mapping);
  if (!mapping) return fail(std::move(mapping.error()));
  out.mapping = std::move(*mapping);
  return out;
}

Json to_json(const retarget::RetargetReport& r) {
  Json misses = Json::array(), limits = Json::array();
  for (const retarget::Miss& m : r.misses)
    misses.push_back({{"link", m.link}, {"max_mm", 1000 * m.maximum}, {"frame", m.frame}, {"frames", m.frames}});
  for (const auto& [link, frames] : r.at_limit) limits.push_back({{"link", link}, {"frames", frames}});
  Json out = {{"scale", r.scale},
              {"stances", r.stances},
              {"worst_skate_cm", 100 * r.skate_after},
              {"worst_skate_without_goals_cm", 100 * r.skate_before},
              {"root_shift_mm", 1000 * r.max_shift},
              {"root_shift_frame", r.shift_frame},
              {"misses", misses},
              {"at_limit", limits},
              {"slowed", r.slowed},
              {"holds", r.holds},
              {"mapping", r.mapping},
              {"notes", r.notes}};
  if (!r.margin_link.empty()) out["min_margin"] = {{"link", r.margin_link}, {"value", r.min_margin}};
  if (r.max_speed > 0) out["max_speed"] = {{"link", r.speed_link}, {"share", r.max_speed}};
  return out;
}

int run_retarget(const Options& o) {
  std::vector<NamedFile> inputs = input_files(o.motion, o.source);
  inputs.push_back({"--to", o.to});
  inputs.push_back({"--mapping", o.mapping});
  if (Result<void> may = check_outputs(inputs, {{"--out", writes_file(o.out) ? o.out : ""}, {"--mechanism-out", o.mechanism_out}}); !may)
    return print_error(may.error(), o.json);
  const Result<ClipSource> clip = load_clip(o.motion, o.source);
  if (!clip) return print_error(clip.error(), o.json);
  const Result<MechanismPtr> target = load_body(o.to, o.height, o.source);
  if (!target) return print_error(target.error(), o.json);
  const Result<retarget::RetargetOptions> options = retarget_options(o);
  if (!options) return print_error(options.error(), o.json);
  const Result<retarget::Retargeted> out = retarget::retarget(clip->mechanism, *clip->motion, *target, *options);
  if (!out) return print_error(out.error(), o.json);
  std::vector<std::string> written;
  if (!o.out.empty()) {
    const Result<std::string> put = put_motion(**target, out->motion, o.height, o.out, o.source);
    if (!put) return print_error(put.error(), o.json);
    written.push_back(*put);
  }
  if (!o.mechanism_out.empty()) {
    if (const Result<void> put = files::write_file(o.mechanism_out, formats::write_mechanism(**target)); !put)
      return print_error(put.error(), o.json);
    written.push_back("Mechanism written to " + o.mechanism_out + ".");
  }
  if (o.json) {
    Json json = to_json(out->report);
    json["clip"] = clip->name;
    json["frames"] = out->motion.frames;
    json["rate"] = out->motion.rate;
    json["written"] = written;
    print_json(json);
  } else {
    for (const std::string& line : retarget::describe(out->report)) print_line(line);
    print_line("Mapping of links:");
    for (const std::string& line : out->report.mapping) print_line("  " + line);
    for (const std::string& line : written) print_line(line);
  }
  return o.strict && !out->report.misses.empty() ? 1 : 0;
}

}  // namespace

void add_retarget_verb(Verb app, Action& action) {
  auto o = std::make_shared<Options>();
  Verb verb = app.add_subcommand("retarget", "Transfer a motion to another body, animal or robot.");
  verb.add_option("motion", o->motion, "BVH, AMC, C3D, TRC, glTF or GLB file, or a motion of the library").required();
  const Option to =
      verb.add_option("--to", o->to, "Target: mechanism file (JSON, URDF, SDF, MJCF), measured file, entry of the library, human or dog");
  const Option height = verb.add_option("--height", o->height, "Target: a person of this height in m").check(range(0.8, 5.0));
  to.excludes(height);
  verb.add_option("-o,--out", o->out, "Output: a .bvh or .glb file, or the name of a new entry in the library");
  verb.add_option("--mechanism-out", o->mechanism_out, "Also write the mechanism, as JSON");
  verb.add_option("--mapping", o->mapping, "JSON file that maps links (docs/retarget.md)");
  verb.add_option("--path-scale", o->path_scale, "Factor of the path over the ground (default: ratio of leg lengths)")
      .check(range(0.01, 100.0));
  verb.add_option("--gait-phase", o->gait_phase,
                  "Two legs to four: delay of the fore legs after the hind legs of their side, as a fraction of a stride")
      .check(range(0.0, 1.0))
      .capture_default_str();
  verb.add_flag("--free-feet", o->free_feet, "Transfer joint rotations only; feet may slide");
  verb.add_flag("--free-hands", o->free_hands, "Do not constrain hands that hold an object");
  verb.add_flag("--balance", o->balance, "Keep the centre of mass over the standing feet (slow motions)");
  verb.add_flag("--slow", o->slow, "Slow the motion down until no joint is faster than the mapping allows");
  verb.add_flag("--strict", o->strict, "Exit status 1 if a standing foot or a holding hand misses its position by more than 1 mm");
  add_skeleton_option(verb, o->source);
  add_robot_options(verb, o->source.robot);
  add_library_option(verb, o->source.library);
  verb.add_flag("--json", o->json, "Print one JSON object");
  verb.footer(
      "Example:\n  ugoki retarget walk.bvh --height 1.1 -o child.bvh\n  ugoki retarget walk.bvh --to robot.urdf --json\n  ugoki retarget "
      "walk.bvh --to dog -o dog.glb");
  verb.callback([o, &action] {
    if (o->to.empty() && !(o->height > 0)) refuse("--to", "or --height is required.");
    action = [o] { return run_retarget(*o); };
  });
}

}  // namespace ugoki::cli
