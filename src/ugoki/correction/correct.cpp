#include "ugoki/correction/correct.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "ugoki/base/number.h"
#include "ugoki/correction/centre_path.h"
#include "ugoki/correction/clean.h"
#include "ugoki/correction/contacts.h"
#include "ugoki/correction/flight_spin.h"
#include "ugoki/correction/floor_plane.h"
#include "ugoki/correction/observe.h"
#include "ugoki/correction/place.h"
#include "ugoki/correction/travel.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/pass_through.h"
#include "ugoki/motion_edit/edit.h"
#include "ugoki/motion_edit/foot_lock.h"
#include "ugoki/motion_edit/rounds.h"

namespace ugoki::correction {
namespace {

using motion_edit::FootContacts;

constexpr double anchor_time = 0.1;  // s: time constant with which the root follows the standing feet
constexpr double settling = 2;       // s of further cycles on both sides of a cycle: the ends of a motion act on the centre of mass for 1 s

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Slide [frames] m of a standing foot from the frame before, as the mean of its loaded points. Zero where the foot turns about a vertical
/// axis: its pivot is not known. Slides of up to `tolerance` [m] in a stance are errors of measurement, which the legs remove.
std::vector<Vec3> slides_of(const Mechanism& m, const Motion& motion, const FootContacts& contacts, const motion_edit::FootPath& path,
                            std::size_t foot, double tolerance) {
  constexpr double loaded = 0.012;  // m: points this far above the lowest one carry no load, as in FootLockOptions
  std::vector<Vec3> out(at(motion.frames));
  const std::vector<std::uint8_t> turns = motion_edit::turning_frames(path, motion.rate);
  const std::vector<LinkPoint>& points = contacts.feet[foot].points;
  std::vector<Pose> X(at(m.link_count())), before(X.size());
  for (std::size_t f = 0; f < out.size(); ++f) {
    std::swap(X, before);
    calc_poses(m, {motion.frame(static_cast<int>(f)), at(motion.nq)}, X);
    if (f == 0 || !path.bears[f] || !path.bears[f - 1] || turns[f]) continue;
    const auto height = [&](const LinkPoint& p) { return (X[at(p.link)] * p.location.p).z - p.location.radius; };
    double low = 1e300, weight = 0;
    for (const LinkPoint& p : points) low = std::min(low, height(p));
    for (const LinkPoint& p : points) {
      const double above = (height(p) - low) / loaded;
      if (above >= 1) continue;
      const Vec3 point = p.location.p + transpose_times(X[at(p.link)].R, Vec3{0, 0, -p.location.radius});
      const double w = (1 - above) * (1 - above);
      out[f] += (X[at(p.link)] * point - before[at(p.link)] * point) * w;
      weight += w;
    }
    if (weight > 0) out[f] = {out[f].x / weight, out[f].y / weight, 0};
  }
  for (std::size_t f = 0; f < out.size();) {
    std::size_t end = f;
    Vec3 sum;
    for (; end < out.size() && path.bears[end] == path.bears[f]; ++end) sum += out[end];
    const double share = norm(sum) > tolerance ? 1 - tolerance / norm(sum) : 0;
    for (; f < end; ++f) out[f] = out[f] * share;
  }
  return out;
}

/// Moves the whole character so that the feet in contact rest on the ground on the average: removes the drift of the root over the ground,
/// and the height of feet that hover or sink together.
/// @param origin frame that stays at its place over the ground
void anchor(const Mechanism& m, const FootContacts& contacts, int origin, Motion& motion) {
  constexpr double tolerance = 0.04;  // m, for a leg of 0.9 m: feet of captures slide by 2 to 3.5 cm in a stance
  const std::size_t n = at(motion.frames);
  std::vector<double> x(n), y(n), weight(n), lift(n), standing(n);
  std::vector<Pose> X(at(m.link_count()));
  const std::vector<LinkPoint> others = other_points(m, contacts);
  const double size = motion_edit::mean_leg_length(contacts.feet) / 0.9;
  const std::vector<motion_edit::FootPath> paths = motion_edit::foot_paths(m, motion, contacts);
  for (std::size_t k = 0; k < paths.size(); ++k) {
    const std::vector<Vec3> slides = slides_of(m, motion, contacts, paths[k], k, tolerance * size);
    for (std::size_t f = 1; f < n; ++f) {
      if (!contacts.bears[k][f] || !contacts.bears[k][f - 1]) continue;
      x[f] += slides[f].x;
      y[f] += slides[f].y;
      weight[f] += 1;
    }
  }
  for (std::size_t f = 0; f < n; ++f) {
    calc_poses(m, {motion.frame(static_cast<int>(f)), at(motion.nq)}, X);
    const auto height = [&](const LinkPoint& p) { return (X[at(p.link)] * p.location.p).z - p.location.radius; };
    for (std::size_t k = 0; k < contacts.feet.size(); ++k) {
      if (!contacts.bears[k][f]) continue;
      double low = 1e300;
      for (const LinkPoint& p : contacts.feet[k].points) low = std::min(low, height(p));
      lift[f] -= low;
      standing[f] += 1;
    }
    double trunk = 1e300;  // a trunk, a knee or another link on the floor stays there
    for (const LinkPoint& p : others) trunk = std::min(trunk, height(p));
    if (std::fabs(trunk) < other_height * size) {
      lift[f] = -trunk;
      standing[f] = 1;
    }
    if (weight[f] > 0) {
      x[f] /= weight[f];
      y[f] /= weight[f];
      weight[f] = 1;
    }
    if (standing[f] > 0) lift[f] /= standing[f];
  }
  const double stiffness = anchor_time * motion.rate * anchor_time * motion.rate;
  x = pass_through(x, weight, stiffness);
  y = pass_through(y, weight, stiffness);
  lift = pass_through(lift, standing, stiffness);
  std::vector<Vec3> shift(n);
  for (std::size_t f = 1; f < n; ++f) shift[f] = shift[f - 1] - Vec3{x[f], y[f], 0};
  for (std::size_t f = 0; f < n; ++f)
    displace(m, {Mat3::identity(), shift[f] - shift[at(origin)] + Vec3{0, 0, lift[f]}}, motion.frame(static_cast<int>(f)));
}

class Correction {
 public:
  /// @param origin frame that stays at its place over the ground, if feet slide
  Correction(const Mechanism& m, const CorrectOptions& o, int origin, CorrectionReport& report)
      : m_(m), o_(o), origin_(origin), report_(report) {}

