#include "ugoki/correction/correct.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/number.h"
#include "ugoki/correction/centre_path.h"
#include "ugoki/correction/clean.h"
#include "ugoki/correction/flight_spin.h"
#include "ugoki/correction/floor_plane.h"
#include "ugoki/correction/observe.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/pass_through.h"
#include "ugoki/motion_edit/edit.h"
#include "ugoki/motion_edit/foot_lock.h"
#include "ugoki/motion_edit/rounds.h"

namespace ugoki::correction {
namespace {

using motion_edit::FootContacts;
using motion_edit::FootPath;

constexpr int rounds = 4;            // of moving the root to the wanted centre of mass, and the legs to the feet
constexpr double anchor_time = 0.1;  // s: time constant with which the root follows the standing feet
constexpr double swing_ease = 0.12;  // s before and after a stance in which a foot begins and ceases to follow the root

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Heights and speeds are tolerant, because the feet of a wrong motion hover and slide.
FootContacts contacts_of(const Mechanism& m, const Motion& motion) {
  motion_edit::FootContactOptions o;
  o.height_on = 0.05;
  o.height_off = 0.065;
  o.speed_on = 0.5;
  o.speed_off = 0.9;
  return motion_edit::find_contacts(m, motion, o);
}

/// Moves the whole character so that the feet in contact rest on the ground on the average: removes the drift of the root over the ground,
/// and the height of feet that hover or sink together.
void anchor(const Mechanism& m, const FootContacts& contacts, Motion& motion) {
  constexpr double loaded = 0.012;  // m: points this far above the lowest one carry no load, as in FootLockOptions
  const std::size_t n = at(motion.frames);
  std::vector<double> x(n), y(n), weight(n), lift(n), standing(n);
  std::vector<Pose> X(at(m.link_count())), before(X.size());
  for (std::size_t f = 0; f < n; ++f) {
    calc_poses(m, {motion.frame(static_cast<int>(f)), at(motion.nq)}, X);
    for (std::size_t k = 0; k < contacts.feet.size(); ++k) {
      if (!contacts.bears[k][f]) continue;
      double low = 1e300;
      const auto height = [&](const LinkPoint& p) { return (X[at(p.link)] * p.location.p).z - p.location.radius; };
      for (const LinkPoint& p : contacts.feet[k].points) low = std::min(low, height(p));
      lift[f] -= low;
      standing[f] += 1;
      if (f == 0 || !contacts.bears[k][f - 1]) continue;
      for (const LinkPoint& p : contacts.feet[k].points) {
        const double above = (height(p) - low) / loaded;
        if (above >= 1) continue;
        const Vec3 point = p.location.p + transpose_times(X[at(p.link)].R, Vec3{0, 0, -p.location.radius});
        const Vec3 slide = X[at(p.link)] * point - before[at(p.link)] * point;
        const double w = (1 - above) * (1 - above);
        x[f] += w * slide.x;
        y[f] += w * slide.y;
        weight[f] += w;
      }
    }
    if (weight[f] > 0) {
      x[f] /= weight[f];
      y[f] /= weight[f];
      weight[f] = 1;
    }
    if (standing[f] > 0) lift[f] /= standing[f];
    std::swap(X, before);
  }
  const double stiffness = anchor_time * motion.rate * anchor_time * motion.rate;
  x = pass_through(x, weight, stiffness);
  y = pass_through(y, weight, stiffness);
  lift = pass_through(lift, standing, stiffness);
  Vec3 shift;
  for (std::size_t f = 0; f < n; ++f) {
    if (f > 0) shift -= Vec3{x[f], y[f], 0};
    displace(m, {Mat3::identity(), shift + Vec3{0, 0, lift[f]}}, motion.frame(static_cast<int>(f)));
  }
}

/// Share [feet][frames], 0 to 1, with which each foot follows the displacement of the root: 0 in contact, 1 in swing and flight.
std::vector<std::vector<double>> swing_shares(const FootContacts& contacts, double rate) {
  std::vector<std::vector<double>> out;
  for (const std::vector<std::uint8_t>& on : contacts.bears) {
    const std::size_t n = on.size();
    std::vector<double> away(n, 1e9);
    for (std::size_t f = 0; f < n; ++f) away[f] = on[f] ? 0 : f > 0 ? away[f - 1] + 1 : 1e9;
    for (std::size_t f = n - 1; f-- > 0;) away[f] = std::min(away[f], away[f + 1] + 1);
    for (double& x : away) {
      const double s = std::min(1.0, x / (swing_ease * rate));
      x = s * s * (3 - 2 * s);
    }
    out.push_back(std::move(away));
  }
  return out;
}

class Correction {
 public:
  Correction(const Mechanism& m, const CorrectOptions& o, CorrectionReport& report) : m_(m), o_(o), report_(report) {}

