// `ugoki motion`: operations on motions, such as trim, blend, lock and cycle.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>

#include "motion_files.h"
#include "motion_torques.h"
#include "output.h"
#include "output_files.h"
#include "ugoki/base/number.h"
#include "ugoki/capture/force_plates.h"
#include "ugoki/files/files.h"
#include "ugoki/formats/c3d.h"
#include "ugoki/motion_edit/curves.h"
#include "ugoki/motion_edit/edit.h"
#include "ugoki/motion_edit/intermediate.h"
#include "ugoki/motion_edit/layers.h"
#include "ugoki/motion_edit/mirror.h"
#include "ugoki/motion_edit/root_path.h"
#include "verb.h"

namespace ugoki::cli {
namespace {

using namespace motion_edit;

/// Options that all operations of `ugoki motion` share.
struct Common {
  std::vector<std::string> inputs;
  std::string out;
  SourceOptions source;
  std::vector<std::string> feet;
  double ground = 0;
  bool find_ground = false, json = false;

  [[nodiscard]] FootContactOptions contacts() const {
    FootContactOptions o;
    o.ground = ground;
    o.find_ground = find_ground;
    return o;
  }
};
using CommonPtr = std::shared_ptr<Common>;

Result<std::vector<FootLimb>> feet_of(const Mechanism& m, const Common& c) {
  return c.feet.empty() ? Result<std::vector<FootLimb>>(find_foot_limbs(m)) : find_foot_limbs(m, c.feet);
}

/// Returns properties of a motion as JSON. If `out` is not empty, also writes the motion there and reports the destination.
Result<Json> describe(const MotionSet& set, const Motion& motion, const Common& c, const std::string& out) {
  const Mechanism& m = *set.mechanism;
  Json json = {{"name", motion.name},
               {"frames", motion.frames},
               {"rate", motion.rate},
               {"duration_s", motion.duration()},
               {"cyclic", motion.cyclic}};
  const Result<std::vector<FootLimb>> feet = feet_of(m, c);
  if (!feet) return fail(feet.error());
  if (!feet->empty()) {
    const SkateReport skate = measure_skate(m, motion, labelled_contacts(m, motion, *feet, c.contacts()));
    json["stances"] = skate.stances;
    json["foot_skate_mean_cm"] = skate.mean_cm;
    json["foot_skate_worst_cm"] = skate.worst_cm;
  }
  if (motion.frames > 1) {
    const Placement travel = cycle_of(motion, m);
    json["way_m"] = std::sqrt(travel.x * travel.x + travel.y * travel.y);
    json["speed_m_s"] = json["way_m"].get<double>() / motion.duration();
  }
  if (!out.empty()) {
    const Result<std::string> put = put_motion(m, motion, set.height, out, c.source);
    if (!put) return fail(put.error());
    json["out"] = out;
    json["written"] = *put;
  }
  return json;
}

/// Sentence about a foot that could not be locked at its position; empty if the error is below 5 mm.
std::string missed(const Json& lock, double rate) {
  if (!lock.is_object() || lock["foot_missed_m"].get<double>() < 0.005) return {};
  return "Foot " + lock["missed_at"].get<std::string>() + " misses its position by " +
         to_fixed(100 * lock["foot_missed_m"].get<double>(), 1) + " cm at " + to_fixed(lock["missed_frame"].get<int>() / rate, 2) +
         " s: its limb is too short, or a joint limit stops it.";
}

void print_summary(const Json& row) {
  std::string line = row["name"].get<std::string>() + ": " + std::to_string(row["frames"].get<int>()) + " frames, " +
                     to_fixed(row["duration_s"].get<double>(), 3) + " s" + (row["cyclic"].get<bool>() ? ", cyclic" : "");
  if (row.contains("speed_m_s")) line += ", " + to_fixed(row["speed_m_s"].get<double>(), 3) + " m/s";
  if (row.contains("foot_skate_worst_cm"))
    line += ", feet slide " + to_fixed(row["foot_skate_mean_cm"].get<double>(), 2) + " cm per stance, " +
            to_fixed(row["foot_skate_worst_cm"].get<double>(), 2) + " at worst";
  print_line(line);
  if (const std::string text = missed(row.value("lock", Json()), row["rate"].get<double>()); !text.empty()) print_line(text);
  if (row.contains("written")) print_line(row["written"].get<std::string>());
}

int finish(const MotionSet& set, const Motion& motion, const Common& c, Json more = Json::object()) {
  Result<Json> row = describe(set, motion, c, c.out);
  if (!row) return print_error(row.error(), c.json);
  row->update(more);
  (*row)["report"] = set.report;
  if (c.json) {
    print_json(*row);
  } else {
    print_summary(*row);
    for (const std::string& line : set.report) print_line(line);
  }
  return 0;
}

Json to_json(const FootLockReport& r) {
  return {{"foot_skate_before_cm", r.before.worst_cm},
          {"foot_skate_after_cm", r.after.worst_cm},
          {"pelvis_lowered_m", r.max_drop},
          {"foot_moved_m", r.max_move},
          {"foot_missed_m", r.max_miss},
          {"missed_at", r.miss_link},
          {"missed_frame", r.miss_frame}};
}

/// Refuses an output file that is an input. Outputs that are entries of the library are not checked.
Result<void> check_output(const Common& c, const std::string& out) {
  return check_outputs(input_files(c.inputs, c.source), {{"--out", writes_file(out) ? out : ""}});
}

Verb add_operation(Verb verb, const char* name, const char* what, const CommonPtr& c, int minimum, int maximum) {
  Verb command = verb.add_subcommand(name, what);
  command
      .add_option("input", c->inputs,
                  maximum > 1 ? "Motions: BVH, AMC, C3D, TRC, glTF files or names in the library"
                              : "A BVH, AMC, C3D, TRC or glTF file or a motion of the library")
      .required()
      .expected(minimum, maximum);
  add_skeleton_option(command, c->source);
  add_person_options(command, c->source);
  add_library_option(command, c->source.library);
  command.add_option("--feet", c->feet, "Links that stand on the ground (default: found automatically)").delimiter(',');
  command.add_option("--ground", c->ground, "Height of the ground, m").check(Check([](const std::string& text) {
    const std::optional<double> number = parse_double(text);
    return number && std::fabs(*number) <= 1e6 ? std::string() : "'" + text + "' is not a height in metres between -1e6 and 1e6";
  }));
  command.add_flag("--find-ground", c->find_ground, "Estimate the height of the ground from the standing feet");
  command.add_flag("--json", c->json, "Print one JSON object");
  return command;
}
void add_out(Verb command, const CommonPtr& c) {
  command.add_option("-o,--out", c->out, "Output: a .bvh or .glb file, or a name without a dot for an entry of the library");
}

/// An operation on one motion. run_by() declares the command that runs it.
using Operation = std::function<Result<Motion>(const Mechanism&, const Motion&, Json& report)>;
void run_by(Verb command, Action& action, const CommonPtr& c, Operation operation) {
  add_out(command, c);
  command.callback([c, operation = std::move(operation), &action] {
    action = [c, operation] {
      if (Result<void> may = check_output(*c, c->out); !may) return print_error(may.error(), c->json);
      const Result<MotionSet> set = load_motions(c->inputs, c->source);
      if (!set) return print_error(set.error(), c->json);
      Json more = Json::object();
      const Result<Motion> made = operation(*set->mechanism, set->motions[0], more);
      return made ? finish(*set, *made, *c, more) : print_error(made.error(), c->json);
    };
  });
}
/// An operation on two motions. run_by_pair() declares the command that runs it.
using Pair = std::function<Result<Motion>(const Mechanism&, const Motion&, const Motion&)>;
void run_by_pair(Verb command, Action& action, const CommonPtr& c, Pair operation) {
  add_out(command, c);
  command.callback([c, operation = std::move(operation), &action] {
    action = [c, operation] {
      if (Result<void> may = check_output(*c, c->out); !may) return print_error(may.error(), c->json);
      const Result<MotionSet> set = load_motions(c->inputs, c->source);
      if (!set) return print_error(set.error(), c->json);
      const Result<Motion> made = operation(*set->mechanism, set->motions[0], set->motions[1]);
      return made ? finish(*set, *made, *c) : print_error(made.error(), c->json);
    };
  });
}

/// Index of the frame closest to a time [s]. For a time outside the motion, the index is outside the motion too.
int frame_at(const Motion& m, double seconds) {
  const double frame = seconds * m.rate;
  return std::isnan(frame) ? -1 : static_cast<int>(std::lround(std::clamp(frame, -1e9, 1e9)));
}

void add_trim(Verb verb, Action& action) {
  const auto c = std::make_shared<Common>();
  Verb command = add_operation(verb, "trim", "Keep the part between two times.", c, 1, 1);
  const auto from = std::make_shared<double>(0), to = std::make_shared<double>(-1);
  command.add_option("--from", *from, "s").check(not_negative());
  command.add_option("--to", *to, "End in s (default: the end of the motion)");
  run_by(command, action, c, [from, to](const Mechanism&, const Motion& m, Json&) {
    return trim(m, frame_at(m, *from), *to < 0 ? m.frames - 1 : frame_at(m, *to));
  });
}

void add_simple(Verb verb, Action& action) {
  const auto backwards = std::make_shared<Common>(), image = std::make_shared<Common>(), other = std::make_shared<Common>();
  run_by(add_operation(verb, "reverse", "Reverse the motion in time.", backwards, 1, 1), action, backwards,
         [](const Mechanism&, const Motion& m, Json&) { return Result<Motion>(reverse(m)); });
  run_by(add_operation(verb, "mirror", "Exchange left and right.", image, 1, 1), action, image,
         [](const Mechanism& mechanism, const Motion& m, Json&) { return mirror(mechanism, m); });
  Verb command = add_operation(verb, "resample", "Change the frame rate.", other, 1, 1);
  const auto rate = std::make_shared<double>(0);
  command.add_option("--rate", *rate, "Frames per second").required();
  run_by(command, action, other, [rate](const Mechanism& mechanism, const Motion& m, Json&) { return resample(mechanism, m, *rate); });
}

void add_scale(Verb verb, Action& action) {
  const auto c = std::make_shared<Common>();
  Verb command = add_operation(verb, "scale", "Scale travelled distances or the duration.", c, 1, 1);
  const auto o = std::make_shared<ScaleOptions>();
  command.add_option("--length", o->length, "Factor of the root's travel and of sliding joints").capture_default_str();
  command.add_option("--time", o->time, "Factor of the duration").capture_default_str();
  command.add_flag("--froude", o->froude, "Scale time with the square root of length (Froude)");
  run_by(command, action, c, [o](const Mechanism& mechanism, const Motion& m, Json&) { return scale(mechanism, m, *o); });
}

void add_warp(Verb verb, Action& action) {
  const auto c = std::make_shared<Common>();
  Verb command = add_operation(verb, "warp", "Change the speed over time by a monotone curve.", c, 1, 1);
  const auto points = std::make_shared<std::vector<std::pair<double, double>>>();
  command.add_option("--point", *points, "New time and the time of the original motion, s; two or more points").required();
  run_by(command, action, c, [points](const Mechanism& mechanism, const Motion& m, Json&) {
    std::vector<TimePoint> curve;
    for (const auto& [time, source] : *points) curve.push_back({time, source});
    return time_warp(mechanism, m, curve);
  });
  command.footer("Example:\n  ugoki motion warp walk.bvh --point 0 0 --point 1 0.5 --point 2 2 -o slow-start.bvh");
}

void add_join(Verb verb, Action& action) {
  const auto c = std::make_shared<Common>();
  Verb command = add_operation(verb, "join", "Join two motions, one after the other.", c, 2, 2);
  const auto o = std::make_shared<JoinOptions>();
  const auto stay = std::make_shared<bool>(false);
  command.add_option("--blend", o->blend, "Duration of the transition, s").capture_default_str();
  command.add_flag("--where-it-is", *stay, "Leave the second motion where it was recorded");
  run_by_pair(command, action, c, [o, stay](const Mechanism& mechanism, const Motion& a, const Motion& b) {
    JoinOptions options = *o;
    options.where_it_ends = !*stay;
    return join(mechanism, a, b, options);
  });
}

struct Layer {
  std::vector<std::string> mask;
  LayerOptions options;
};
/// Parses "arm:0.5" into link and weight. The last colon separates them if a number follows it.
std::vector<MaskEntry> entries_of(const std::vector<std::string>& mask) {
  std::vector<MaskEntry> out;
  for (const std::string& text : mask) {
    const auto colon = text.rfind(':');
    const std::optional<double> weight = colon == std::string::npos ? std::nullopt : parse_double(std::string_view(text).substr(colon + 1));
    out.push_back({weight ? text.substr(0, colon) : text, weight.value_or(1), true});
  }
  return out;
}

void add_layers(Verb verb, Action& action) {
  for (const bool additive : {false, true}) {
    const auto c = std::make_shared<Common>();
    Verb command = add_operation(verb, additive ? "layer" : "mix",
                                 additive ? "Add the second motion's change relative to its first frame to the first motion."
                                          : "Replace joints of the first motion by those of the second.",
                                 c, 2, 2);
    const auto layer = std::make_shared<Layer>();
    command
        .add_option("--joints", layer->mask,
                    "Links (names or labels) with their descendants, each with an optional :WEIGHT (default: all links)")
        .delimiter(',');
    command.add_option("--weight", layer->options.weight, "Weight of the layer").capture_default_str();
    command.add_option("--at", layer->options.offset, "Time at which the second motion begins, s").capture_default_str();
    command.add_option("--fade", layer->options.fade, "Duration of fading in and out, s").capture_default_str();
    run_by_pair(command, action, c, [layer, additive](const Mechanism& mechanism, const Motion& a, const Motion& b) -> Result<Motion> {
      const Result<JointMask> mask = make_mask(mechanism, entries_of(layer->mask));
      if (!mask) return fail(mask.error());
      return additive ? add_layer(mechanism, a, b, *mask, layer->options) : mix_joints(mechanism, a, b, *mask, layer->options);
    });
  }
}

void add_contacts(Verb verb, Action& action) {
  const auto c = std::make_shared<Common>();
  Verb command = add_operation(verb, "contacts", "Report when each foot stands and how far it slides.", c, 1, 1);
  command.callback([c, &action] {
    action = [c] {
      const Result<MotionSet> set = load_motions(c->inputs, c->source);
      if (!set) return print_error(set.error(), c->json);
      const Mechanism& m = *set->mechanism;
      const Motion& motion = set->motions[0];
      Result<std::vector<FootLimb>> feet = feet_of(m, *c);
      if (!feet) return print_error(feet.error(), c->json);
      const FootContacts contacts = find_contacts(m, motion, *feet, c->contacts());
      Json rows = Json::array();
      std::vector<std::vector<std::string>> table = {{"foot", "from s", "to s", "frames"}};
      for (std::size_t k = 0; k < contacts.feet.size(); ++k)
        for (const Stance& s : contacts.stances(k)) {
          const std::string& name = m.link(contacts.feet[k].link).name;
          rows.push_back({{"foot", name}, {"first", s.first}, {"last", s.last}});
          table.push_back(
              {name, to_fixed(s.first / motion.rate, 3), to_fixed(s.last / motion.rate, 3), std::to_string(s.last - s.first + 1)});
        }
      const SkateReport skate = measure_skate(m, motion, contacts);
      if (c->json) {
        print_json({{"name", motion.name},
                    {"ground_m", contacts.ground},
                    {"contacts", rows},
                    {"foot_skate_mean_cm", skate.mean_cm},
                    {"foot_skate_worst_cm", skate.worst_cm}});
        return 0;
      }
      print_table(table);
      print_line("Feet slide " + to_fixed(skate.mean_cm, 2) + " cm per stance, " + to_fixed(skate.worst_cm, 2) + " cm at worst.");
      return 0;
    };
  });
}

void add_lock(Verb verb, Action& action) {
  const auto c = std::make_shared<Common>();
  Verb command = add_operation(verb, "lock", "Keep standing feet at fixed positions.", c, 1, 1);
  const auto o = std::make_shared<FootLockOptions>();
  command.add_option("--ease", o->ease, "Time before and after a stance in which the correction fades, s").capture_default_str();
  command.add_option("--stretch", o->stretch, "Maximum extension of a leg, as a fraction of its length")
      .capture_default_str()
      .check(range(0.5, 1.0));
  run_by(command, action, c, [c, o](const Mechanism& m, const Motion& motion, Json& more) -> Result<Motion> {
    Result<std::vector<FootLimb>> feet = feet_of(m, *c);
    if (!feet) return fail(feet.error());
    FootLockReport report;
    Result<Motion> locked = lock_feet(m, motion, find_contacts(m, motion, *feet, c->contacts()), *o, &report);
    more = {{"lock", to_json(report)}};
    return locked;
  });
}

void add_cycle(Verb verb, Action& action) {
  const auto c = std::make_shared<Common>();
  Verb command = add_operation(verb, "cycle", "Extract one cycle that repeats without a seam.", c, 1, 1);
  const auto from = std::make_shared<double>(-1), to = std::make_shared<double>(-1);
  const auto slide = std::make_shared<bool>(false);
  command.add_option("--from", *from, "Begin of the cycle, s (default: the best cycle is found)");
  command.add_option("--to", *to, "s");
  command.add_flag("--no-lock", *slide, "Do not lock the feet");
  run_by(command, action, c, [c, from, to, slide](const Mechanism& m, const Motion& motion, Json& more) -> Result<Motion> {
    CycleOptions o;
    o.contacts = c->contacts();
    o.lock_feet = !*slide;
    if (*from >= 0 && *to >= 0) {
      o.first = frame_at(motion, *from);
      o.last = frame_at(motion, *to);
    }
    CycleReport r;
    Result<Motion> cycle = make_cyclic(m, motion, o, &r);
    more = {{"first", r.first}, {"last", r.last}, {"seam_rad", r.seam}, {"stride", r.by_contacts}, {"lock", to_json(r.feet)}};
    return cycle;
  });
}

struct BlendChoice {
  std::vector<double> weights, shares;
};

/// Name of an output: "jog.bvh" for a single motion, "jog-25.bvh" for one of several.
std::string numbered(const std::string& out, double percent, bool several) {
  if (!several || out.empty()) return out;
  const std::filesystem::path path(out);
  const std::string number = "-" + to_text(percent);
  return (path.parent_path() / (path.stem().string() + number + path.extension().string())).string();
}

int run_blend(const Common& c, const BlendChoice& choice) {
  if (Result<void> may = check_output(c, c.out); !may) return print_error(may.error(), c.json);
  for (const double percent : choice.shares)
    if (Result<void> may = check_output(c, numbered(c.out, percent, choice.shares.size() > 1)); !may)
      return print_error(may.error(), c.json);
  const Result<MotionSet> set = load_motions(c.inputs, c.source);
  if (!set) return print_error(set.error(), c.json);
  IntermediateOptions options;
  options.feet = c.feet;
  options.cycle.contacts = c.contacts();
  std::vector<const Motion*> sources;
  for (const Motion& m : set->motions) sources.push_back(&m);
  const Result<Intermediate> between = Intermediate::make(*set->mechanism, sources, options);
  if (!between) return print_error(between.error(), c.json);
  std::vector<std::pair<double, std::vector<double>>> wanted;
  for (const double percent : choice.shares) wanted.push_back({percent, {1 - percent / 100, percent / 100}});
  if (wanted.empty()) wanted.push_back({0, choice.weights.empty() ? std::vector<double>(sources.size(), 1.0) : choice.weights});
  Json rows = Json::array();
  for (const auto& [percent, weights] : wanted) {
    FootLockReport lock;
    const Result<Motion> motion = between->blend(weights, &lock);
    if (!motion) return print_error(motion.error(), c.json);
    Result<Json> row = describe(*set, *motion, c, numbered(c.out, percent, wanted.size() > 1));
    if (!row) return print_error(row.error(), c.json);
    (*row)["weights"] = weights;
    (*row)["speed_m_s"] = between->facts(*motion).speed;
    (*row)["lock"] = to_json(lock);
    rows.push_back(std::move(*row));
  }
  Json cycles = Json::array();
  for (int i = 0; i < between->count(); ++i)
    cycles.push_back({{"name", set->motions[static_cast<std::size_t>(i)].name},
                      {"first", between->cycle_report(i).first},
                      {"last", between->cycle_report(i).last}});
  if (c.json) {
    print_json({{"motions", rows}, {"cycles", cycles}, {"by_contacts", between->by_contacts()}, {"report", set->report}});
    return 0;
  }
  for (const Json& row : rows) print_summary(row);
  for (const std::string& line : set->report) print_line(line);
  return 0;
}

void add_blend(Verb verb, Action& action) {
  const auto c = std::make_shared<Common>();
  Verb command = add_operation(verb, "blend", "Blend two or more cyclic motions into an intermediate motion.", c, 1, 16);
  add_out(command, c);
  const auto choice = std::make_shared<BlendChoice>();
  const Option weights =
      command.add_option("--weights", choice->weights, "Weight of each motion, separated by commas (default: equal)").delimiter(',');
  command.add_option("--at", choice->shares, "Percentage of the second of two motions; several values make several motions")
      .delimiter(',')
      .check(range(0.0, 100.0))
      .excludes(weights);
  command.callback([c, choice, &action] {
    if (!choice->shares.empty() && c->inputs.size() != 2) refuse("--at", "needs two motions; use --weights.");
    action = [c, choice] { return run_blend(*c, *choice); };
  });
  command.footer(
      "Example:\n  ugoki motion blend walk.bvh run.bvh --at 50 -o jog.bvh\n  ugoki motion blend walk run --at 0,25,50,75,100 -o gait.bvh");
}

void add_path(Verb verb, Action& action) {
  const auto c = std::make_shared<Common>();
  Verb command = add_operation(verb, "path", "Bend the path over the ground along a curve.", c, 1, 1);
  const auto points = std::make_shared<std::vector<std::pair<double, double>>>();
  const auto stretch = std::make_shared<bool>(false);
  command.add_option("--point", *points, "x and y in m; two or more").required();
  command.add_flag("--stretch", *stretch, "Scale the path to the length of the curve (default: keep the length of the steps)");
  run_by(command, action, c, [c, points, stretch](const Mechanism& m, const Motion& motion, Json& more) {
    std::vector<PathPoint> curve;
    for (const auto& [x, y] : *points) curve.push_back({x, y});
    RootPathOptions o;
    o.keep_speed = !*stretch;
    o.contacts = c->contacts();
    FootLockReport r;
    Result<Motion> bent = bend_path(m, motion, curve, o, &r);
    more = {{"lock", to_json(r)}};
    return bent;
  });
}

void add_reduce(Verb verb, Action& action) {
  const auto c = std::make_shared<Common>();
  Verb command = add_operation(verb, "reduce", "Reduce the number of keys within an error bound.", c, 1, 1);
  const auto o = std::make_shared<ReduceOptions>();
  command.add_option("--degrees", o->degrees, "Maximum rotation error of a joint, degrees").capture_default_str();
  command.add_option("--metres", o->metres, "Maximum translation error, m").capture_default_str();
  run_by(command, action, c, [o](const Mechanism& m, const Motion& motion, Json& more) -> Result<Motion> {
    const Result<MotionCurves> curves = reduce_keys(m, motion, *o);
    if (!curves) return fail(curves.error());
    more = {{"keys", curves->key_count()}, {"keys_before", static_cast<int>(curves->curves.size()) * motion.frames}};
    return to_motion(m, *curves);
  });
}

void add_forces(Verb verb, Action& action) {
  const auto c = std::make_shared<Common>();
  Verb command = add_operation(verb, "forces", "Calculate contact forces from the force plates of a C3D file.", c, 1, 1);
  const auto o = std::make_shared<capture::ForcePlateOptions>();
  command.add_option("--cutoff", o->cutoff, "Cutoff frequency of the low-pass filter, Hz; 0: no filter").capture_default_str();
  command.add_option("--threshold", o->threshold, "Forces below this are zero, N").capture_default_str();
  command.callback([c, o, &action] {
    action = [c, o] {
      const Result<std::string> bytes = files::read_file(c->inputs[0]);
      if (!bytes) return print_error(bytes.error(), c->json);
      const Result<MarkerMotion> markers =
          formats::read_c3d({reinterpret_cast<const std::byte*>(bytes->data()), bytes->size()}, c->inputs[0]);
      if (!markers) return print_error(markers.error(), c->json);
      const Result<capture::ForceRecording> forces = capture::calc_contact_forces(*markers, *o);
      if (!forces) return print_error(forces.error(), c->json);
      Json rows = Json::array();
      std::vector<std::vector<std::string>> table = {{"plate", "from s", "to s", "max N", "impulse N s"}};
      for (const capture::PlateStep& s : capture::find_plate_steps(*markers, *forces, {})) {
        const auto& row = forces->plates[static_cast<std::size_t>(s.plate)];
        double maximum = 0, impulse = 0;
        Json samples = Json::array();
        for (int f = s.first; f <= s.last; ++f) {
          const capture::PlateForce& p = row[static_cast<std::size_t>(f)];
          maximum = std::max(maximum, p.force.z);
          impulse += p.force.z / markers->rate;
          samples.push_back({p.force.x, p.force.y, p.force.z, p.centre.x, p.centre.y, p.centre.z, p.free_moment});
        }
        rows.push_back({{"plate", s.plate + 1}, {"first", s.first}, {"last", s.last}, {"force_centre_moment", samples}});
        table.push_back({std::to_string(s.plate + 1), to_fixed(s.first / markers->rate, 3), to_fixed(s.last / markers->rate, 3),
                         to_fixed(maximum, 1), to_fixed(impulse, 2)});
      }
      if (c->json) {
        print_json({{"rate", markers->rate}, {"steps", rows}, {"report", forces->report}});
        return 0;
      }
      print_table(table);
      for (const std::string& line : forces->report) print_line(line);
      return 0;
    };
  });
}

}  // namespace

void add_motion_verb(Verb app, Action& action) {
  Verb verb = app.add_subcommand("motion", "Operations on motions: blend, cycle, lock, trim, join, mirror, ...");
  verb.require_subcommand(1);
  add_blend(verb, action);
  add_contacts(verb, action);
  add_cycle(verb, action);
  add_forces(verb, action);
  add_join(verb, action);
  add_layers(verb, action);
  add_lock(verb, action);
  add_path(verb, action);
  add_reduce(verb, action);
  add_scale(verb, action);
  add_simple(verb, action);
  add_torque_operations(verb, action);
  add_trim(verb, action);
  add_warp(verb, action);
  verb.footer("Example:\n  ugoki motion blend walk.bvh run.bvh --at 50 -o jog.bvh\n  ugoki motion lock jump.bvh -o still-feet.bvh");
}

}  // namespace ugoki::cli
