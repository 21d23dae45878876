#include "ugoki/studio/motion_edits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "ugoki/base/number.h"
#include "ugoki/correction/correct.h"
#include "ugoki/json/fields.h"
#include "ugoki/motion/clip.h"
#include "ugoki/motion_edit/curves.h"
#include "ugoki/motion_edit/edit.h"
#include "ugoki/motion_edit/intermediate.h"
#include "ugoki/motion_edit/layers.h"
#include "ugoki/motion_edit/mirror.h"
#include "ugoki/motion_edit/root_path.h"
#include "ugoki/retarget/retarget.h"

namespace ugoki::studio {
namespace {

using namespace motion_edit;
using json::Fields;
using json::Json;

std::size_t at(int i) { return static_cast<std::size_t>(i); }
std::string cm(double value) { return to_fixed(value, 2) + " cm"; }

/// Runs one operation. Each public member except finish() is an operation: it sets `out_.motion`, the clip's settings and the report.
class Operation {
 public:
  Operation(const MotionEdit& edit, Error& problems)
      : e_(edit), m_(*edit.mechanism), in_(*edit.target.motion), f_(edit.options, "options", problems) {
    out_.clip = edit.target.clip;
  }

  Result<void> trim() {
    out_.label = "Cut motion to clip";
    if (Result<void> valid = check_options(); !valid) return valid;
    Result<Motion> made = bake_clip(m_, e_.target);
    play_once(made);
    report("The motion now contains only the " + to_fixed(out_.clip.length, 2) + " s that the clip shows.");
    return set_motion(std::move(made), "section");
  }

  Result<void> join() {
    out_.label = "Join clips";
    double blend = -1;
    f_.number("blend", blend);
    if (Result<void> valid = check_options(); !valid) return valid;
    if (!e_.next.motion)
      return fail(ErrorCode::structure, "clip " + e_.target.clip.id, "It is the last clip of its track, so there is no clip to join.",
                  "Add a clip after it, then join them.");
    const Result<Motion> first = bake_clip(m_, e_.target), second = bake_clip(m_, e_.next);
    if (!first) return fail(first.error());
    if (!second) return fail(second.error());
    // Default duration of the blend: the overlap of the clips, or the second clip's own blend if they do not overlap.
    const double overlap = e_.target.clip.start + e_.target.clip.length - e_.next.clip.start;
    if (blend < 0) blend = overlap > 1e-6 ? overlap : e_.next.clip.blend;
    JoinOptions o;
    o.blend = std::min({blend, first->duration(), second->duration()});
    Result<Motion> made = motion_edit::join(m_, *first, *second, o);
    play_once(made);
    report("One motion of " + to_fixed(out_.clip.length, 2) + " s. The two parts are blended over " + to_fixed(o.blend, 2) + " s.");
    return set_motion(std::move(made));
  }

  Result<void> cycle() {
    out_.label = "Make motion cyclic";
    bool lock = true;
    f_.boolean("lock", lock);
    if (Result<void> valid = check_options(); !valid) return valid;
    const Result<Motion> part = section();
    if (!part) return fail(part.error());
    CycleOptions o;
    o.lock_feet = lock;
    CycleReport cycle;
    Result<Motion> made = make_cyclic(m_, *part, o, &cycle);
    play_looped();
    if (made)
      report((cycle.by_contacts ? "A stride of " : "A cycle of ") + to_fixed(made->duration(), 2) +
             " s now repeats without a jump. Before, the joints differed by " + to_fixed(cycle.seam * 180 / std::numbers::pi, 1) +
             "° between its ends.");
    if (made && lock && cycle.feet.before.stances > 0) report_feet(cycle.feet);
    return set_motion(std::move(made), "cyclic");
  }