  /// Corrects a motion that is not cyclic.
  Result<Motion> run(const Motion& motion) {
    if (!go_on(0)) return cancelled();
    FootContacts contacts = find_bearing_limbs(m_, motion);
    if (contacts.feet.empty())
      return fail(ErrorCode::structure, "mechanism " + m_.name(), "The mechanism has no feet.",
                  "Label the links that stand on the ground 'foot' or 'paw'.");
    report_.before = measure(m_, motion, contacts, o_);
    Motion original = motion, out = motion;
    report_.replaced_frames = remove_pops(m_, out);
    remove_jitter(m_, out, o_.smoothing);
    if (!go_on(0.1)) return cancelled();
    const MissingTravel travel = find_missing_travel(m_, out, contacts.feet);
    report_.travel = norm(travel.velocity);
    if (travel.exists())
      for (Motion* motion_of : {&original, &out})
        for (int f = 0; f < out.frames; ++f)
          displace(m_, {Mat3::identity(), travel.shift[at(f)] - travel.shift[at(std::min(origin_, out.frames - 1))]}, motion_of->frame(f));
    if (o_.level_floor) {
      const FloorPlane floor = find_floor(m_, out, contacts.feet);
      report_.floor_height = floor.height;
      report_.floor_tilt = atan2(norm(floor.slope), 1) * 180 / pi;
      for (Motion* level : {&original, &out})
        for (int f = 0; f < out.frames; ++f) displace(m_, floor.to_level(), level->frame(f));
    }
    contacts = find_bearing_limbs(m_, out);
    if (!o_.keep_duration) {
      Result<void> retimed = retime(contacts, original, out);
      if (!retimed) return fail(std::move(retimed.error()));
      contacts = find_bearing_limbs(m_, out);
    }
    if (!go_on(0.2)) return cancelled();
    keep_limits(m_, out);
    anchor(m_, contacts, std::min(origin_, out.frames - 1), out);
    std::optional<Motion> placed = place_body(m_, out, o_.gravity, [&](double done) { return go_on(0.3 + 0.6 * done); }, contacts);
    if (!placed) return cancelled();
    out = std::move(*placed);
    const Observation o = observe(m_, out, contacts);
    report_.flights = static_cast<int>(o.flights.size());
    keep_spin(m_, o, out);
    motion_edit::set_labels(m_, contacts, out);
    if (o_.strength < 1)
      for (int f = 0; f < out.frames; ++f) {
        const std::vector<double> full(out.frame(f), out.frame(f) + out.nq);
        interpolate(m_, {original.frame(f), at(out.nq)}, full, o_.strength, {out.frame(f), at(out.nq)});
      }
    report_.change_deg = rms_change(m_, original, out, report_.root_move_cm);
    report_.after = measure(m_, out, contacts, o_);
    if (!go_on(1)) return cancelled();
    return out;
  }

