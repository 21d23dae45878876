// Operations on motions as software LSIs (function blocks). When the circuit is built, each LSI applies an operation to a clip of a
// character's track; then it plays the resulting motion.

#include "ugoki/lsi/motion_lsi.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/number.h"
#include "ugoki/motion_edit/curves.h"
#include "ugoki/motion_edit/cycle.h"
#include "ugoki/motion_edit/edit.h"
#include "ugoki/motion_edit/layers.h"
#include "ugoki/motion_edit/mirror.h"
#include "ugoki/motion_edit/root_path.h"

namespace ugoki::lsi {
namespace {

using namespace motion_edit;

/// Arguments of an operation: the mechanism, the motion of one clip or two, and the LSI's parameters.
struct Given {
  const Mechanism& m;
  const Motion& motion;
  const Motion* second;
  const Setup& setup;
  [[nodiscard]] double number(const char* parameter) const { return setup.number(parameter); }
  [[nodiscard]] int frame(double seconds) const { return static_cast<int>(std::floor(seconds * motion.rate + 0.5)); }
};
using Operation = Result<Motion> (*)(const Given&);

/// Reads the pairs of numbers in the text parameter `parameter`.
Result<std::vector<std::pair<double, double>>> pairs_of(const Given& g, const char* parameter) {
  std::vector<double> numbers;
  if (!parse_numbers(g.setup.text(parameter), numbers) || numbers.size() % 2 != 0)
    return fail(ErrorCode::syntax, parameter, "'" + g.setup.text(parameter) + "' is not a list of pairs of numbers.",
                "Write for example 0 0, 1 0.5.");
  std::vector<std::pair<double, double>> out;
  for (std::size_t i = 0; i < numbers.size(); i += 2) out.emplace_back(numbers[i], numbers[i + 1]);
  return out;
}

Result<JointMask> mask_of(const Given& g) {
  std::vector<MaskEntry> entries;
  std::string word;
  for (const char c : g.setup.text("joints") + ",") {
    if (c != ',') {
      if (c != ' ' || !word.empty()) word += c;
      continue;
    }
    while (!word.empty() && word.back() == ' ') word.pop_back();
    if (!word.empty()) entries.push_back({word, 1, true});
    word.clear();
  }
  return make_mask(g.m, entries);
}
LayerOptions layer_of(const Given& g) { return {g.number("weight"), g.number("offset"), g.number("fade")}; }

Result<Motion> do_trim(const Given& g) {
  const double to = g.number("to");
  return trim(g.motion, g.frame(g.number("from")), to > 0 ? g.frame(to) : g.motion.frames - 1);
}
Result<Motion> do_join(const Given& g) { return join(g.m, g.motion, *g.second, {.blend = g.number("blend")}); }
Result<Motion> do_cycle(const Given& g) {
  CycleOptions o;
  if (g.number("to") > 0) {
    o.first = g.frame(g.number("from"));
    o.last = g.frame(g.number("to"));
  }
  return make_cyclic(g.m, g.motion, o);
}
Result<Motion> do_warp(const Given& g) {
  const auto pairs = pairs_of(g, "points");
  if (!pairs) return fail(pairs.error());
  std::vector<TimePoint> points;
  for (const auto& [time, source] : *pairs) points.push_back({time, source});
  return time_warp(g.m, g.motion, points);
}
Result<Motion> do_mirror(const Given& g) { return mirror(g.m, g.motion); }
Result<Motion> do_reverse(const Given& g) { return reverse(g.motion); }
Result<Motion> do_resample(const Given& g) { return resample(g.m, g.motion, g.number("rate")); }
Result<Motion> do_scale(const Given& g) { return scale(g.m, g.motion, {.length = g.number("length"), .time = g.number("time")}); }
Result<Motion> do_path(const Given& g) {
  const auto pairs = pairs_of(g, "points");
  if (!pairs) return fail(pairs.error());
  std::vector<PathPoint> points;
  for (const auto& [x, y] : *pairs) points.push_back({x, y});
  return bend_path(g.m, g.motion, points);
}
Result<Motion> do_layer(const Given& g) {
  const auto mask = mask_of(g);
  if (!mask) return fail(mask.error());
  return add_layer(g.m, g.motion, *g.second, *mask, layer_of(g));
}
Result<Motion> do_mix(const Given& g) {
  const auto mask = mask_of(g);
  if (!mask) return fail(mask.error());
  return mix_joints(g.m, g.motion, *g.second, *mask, layer_of(g));
}
Result<Motion> do_contacts(const Given& g) {
  Motion out = g.motion;
  set_labels(g.m, find_contacts(g.m, g.motion), out);
  return out;
}
Result<Motion> do_lock(const Given& g) { return lock_feet(g.m, g.motion, find_contacts(g.m, g.motion)); }
Result<Motion> do_reduce(const Given& g) {
  const auto curves = reduce_keys(g.m, g.motion, {g.number("degrees"), g.number("metres")});
  if (!curves) return fail(curves.error());
  return to_motion(g.m, *curves);
}

/// Declaration of one LSI of this file.
struct Row {
  const char* name;
  const char* doc;
  Operation operation;
  bool pair;  ///< true: the operation takes two motions
  std::vector<circuit::Parameter> parameters;
};

const std::vector<Row>& rows() {
  const auto s = [](const char* name, const char* doc) { return number_parameter(name, 0, 0, 1e6, "s", doc); };
  static const std::vector<Row> all = {
      {"motion trim",
       "Plays the part of a clip between two times.",
       do_trim,
       false,
       {s("from", "Start time in the clip."), s("to", "End time in the clip; 0: end of the clip.")}},
      {"motion join",
       "Plays one clip after another; the second starts at the position where the first ends.",
       do_join,
       true,
       {number_parameter("blend", 0.3, 0, 100, "s", "Duration of the transition.")}},
      {"motion cycle",
       "Repeats a cycle of a clip without end, with standing feet fixed to the ground.",
       do_cycle,
       false,
       {s("from", "Start time of the cycle, if `to` is given."), s("to", "End time of the cycle; 0: the best cycle is searched.")}},
      {"motion warp",
       "Plays a clip with its time warped by a monotone curve.",
       do_warp,
       false,
       {text_parameter("points", "Pairs of output time and clip time, s: '0 0, 1 0.5, 2 2'.")}},
      {"motion mirror", "Plays a clip with left and right exchanged.", do_mirror, false, {}},
      {"motion reverse", "Plays a clip backwards.", do_reverse, false, {}},
      {"motion resample",
       "Plays a clip resampled to another frame rate.",
       do_resample,
       false,
       {number_parameter("rate", 60, 1, 1e5, "1/s", "Frames per second.")}},
      {"motion scale",
       "Plays a clip with its distances and duration scaled.",
       do_scale,
       false,
       {number_parameter("length", 1, 1e-3, 1e3, "1", "Factor on distances."),
        number_parameter("time", 1, 1e-3, 1e3, "1", "Factor on the duration.")}},
      {"motion path",
       "Plays a clip along another path on the ground, with standing feet fixed.",
       do_path,
       false,
       {text_parameter("points", "Points x y of the path, m: '0 0, 2 0, 3 1'.")}},
      {"motion layer", "Plays a clip and adds to it the change of a second clip relative to that clip's first frame.", do_layer, true, {}},
      {"motion mix", "Plays a clip with some joints replaced by those of a second clip.", do_mix, true, {}},
      {"foot contacts", "Plays a clip with its foot contacts detected again.", do_contacts, false, {}},
      {"foot lock", "Plays a clip with standing feet fixed to the ground.", do_lock, false, {}},
      {"motion reduce",
       "Plays a clip reduced to few key frames within an error bound.",
       do_reduce,
       false,
       {number_parameter("degrees", 0.25, 1e-6, 180, "deg", "Maximum error of a joint angle."),
        number_parameter("metres", 0.001, 1e-9, 10, "m", "Maximum error of a position.")}},
  };
  return all;
}

const Row* row_of(const Setup& s) {
  for (const Row& row : rows())
    if (s.lsi_class().name == row.name) return &row;
  return nullptr;
}

std::int32_t step(const Call* call) {
  const double* wired = circuit::input(call, 0);
  const double t = wired[0] >= 0 ? wired[0] : call->tick->time;
  object_of<PlayedMotion>(call).sample(t, {circuit::output(call, 0), call->out_count[0]});
  return 0;
}

void configure(Setup& s) {
  const Character* character = character_of(s);
  if (!character) return;
  (void)clip_motion(s, *character, "clip");
  if (row_of(s)->pair) (void)clip_motion(s, *character, "second clip");
  s.set_out(0, static_cast<std::uint32_t>(reference_layout(*character->mechanism, character->feet.size()).size()), character->index);
}

void* make(Setup& s) {
  const Character& character = *character_of(s);
  const Row& row = *row_of(s);
  const Motion* motion = clip_motion(s, character, "clip");
  const Motion* second = row.pair ? clip_motion(s, character, "second clip") : nullptr;
  if (!motion || (row.pair && !second)) return nullptr;
  const Result<Motion> made = row.operation({*character.mechanism, *motion, second, s});
  if (made) return new PlayedMotion(character, *made);
  report(s, made.error());
  return nullptr;
}

}  // namespace

const Motion* clip_motion(Setup& setup, const Character& character, const char* parameter) {
  const auto index = static_cast<std::size_t>(std::max(0.0, setup.number(parameter)));
  const std::size_t clips = character.track ? character.track->clips().size() : 0;
  if (index < clips) return character.track->clips()[index].motion.get();
  setup.fail(ErrorCode::range,
             "The parameter '" + std::string(parameter) + "' is " + std::to_string(index) + ", but the track of '" + character.id +
                 "' has " + std::to_string(clips) + " clips (counted from 0).",
             "Use the index of a clip on the track, or add a clip to the track.");
  return nullptr;
}

void report(Setup& setup, const Error& error) {
  for (const Problem& p : error.problems) setup.fail(p.code, p.location + ": " + p.message, p.remedy);
}

bool parse_numbers(const std::string& text, std::vector<double>& out) {
  std::string word;
  for (const char c : text + " ") {
    if (c != ' ' && c != ',' && c != ';' && c != '\n' && c != '\t') {
      word += c;
      continue;
    }
    if (word.empty()) continue;
    const std::optional<double> x = parse_double(word);
    if (!x) return false;
    out.push_back(*x);
    word.clear();
  }
  return true;
}

circuit::Parameter text_parameter(std::string name, std::string doc) {
  circuit::Parameter p;
  p.name = std::move(name);
  p.kind = circuit::ParameterKind::text;
  p.initial = std::string();
  p.doc = std::move(doc);
  p.live = false;
  return p;
}

circuit::Parameter clip_parameter(std::string name, double initial, std::string doc) {
  circuit::Parameter p = number_parameter(std::move(name), initial, 0, 10000, "1", std::move(doc));
  p.kind = circuit::ParameterKind::integer;
  return p;
}

PlayedMotion::PlayedMotion(const Character& character, const Motion& motion)
    : character_(&character),
      layout_(reference_layout(*character.mechanism, character.feet.size())),
      smooth_(motion, *character.mechanism, 0),
      frames_(motion.frames) {
  clip_.length = 1e9;
  clip_.loop = motion.cyclic;
  if (motion.cyclic) clip_.cycle = cycle_of(motion, *character.mechanism);
  stance_.assign(static_cast<std::size_t>(motion.frames) * layout_.feet, 0);
  for (std::size_t k = 0; k < layout_.feet; ++k)
    for (const ContactTrack& track : motion.contacts)
      if (track.link == character.mechanism->link(character.feet[k]).name)
        for (std::size_t f = 0; f < std::min(track.on.size(), static_cast<std::size_t>(motion.frames)); ++f)
          stance_[f * layout_.feet + k] = track.on[f];
}

void PlayedMotion::sample(double t, std::span<double> r) const {
  const ReferenceLayout& l = layout_;
  ugoki::sample(clip_, smooth_, *character_->mechanism, t, r.first(l.nq), r.subspan(l.v(), l.nv), r.subspan(l.a(), l.nv));
  const double time = phase_of(clip_, smooth_.duration(), t).time;
  const auto frame = static_cast<std::size_t>(std::clamp(time * smooth_.rate() + 0.5, 0.0, static_cast<double>(frames_ - 1)));
  for (std::size_t k = 0; k < l.feet; ++k) r[l.stance() + k] = stance_[frame * l.feet + k] ? 1.0 : 0.0;
}

circuit::LsiClass played_motion_class(std::string name, std::string doc) {
  circuit::LsiClass c;
  c.name = std::move(name);
  c.doc = std::move(doc);
  c.group = "motion";
  circuit::InputPin time = input_pin("time", PinTypeId::scalar, "s", "Time in the motion; negative or not wired: the time of the circuit.");
  time.required = false;
  time.value = -1;
  c.inputs = {time};
  c.outputs = {output_pin("reference", PinTypeId::motion, "", "Reference motion of the character: q, v, a, stance.")};
  c.destroy = destroy<PlayedMotion>;
  c.step = step;
  return c;
}

void add_motion_operations(circuit::Library& library) {
  for (const Row& row : rows()) {
    circuit::LsiClass c = played_motion_class(row.name, row.doc);
    c.parameters = {character_parameter(), clip_parameter("clip", 0, "Clip of the character's track, counted from 0.")};
    if (row.pair) c.parameters.push_back(clip_parameter("second clip", 1, "Second clip of the character's track, counted from 0."));
    c.parameters.insert(c.parameters.end(), row.parameters.begin(), row.parameters.end());
    if (row.operation == do_layer || row.operation == do_mix) {
      c.parameters.push_back(
          text_parameter("joints", "Links (names or labels), each with all its descendants, separated by commas; empty: all."));
      c.parameters.push_back(number_parameter("weight", 1, -100, 100, "1", "Weight of the second clip."));
      c.parameters.push_back(number_parameter("offset", 0, 0, 1e6, "s", "Time at which the second clip starts."));
      c.parameters.push_back(number_parameter("fade", 0.2, 0, 100, "s", "Duration over which the second clip is blended in and out."));
    }
    c.configure = configure;
    c.make = make;
    library.add(std::move(c));
  }
}

}  // namespace ugoki::lsi