  /// Changes the speed: the option `speeds` gives speeds in per cent at evenly spaced times of the section that the clip shows.
  Result<void> warp() {
    out_.label = "Change speed of motion";
    std::vector<double> speeds;
    f_.require("speeds", "two or more speeds in per cent, from the clip's beginning to its end");
    if (const Json* list = f_.list("speeds", 100, "speeds"))
      for (const Json& v : *list) speeds.push_back(v.is_number() ? v.get<double>() : -1);
    if (speeds.size() < 2 || std::ranges::any_of(speeds, [](double v) { return !(v >= 5 && v <= 1000); }))
      f_.report(ErrorCode::range, f_.path("speeds"), "It must be a list of two or more speeds from 5 to 1000 per cent.",
                "100 keeps the speed.");
    if (Result<void> valid = check_options(); !valid) return valid;
    const Result<Motion> part = bake_clip(m_, e_.target);
    if (!part) return fail(part.error());
    // Between two given speeds, the speed v is linear in the source time s. The new time t is the integral of dt = ds / v(s), by the
    // midpoint rule.
    constexpr int pieces = 16;
    const auto count = static_cast<int>(speeds.size()) - 1;
    std::vector<TimePoint> curve{{0, 0}};
    for (int i = 0; i < count * pieces; ++i) {
      const double position = (i + 0.5) / pieces;
      const int k = std::min(static_cast<int>(position), count - 1);
      const double share = position - k, speed = (speeds[at(k)] * (1 - share) + speeds[at(k + 1)] * share) / 100;
      const double source = std::min(part->duration() * (i + 1) / (count * pieces), part->duration());
      curve.push_back({curve.back().time + (source - curve.back().source) / speed, source});
    }
    Result<Motion> made = time_warp(m_, *part, curve);
    play_once(made);
    report("The clip lasts " + to_fixed(out_.clip.length, 2) + " s instead of " + to_fixed(part->duration(), 2) + " s.");
    return set_motion(std::move(made), "other speed");
  }

  Result<void> mirror() {
    out_.label = "Mirror motion";
    if (Result<void> valid = check_options(); !valid) return valid;
    return set_inverted_motion(motion_edit::mirror(m_, in_), "mirrored");
  }

  Result<void> reverse() {
    out_.label = "Reverse motion";
    if (Result<void> valid = check_options(); !valid) return valid;
    content::ScenarioClip& c = out_.clip;
    const double rest = in_.duration() - c.offset - c.length * c.speed;
    c.offset = c.loop && in_.duration() > 0 ? rest - std::floor(rest / in_.duration()) * in_.duration() : std::max(0.0, rest);
    return set_inverted_motion(motion_edit::reverse(in_), "reversed");
  }

  Result<void> resample() {
    out_.label = "Resample motion";
    double rate = 0;
    f_.require("rate", "frames a second");
    f_.number("rate", rate);
    if (Result<void> valid = check_options(); !valid) return valid;
    Result<Motion> made = motion_edit::resample(m_, in_, rate);
    if (made)
      report(std::to_string(made->frames) + " frames instead of " + std::to_string(in_.frames) + ", " + to_text(made->rate) + " a second.");
    return set_motion(std::move(made));
  }

  /// Scales the root's path over the ground (option `way`) and the duration (`time`). The body keeps its size, so the root's height is not
  /// scaled, and the feet are locked again.
  Result<void> scale() {
    out_.label = "Scale motion";
    ScaleOptions o;
    double path_factor = 1;
    f_.number("way", path_factor);
    f_.number("time", o.time);
    if (!(path_factor >= 0.1 && path_factor <= 10))
      f_.report(ErrorCode::range, f_.path("way"), "It must be from 0.1 to 10.", "1 keeps the length of the path.");
    if (!(o.time >= 0.1 && o.time <= 10))
      f_.report(ErrorCode::range, f_.path("time"), "It must be from 0.1 to 10.", "1 keeps the duration.");
    if (Result<void> valid = check_options(); !valid) return valid;
    Result<Motion> made = motion_edit::scale(m_, in_, o);
    if (made && path_factor != 1) {
      std::vector<PathPoint> path = root_path(m_, *made);
      const PathPoint first = path.empty() ? PathPoint{} : path.front();
      for (PathPoint& p : path) p = {first.x + path_factor * (p.x - first.x), first.y + path_factor * (p.y - first.y)};
      made = bend(*made, path, true);
    }
    out_.clip.offset *= o.time;
    if (!out_.clip.loop) out_.clip.length *= o.time;
    return set_motion(std::move(made), "scaled");
  }