  /// Corrects a motion that is not cyclic.
  Result<Motion> run(const Motion& motion) {
    if (!go_on(0)) return cancelled();
    FootContacts contacts = contacts_of(m_, motion);
    if (contacts.feet.empty())
      return fail(ErrorCode::structure, "mechanism " + m_.name(), "The mechanism has no feet.",
                  "Label the links that stand on the ground 'foot' or 'paw'.");
    report_.before = measure(m_, motion, contacts, o_);
    Motion original = motion, out = motion;
    report_.replaced_frames = remove_pops(m_, out);
    remove_jitter(m_, out, o_.smoothing);
    if (!go_on(0.1)) return cancelled();
    if (o_.level_floor) {
      const FloorPlane floor = find_floor(m_, out, contacts.feet);
      report_.floor_height = floor.height;
      report_.floor_tilt = atan2(norm(floor.slope), 1) * 180 / pi;
      for (Motion* level : {&original, &out})
        for (int f = 0; f < out.frames; ++f) displace(m_, floor.to_level(), level->frame(f));
    }
    contacts = contacts_of(m_, out);
    if (!o_.keep_duration) {
      Result<void> retimed = retime(contacts, original, out);
      if (!retimed) return fail(std::move(retimed.error()));
      contacts = contacts_of(m_, out);
    }
    if (!go_on(0.2)) return cancelled();
    keep_limits(m_, out);
    anchor(m_, contacts, out);
    Result<Motion> placed = place(contacts, out);
    if (!placed) return placed;
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

  /// Moves the root until the centre of mass is on its physical trajectory, with feet that stand still.
  Result<Motion> place(const FootContacts& contacts, const Motion& motion) {
    const motion_edit::FootLockOptions lock;
    std::vector<FootPath> paths = motion_edit::foot_paths(m_, motion, contacts);
    motion_edit::pin_stances(paths, motion.rate, 0, motion_edit::mean_leg_length(contacts.feet), lock);
    const std::vector<std::vector<double>> follows = swing_shares(contacts, motion.rate);
    Motion out = motion_edit::follow_paths(m_, motion, contacts.feet, paths, lock);
    const Observation first = observe(m_, out, contacts);
    // Around flights, the legs bound the height from which the body takes off and to which it lands.
    constexpr double around_flight = 0.4;      // s
    constexpr double lift_ease = 0.01;         // m: lifts of feet begin smoothly
    constexpr double take_off_stretch = 0.97;  // of the leg's length: a straight knee would move too fast
    std::vector<double> room(at(motion.frames), 1e9);
    std::vector<std::uint8_t> flies(at(motion.frames), 0);
    std::vector<Pose> X(at(m_.link_count()));
    const auto near_flight = [&](int f) {
      return std::ranges::any_of(first.flights, [&](const Flight& flight) {
        return f >= flight.first - around_flight * motion.rate && f <= flight.last + around_flight * motion.rate;
      });
    };
    for (const Flight& flight : first.flights) std::fill(flies.begin() + flight.first, flies.begin() + flight.last + 1, 1);
    for (int f = 0; f < motion.frames; ++f) {
      if (!near_flight(f)) continue;
      calc_poses(m_, {out.frame(f), at(out.nq)}, X);
      for (std::size_t k = 0; k < paths.size(); ++k)
        if (paths[k].bears[at(f)])
          room[at(f)] = std::min(
              room[at(f)], motion_edit::headroom(contacts.feet[k], paths[k].X_WF[at(f)].p, X, take_off_stretch * contacts.feet[k].length));
    }
    const std::vector<Vec3> displacement = find_centre_displacement(first, o_.gravity, room);
    std::vector<Vec3> shift = displacement;
    for (int round = 0; round < rounds; ++round) {
      if (!go_on(0.3 + 0.6 * round / rounds)) return cancelled();
      Motion moved = motion;
      std::vector<FootPath> goals = paths;
      for (int f = 0; f < motion.frames; ++f) {
        displace(m_, {Mat3::identity(), shift[at(f)]}, moved.frame(f));
        calc_poses(m_, {moved.frame(f), at(moved.nq)}, X);
        for (std::size_t k = 0; k < goals.size(); ++k) {
          Vec3& foot = goals[k].X_WF[at(f)].p;
          foot += shift[at(f)] * follows[k][at(f)];
          // in a flight, a foot is lifted before its leg would hold the body back
          if (!flies[at(f)]) continue;
          const double lack = -motion_edit::headroom(contacts.feet[k], foot, X, lock.stretch * contacts.feet[k].length);
          foot.z += 0.5 * (lack + std::sqrt(lack * lack + lift_ease * lift_ease));
        }
      }
      out = motion_edit::follow_paths(m_, moved, contacts.feet, goals, lock);
      for (int f = 0; f < motion.frames; ++f) {
        calc_poses(m_, {out.frame(f), at(out.nq)}, X);
        shift[at(f)] += first.centre[at(f)] + displacement[at(f)] - centre_of_mass(m_, X);
      }
    }
    return out;
  }

  const Mechanism& m_;
  const CorrectOptions& o_;
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
    const FootContacts contacts = contacts_of(m, motion);
    reported.before = reported.after = measure(m, motion, contacts, options);
    return motion;
  }
  Motion source = motion;
  source.torques = nullptr;
  const bool around = motion.cyclic && motion.frames > 2;
  CorrectOptions own = options;
  if (around) {
    own.keep_duration = true;  // the rounds stay equal
    source = motion_edit::three_rounds(source, m);
  }
  Result<Motion> out = Correction(m, own, reported).run(source);
  if (!out || !around) return out;
  Motion middle = *out;
  const int first = motion_edit::round_frames(motion);
  middle.q.assign(out->frame(first), out->frame(2 * first) + out->nq);
  middle.frames = first + 1;
  middle.contacts.clear();
  return motion_edit::middle_round(*out, m, cycle_of(middle, m));
}

}  // namespace ugoki::correction