 private:
  bool go_on(double done) { return !o_.progress || o_.progress(done); }
  static std::unexpected<Error> cancelled() { return fail(ErrorCode::cancelled, "", "The correction was cancelled."); }

  /// Changes the duration of flights in which gravity is wrong.
  Result<void> retime(const FootContacts& contacts, Motion& original, Motion& out) {
    const std::vector<double> times = find_flight_times(observe(m_, out, contacts), o_.gravity, o_.strength);
    report_.duration_change = times.back() - out.duration();
    if (std::fabs(report_.duration_change) < 0.5 / out.rate) return {};
    std::vector<motion_edit::TimePoint> points;
    for (int f = 0; f < out.frames; ++f) points.push_back({times[at(f)], f / out.rate});
    points.back().source = out.duration();
    for (Motion* motion : {&original, &out}) {
      Result<Motion> warped = motion_edit::time_warp(m_, *motion, points);
      if (!warped) return fail(std::move(warped.error()));
      *motion = std::move(*warped);
    }
    return {};
  }

  const Mechanism& m_;
  const CorrectOptions& o_;
  int origin_;
  CorrectionReport& report_;
};

}  // namespace

Result<Motion> correct_motion(const Mechanism& m, const Motion& motion, const CorrectOptions& options, CorrectionReport* report) {
  if (Error wrong = check_motion(motion, m); !wrong.empty()) return fail(std::move(wrong));
  const std::string where = "motion " + motion.name;
  if (m.link_count() == 0 || m.link(0).joint.type != JointType::floating)
    return fail(ErrorCode::structure, where, "The root of the mechanism is not floating, so that there is no balance to correct.",
                "Use a mechanism with a floating root.");
  if (motion.frames < 5)
    return fail(ErrorCode::range, where, "The motion has " + std::to_string(motion.frames) + " frames.",
                "Use a motion of 5 frames or more.");
  if (!(options.strength >= 0 && options.strength <= 1))
    return fail(ErrorCode::range, where, "The strength of the correction is " + to_text(options.strength) + ".", "Use 0 to 1.");
  if (!(options.gravity > 0 && options.gravity < 1000) || !(options.friction >= 0 && options.friction <= 10) || !(options.smoothing >= 0))
    return fail(ErrorCode::range, where, "Gravity, friction or the cut-off of the filter is out of range.",
                "Use a gravity above 0 and below 1000 m/s^2, a friction from 0 to 10, and a cut-off of at least 0 Hz.");
  CorrectionReport unused;
  CorrectionReport& reported = report ? *report : unused;
  reported = {};
  if (options.strength == 0) {
    const FootContacts contacts = find_bearing_limbs(m, motion);
    reported.before = reported.after = measure(m, motion, contacts, options);
    return motion;
  }
  Motion source = motion;
  source.torques = nullptr;
  const bool around = motion.cyclic && motion.frames > 2;
  if (!around) return Correction(m, options, 0, reported).run(source);
  CorrectOptions own = options;
  own.keep_duration = true;  // the cycles stay equal
  const int n = motion_edit::round_frames(motion), cycles = static_cast<int>(std::ceil(settling * motion.rate / n)), first = cycles * n;
  Result<Motion> out = Correction(m, own, first, reported).run(motion_edit::several_rounds(source, m, cycles));
  if (!out) return out;
  Motion middle = *out;
  middle.q.assign(out->frame(first), out->frame(first + n) + out->nq);
  middle.frames = n + 1;
  middle.contacts.clear();
  return motion_edit::middle_round(*out, m, cycle_of(middle, m), cycles);
}

}  // namespace ugoki::correction