  /// Bends the root's path over the ground: a straight line, an arc, or a curve to a given end point.
  Result<void> path() {
    out_.label = "Change path of motion";
    std::string shape;
    double turn = 0, forward = 0, left = 0;
    f_.require("shape", "straight, turn or to");
    f_.text("shape", shape);
    f_.number("turn", turn);
    f_.number("forward", forward);
    f_.number("left", left);
    if (shape != "straight" && shape != "turn" && shape != "to")
      f_.report(ErrorCode::range, f_.path("shape"), "There is no path shape '" + shape + "'.", "Use straight, turn or to.");
    if (shape == "to" && std::hypot(forward, left) < 0.05)
      f_.report(ErrorCode::range, f_.path("forward"), "The end of the path is less than 5 cm from its start.",
                "Give an end that is at least 5 cm away.");
    if (!(std::fabs(turn) <= 3600) || !(std::fabs(forward) <= 1000) || !(std::fabs(left) <= 1000))
      f_.report(ErrorCode::range, f_.path("shape"), "The path is too long.",
                "Give distances of at most 1000 m and a turn of at most 3600°.");
    if (Result<void> valid = check_options(); !valid) return valid;
    const std::vector<PathPoint> old_path = root_path(m_, in_);
    double length = 0;
    for (std::size_t i = 1; i < old_path.size(); ++i)
      length += std::hypot(old_path[i].x - old_path[i - 1].x, old_path[i].y - old_path[i - 1].y);
    const PathPoint start = old_path.empty() ? PathPoint{} : old_path.front();
    const double heading = first_direction(old_path, length);
    std::vector<PathPoint> curve;
    const auto add = [&](double x, double y) {  // x forwards, y to the left, relative to the first direction, m
      curve.push_back({start.x + x * std::cos(heading) - y * std::sin(heading), start.y + x * std::sin(heading) + y * std::cos(heading)});
    };
    const double angle = turn * std::numbers::pi / 180;
    const int steps = 8 + static_cast<int>(std::fabs(turn) / 15);
    for (int i = 0; i <= steps; ++i) {
      const double s = static_cast<double>(i) / steps;
      if (shape == "to")  // quadratic Bezier curve; its middle control point is straight ahead, so it starts in the old direction
        add(std::hypot(forward, left) * s * (1 - s) + forward * s * s, left * s * s);
      else if (shape == "straight" || std::fabs(angle) < 1e-6)
        add(length * s, 0);
      else
        add(length / angle * std::sin(angle * s), length / angle * (1 - std::cos(angle * s)));
    }
    Result<Motion> made = bend(in_, curve, shape == "to");
    if (made) out_.clip.loop = out_.clip.loop && made->cyclic;
    return set_motion(std::move(made), "other path");
  }

  Result<void> mix() { return layers(false); }
  Result<void> layer() { return layers(true); }

  Result<void> blend() {
    double percent = 50;
    f_.number("percent", percent);
    if (!(percent >= 0 && percent <= 100))
      f_.report(ErrorCode::range, f_.path("percent"), "It must be from 0 (this motion) to 100 (the other one).", "50 is the middle.");
    out_.label = "Intermediate motion";
    if (Result<void> valid = check_options(); !valid) return valid;
    const Result<Motion> part = section(), other = other_on_this_body();
    if (!part) return fail(part.error());
    if (!other) return fail(other.error());
    const std::array<const Motion*, 2> sources = {&*part, &*other};
    const Result<Intermediate> between = Intermediate::make(m_, sources);
    if (!between) return fail(between.error());
    FootLockReport lock;
    Result<Motion> made = between->blend(std::array{1 - percent / 100, percent / 100}, &lock);
    play_looped();
    if (made) {
      report(to_text(percent) + " % of " + other->name + ": speed " + to_fixed(between->facts(*made).speed, 2) + " m/s, between " +
             to_fixed(between->facts(between->cycle(0)).speed, 2) + " and " + to_fixed(between->facts(between->cycle(1)).speed, 2) +
             " m/s.");
      report_feet(lock);
      made->name = part->name + " " + to_text(100 - percent) + " % " + other->name + " " + to_text(percent) + " %";
    }
    return set_motion(std::move(made));
  }

  Result<void> contacts() {
    out_.label = "Find contacts";
    FootContactOptions o;
    f_.boolean("find_ground", o.find_ground);
    if (Result<void> valid = check_options(); !valid) return valid;
    const FootContacts found = find_contacts(m_, in_, o);
    if (found.feet.empty())
      return fail(ErrorCode::structure, "mechanism " + m_.name(), "The mechanism has no feet, so there are no contacts to find.",
                  "Label the links that stand on the ground 'foot' or 'paw'.");
    Motion made = in_;
    set_labels(m_, found, made);
    const SkateReport skate = measure_skate(m_, in_, found);
    report(std::to_string(skate.stances) + " stances. Standing feet slide by " + cm(skate.mean_cm) + " on average and by at most " +
           cm(skate.worst_cm) + ".");
    return set_motion(std::move(made));
  }

  Result<void> lock() {
    out_.label = "Lock feet";
    FootLockOptions o;
    f_.number("ease", o.ease);
    if (!(o.ease >= 0 && o.ease <= 2)) f_.report(ErrorCode::range, f_.path("ease"), "It must be from 0 to 2 s.", "0.12 is usual.");
    if (Result<void> valid = check_options(); !valid) return valid;
    FootLockReport report;
    Result<Motion> made = lock_feet(m_, in_, labelled_contacts(m_, in_, find_foot_limbs(m_)), o, &report);
    report_feet(report);
    return set_motion(std::move(made), "feet locked");
  }

  Result<void> reduce() {
    out_.label = "Reduce keys";
    ReduceOptions o;
    f_.number("degrees", o.degrees);
    f_.number("metres", o.metres);
    if (Result<void> valid = check_options(); !valid) return valid;
    const Result<MotionCurves> curves = reduce_keys(m_, in_, o);
    if (!curves) return fail(curves.error());
    const auto all = static_cast<int>(curves->curves.size()) * in_.frames;
    report(std::to_string(curves->key_count()) + " keys instead of " + std::to_string(all) + ". No joint deviates by more than " +
           to_text(o.degrees) + "°.");
    return set_motion(to_motion(m_, *curves), "fewer keys");
  }

  Result<void> retarget() {
    out_.label = "Motion for another body";
    retarget::RetargetOptions o;
    f_.boolean("slow", o.slow_down);
    f_.boolean("balance", o.balance);
    if (Result<void> valid = check_options(); !valid) return valid;
    o.cancelled = [flag = e_.cancelled] { return flag != nullptr && *flag; };
    Result<retarget::Retargeted> made = retarget::retarget(e_.mechanism, in_, e_.body, o);
    if (!made) return fail(std::move(made.error()));
    for (std::string& line : retarget::describe(made->report)) report(std::move(line));
    if (made->report.slowed != 1) {
      out_.clip.offset *= made->report.slowed;
      if (!out_.clip.loop) out_.clip.length *= made->report.slowed;
    }
    return set_motion(std::move(made->motion), "for " + e_.body->name());
  }

  /// Physics correction (correction/correct.h).
  Result<void> correct() {
    out_.label = "Correct the physics";
    correction::CorrectOptions o;
    double percent = 100;
    bool find_floor = true, keep_duration = false;
    f_.number("percent", percent);
    f_.boolean("find_floor", find_floor);
    f_.boolean("keep_duration", keep_duration);
    if (!(percent >= 0 && percent <= 100))
      f_.report(ErrorCode::range, f_.path("percent"), "It must be from 0 to 100.", "100 is the complete correction.");
    if (Result<void> valid = check_options(); !valid) return valid;
    o.strength = percent / 100;
    o.level_floor = find_floor;
    o.keep_duration = keep_duration;
    o.progress = [flag = e_.cancelled](double) { return flag == nullptr || !*flag; };
    const Result<Motion> part = section();
    if (!part) return fail(part.error());
    correction::CorrectionReport r;
    Result<Motion> made = correction::correct_motion(m_, *part, o, &r);
    if (!made) return fail(std::move(made.error()));
    const auto change = [&](const char* what, double before, double after, int digits, const char* unit) {
      report(std::string(what) + ": " + to_fixed(before, digits) + unit + " before, " + to_fixed(after, digits) + unit + " after.");
    };
    change("Sliding of standing feet", r.before.skate_cm, r.after.skate_cm, 2, " cm");
    change("Depth in the ground", r.before.penetration_mm, r.after.penetration_mm, 1, " mm");
    change("Force that the ground cannot supply", r.before.residual_bw, r.after.residual_bw, 3, " body weights");
    if (r.flights > 0) change("Error of gravity in flights", r.before.flight_g, r.after.flight_g, 3, " g");
    if (r.travel > 0) report("The standing feet slid all the time. The motion now travels " + to_fixed(r.travel, 2) + " m/s faster.");
    change("Jerk", r.before.jerk, r.after.jerk, 2, " thousand rad/s³");
    report("Joints changed by " + to_fixed(r.change_deg, 1) + "° rms, the root by " + to_fixed(r.root_move_cm, 1) + " cm rms.");
    const bool looped = out_.clip.loop && made->cyclic;
    if (!looped) play_once(made);
    return set_motion(std::move(made), "corrected");
  }

  EditedMotion finish() {
    const double max_length =
        out_.motion.duration() > 0 && !out_.clip.loop ? (out_.motion.duration() - out_.clip.offset) / out_.clip.speed : 1e9;
    out_.clip.length =
        std::max(0.001, std::min(out_.clip.length, max_length));  // at another frame rate the motion may be up to a frame shorter
    return std::move(out_);
  }

 private:
  void report(std::string sentence) { out_.report.push_back(std::move(sentence)); }
  void report_feet(const FootLockReport& r) {
    report("Standing feet slide by at most " + cm(r.after.worst_cm) + ", before by " + cm(r.before.worst_cm) +
           ". Feet were moved by at most " + cm(100 * r.max_move) + ".");
    if (r.max_miss > 1e-3)
      report(r.miss_link + " misses its position on the ground by " + cm(100 * r.max_miss) + " at " + to_fixed(r.miss_frame / in_.rate, 2) +
             " s: the leg is too short or a joint limit stops it.");
  }
  /// Checks the options; to be called after all options have been read. Errors: unknown options and the problems found so far.
  Result<void> check_options() {
    f_.refuse_others();
    if (!f_.problems().empty()) return fail(f_.problems());
    return {};
  }
  /// Sets the resulting motion. @param suffix description of the change; appended to the motion's name unless the name already ends so
  Result<void> set_motion(Result<Motion> made, const std::string& suffix = "") {
    if (!made) return fail(std::move(made.error()));
    out_.motion = std::move(*made);
    if (!suffix.empty() && !out_.motion.name.ends_with(", " + suffix)) out_.motion.name = in_.name + ", " + suffix;
    return {};
  }
  /// Sets the result of an operation that is its own inverse: the suffix is removed if the motion's name already ends with it.
  Result<void> set_inverted_motion(Result<Motion> made, const std::string& suffix) {
    Result<void> done = set_motion(std::move(made));
    const std::string end = ", " + suffix;
    if (done) out_.motion.name = in_.name.ends_with(end) ? in_.name.substr(0, in_.name.size() - end.size()) : in_.name + end;
    return done;
  }
  /// Sets the clip to play the whole resulting motion once, at the motion's own speed.
  void play_once(const Result<Motion>& made) {
    out_.clip.offset = 0;
    out_.clip.speed = 1;
    out_.clip.loop = false;
    if (made) out_.clip.length = made->duration();
  }
  /// Sets the clip to repeat the resulting motion for as long as the clip lasted before.
  void play_looped() {
    out_.clip.offset = 0;
    out_.clip.speed = 1;
    out_.clip.loop = true;
  }

  /// The section of the motion that the clip shows, with its original frames (no resampling); for a looped clip the whole motion.
  Result<Motion> section() const {
    const content::ScenarioClip& c = e_.target.clip;
    if (c.loop) return in_;
    const int first = static_cast<int>(std::floor(c.offset * in_.rate + 1e-6));
    const int last = static_cast<int>(std::ceil((c.offset + c.length * c.speed) * in_.rate - 1e-6));
    if (first <= 0 && last >= in_.frames - 1) return in_;
    return motion_edit::trim(in_, std::clamp(first, 0, in_.frames - 1), std::clamp(last, 0, in_.frames - 1));
  }

  Result<Motion> bend(const Motion& motion, const std::vector<PathPoint>& curve, bool stretch) {
    RootPathOptions o;
    o.keep_speed = !stretch;
    FootLockReport report;
    Result<Motion> made = bend_path(m_, motion, curve, o, &report);
    if (made) report_feet(report);
    return made;
  }

  /// Direction in which the path starts, rad about Z: from its start to the first point that is 0.3 m away, or 20 % of the path's length if
  /// that is less. Sway of the root at the start then has little effect.
  static double first_direction(const std::vector<PathPoint>& path, double length) {
    for (const PathPoint& p : path)
      if (const double x = p.x - path.front().x, y = p.y - path.front().y;
          std::hypot(x, y) >= std::min(0.3, 0.2 * length) && std::hypot(x, y) > 0)
        return std::atan2(y, x);
    return 0;
  }

  /// The second motion, retargeted to the clip's mechanism if it was made for another one.
  Result<Motion> other_on_this_body() {
    if (e_.other_mechanism == e_.mechanism || e_.other_mechanism->name() == m_.name()) {
      if (check_motion(*e_.other, m_).empty()) return *e_.other;
    }
    retarget::RetargetOptions o;
    o.cancelled = [flag = e_.cancelled] { return flag != nullptr && *flag; };
    Result<retarget::Retargeted> made = retarget::retarget(e_.other_mechanism, *e_.other, e_.mechanism, o);
    if (!made) return fail(std::move(made.error()));
    report(e_.other->name + " was made for another body (" + e_.other_mechanism->name() + ") and was retargeted.");
    return std::move(made->motion);
  }

  /// The operations `layer` (additive) and `mix`: the second motion acts on the links of a mask.
  Result<void> layers(bool additive) {
    out_.label = additive ? "Add layer" : "Mix joints";
    LayerOptions o;
    o.offset = e_.target.clip.offset;
    std::vector<MaskEntry> entries;
    f_.number("weight", o.weight);
    f_.number("fade", o.fade);
    constexpr double max_delay = 86400;  // s: the maximum duration of a scenario
    double delay = 0;                    // start of the second motion, s after the clip's beginning
    f_.number("at", delay);
    if (const Json* list = f_.list("joints", 10'000, "links"))
      for (const Json& v : *list) {
        if (v.is_string()) {
          entries.push_back({v.get<std::string>(), 1, true});
        } else {
          MaskEntry entry;
          Fields g(v, f_.path("joints"), f_.problems());
          g.require("link", "a link's name");
          g.text("link", entry.link);
          g.number("weight", entry.weight);
          g.refuse_others();
          entries.push_back(entry);
        }
      }
    if (!(o.fade >= 0 && o.fade <= 60)) f_.report(ErrorCode::range, f_.path("fade"), "It must be from 0 to 60 s.", "0.2 is usual.");
    if (!(delay >= 0 && delay <= max_delay))
      f_.report(ErrorCode::range, f_.path("at"), "It must be from 0 to " + to_text(max_delay) + " s after the clip's beginning.",
                "0 is the clip's beginning.");
    if (Result<void> valid = check_options(); !valid) return valid;
    o.offset += delay * e_.target.clip.speed;
    const Result<Motion> other = other_on_this_body();
    if (!other) return fail(other.error());
    const Result<JointMask> mask = make_mask(m_, entries);
    if (!mask) return fail(mask.error());
    return set_motion(additive ? add_layer(m_, in_, *other, *mask, o) : mix_joints(m_, in_, *other, *mask, o), "with " + other->name);
  }

  const MotionEdit& e_;
  const Mechanism& m_;
  const Motion& in_;
  Fields f_;
  EditedMotion out_;
};

struct Kind {
  std::string_view name;
  Needs needs;
  Result<void> (Operation::*run)();
};
constexpr std::array<Kind, 17> kinds = {{{"trim", Needs::nothing, &Operation::trim},
                                         {"join", Needs::next_clip, &Operation::join},
                                         {"cycle", Needs::nothing, &Operation::cycle},
                                         {"warp", Needs::nothing, &Operation::warp},
                                         {"mirror", Needs::nothing, &Operation::mirror},
                                         {"reverse", Needs::nothing, &Operation::reverse},
                                         {"resample", Needs::nothing, &Operation::resample},
                                         {"scale", Needs::nothing, &Operation::scale},
                                         {"path", Needs::nothing, &Operation::path},
                                         {"mix", Needs::other_motion, &Operation::mix},
                                         {"layer", Needs::other_motion, &Operation::layer},
                                         {"blend", Needs::other_motion, &Operation::blend},
                                         {"contacts", Needs::nothing, &Operation::contacts},
                                         {"lock", Needs::nothing, &Operation::lock},
                                         {"reduce", Needs::nothing, &Operation::reduce},
                                         {"correct", Needs::nothing, &Operation::correct},
                                         {"retarget", Needs::body, &Operation::retarget}}};

Result<Kind> kind_of(std::string_view operation) {
  for (const Kind& kind : kinds)
    if (kind.name == operation) return kind;
  return fail(ErrorCode::unknown, "operation", "There is no operation '" + std::string(operation) + "' on motions.",
              "See docs/studio-protocol.md for the operations.");
}

/// Copies contact labels: frame i of `out` gets the labels of the frame of `motion` closest to times[i] [s].
void bake_contacts(const Motion& motion, const std::vector<double>& times, Motion& out) {
  for (const ContactTrack& track : motion.contacts) {
    ContactTrack& made = out.contacts.emplace_back(ContactTrack{track.link, {}});
    for (const double t : times)
      made.on.push_back(track.on[at(std::clamp(static_cast<int>(std::lround(t * motion.rate)), 0, motion.frames - 1))]);
  }
}

}  // namespace

Result<Needs> needs_of(std::string_view operation) {
  const Result<Kind> kind = kind_of(operation);
  if (!kind) return fail(kind.error());
  return kind->needs;
}

Result<Motion> bake_clip(const Mechanism& mechanism, const ClipMotion& shown) {
  const Motion& motion = *shown.motion;
  if (Error wrong = check_motion(motion, mechanism); !wrong.empty()) return fail(std::move(wrong));
  Clip clip;
  clip.offset = shown.clip.offset;
  clip.speed = shown.clip.speed;
  clip.loop = shown.clip.loop;
  clip.cycle = cycle_of(motion, mechanism);
  const double max_length = clip.loop ? shown.clip.length : (motion.duration() - clip.offset) / clip.speed;
  clip.length = std::max(0.0, std::min(shown.clip.length, max_length));
  Motion out;
  out.name = motion.name;
  out.source = motion.source;
  out.mechanism = motion.mechanism;
  out.rate = motion.rate;
  out.nq = motion.nq;
  out.frames = static_cast<int>(std::floor(clip.length * out.rate + 1e-6)) + 1;
  out.q.resize(at(out.frames) * at(out.nq));
  out.cyclic = motion.cyclic && !clip.loop && clip.offset < 1e-9 && std::fabs(clip.length * clip.speed - motion.duration()) < 1e-6 &&
               std::fabs(out.duration() - clip.length) < 1e-6;
  std::vector<double> times;
  for (int f = 0; f < out.frames; ++f) {
    const double t = f / out.rate;
    sample(clip, motion, mechanism, t, {out.frame(f), at(out.nq)});
    times.push_back(phase_of(clip, motion.duration(), t).time);
  }
  bake_contacts(motion, times, out);
  return out;
}

Result<EditedMotion> edit_motion(const MotionEdit& edit) {
  const Result<Kind> kind = kind_of(edit.operation);
  if (!kind) return fail(kind.error());
  if (Error wrong = check_motion(*edit.target.motion, *edit.mechanism); !wrong.empty()) return fail(std::move(wrong));
  Error problems;
  Operation operation(edit, problems);
  if (Result<void> done = (operation.*(kind->run))(); !done) return fail(std::move(done.error()));
  return operation.finish();
}

}  // namespace ugoki::studio
