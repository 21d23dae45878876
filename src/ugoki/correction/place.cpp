#include "ugoki/correction/place.h"

#include <algorithm>
#include <cmath>

#include "ugoki/correction/centre_path.h"
#include "ugoki/correction/observe.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion_edit/foot_lock.h"

namespace ugoki::correction {
namespace {

using motion_edit::FootContacts;
using motion_edit::FootPath;

constexpr int rounds = 4;                              // of moving the root to the wanted centre of mass, and the limbs to their paths
constexpr int releases = 3;                            // rounds of removing contacts that are not reached
constexpr double max_rise = 0.03;                      // m
constexpr double swing_ease = 0.12;                    // s before and after a stance in which a foot begins and ceases to follow the root
constexpr double lift_ease = 0.01, sink_ease = 0.002;  // m: lifts of feet begin smoothly
// Around flights, the legs bound the height from which the body takes off and to which it lands.
constexpr double around_flight = 0.4;      // s
constexpr double take_off_stretch = 0.97;  // of the leg's length: a straight knee would move too fast

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// max(0, x) with a continuous slope: a parabola between -ease and ease.
double positive_part(double x, double ease) {
  if (x <= -ease) return 0;
  return x >= ease ? x : 0.25 / ease * (x + ease) * (x + ease);
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

/// Ends contacts that the limb does not reach: the body has moved on. @return false: there were none
bool release_unreached(const Mechanism& m, const Motion& motion, const std::vector<FootPath>& paths, FootContacts& contacts) {
  constexpr double tolerance = 0.03;  // fraction of the limb's length that the root may sink
  bool released = false;
  std::vector<Pose> X(at(m.link_count()));
  for (int f = 0; f < motion.frames; ++f) {
    calc_poses(m, {motion.frame(f), at(motion.nq)}, X);
    for (std::size_t k = 0; k < paths.size(); ++k) {
      const double length = contacts.feet[k].length;
      if (!contacts.bears[k][at(f)] || motion_edit::headroom(contacts.feet[k], paths[k].X_WF[at(f)].p, X, length) > -tolerance * length)
        continue;
      contacts.bears[k][at(f)] = contacts.heel[k][at(f)] = contacts.toe[k][at(f)] = 0;
      released = true;
    }
  }
  return released;
}

/// Heights [limbs][frames] m of the lowest points of the limbs on their paths.
std::vector<std::vector<double>> heights_of(const std::vector<FootPath>& paths) {
  std::vector<std::vector<double>> out;
  for (const FootPath& path : paths) {
    std::vector<double> heights;
    const std::size_t count = path.X_WF.empty() ? 0 : path.points.size() / path.X_WF.size();
    for (std::size_t f = 0; f < path.X_WF.size(); ++f) {
      double low = 1e300;
      for (std::size_t i = 0; i < count; ++i) {
        const SupportPoint& p = path.points[f * count + i];
        low = std::min(low, (path.X_WF[f] * p.p).z - p.radius);
      }
      heights.push_back(low);
    }
    out.push_back(std::move(heights));
  }
  return out;
}

/// Moves the root of each frame.
Motion shifted(const Mechanism& m, const Motion& motion, const std::vector<Vec3>& shift) {
  Motion out = motion;
  for (int f = 0; f < out.frames; ++f) displace(m, {Mat3::identity(), shift[at(f)]}, out.frame(f));
  return out;
}

/// What the body is to do.
struct Plan {
  std::vector<FootPath> paths;      ///< [limbs] with pinned stances
  Observation seen;                 ///< the motion with pinned stances
  std::vector<std::uint8_t> flies;  ///< [frames]
  std::vector<Vec3> displacement;   ///< [frames] m: of the centre of mass
};

Plan make_plan(const Mechanism& m, const Motion& motion, const FootContacts& contacts, double gravity) {
  const motion_edit::FootLockOptions lock;
  Plan plan;
  plan.paths = motion_edit::foot_paths(m, motion, contacts);
  motion_edit::pin_stances(plan.paths, motion.rate, 0, motion_edit::mean_leg_length(contacts.feet), lock);
  const Motion standing = motion_edit::follow_paths(m, motion, contacts.feet, plan.paths, lock);
  plan.seen = observe(m, standing, contacts);
  plan.flies.assign(at(motion.frames), 0);
  std::vector<double> room(at(motion.frames), 1e9);
  std::vector<Pose> X(at(m.link_count()));
  for (const Flight& flight : plan.seen.flights) {
    std::fill(plan.flies.begin() + flight.first, plan.flies.begin() + flight.last + 1, 1);
    const int reach = static_cast<int>(around_flight * motion.rate);
    for (int f = std::max(0, flight.first - reach); f <= std::min(motion.frames - 1, flight.last + reach); ++f) {
      calc_poses(m, {standing.frame(f), at(standing.nq)}, X);
      for (std::size_t k = 0; k < plan.paths.size(); ++k) {
        const motion_edit::FootLimb& foot = contacts.feet[k];
        if (!plan.paths[k].bears[at(f)]) continue;
        room[at(f)] = std::min(room[at(f)], motion_edit::headroom(foot, plan.paths[k].X_WF[at(f)].p, X, take_off_stretch * foot.length));
      }
    }
  }
  plan.displacement = find_centre_displacement(plan.seen, gravity, room);
  return plan;
}

}  // namespace

std::optional<Motion> place_body(const Mechanism& m, const Motion& motion, double gravity, const std::function<bool(double)>& progress,
                                 FootContacts& contacts) {
  const motion_edit::FootLockOptions lock;
  Plan plan = make_plan(m, motion, contacts, gravity);
  for (int round = 0; round < releases; ++round) {
    if (!release_unreached(m, shifted(m, motion, plan.displacement), plan.paths, contacts)) break;
    plan = make_plan(m, motion, contacts, gravity);
  }
  const std::vector<std::vector<double>> follows = swing_shares(contacts, motion.rate), heights = heights_of(plan.paths);
  std::vector<Vec3> shift = plan.displacement;
  std::vector<Pose> X(at(m.link_count()));
  Motion out = motion;
  for (int round = 0; round < rounds; ++round) {
    if (!progress(static_cast<double>(round) / rounds)) return std::nullopt;
    const Motion moved = shifted(m, motion, shift);
    std::vector<FootPath> goals = plan.paths;
    for (int f = 0; f < motion.frames; ++f) {
      calc_poses(m, {moved.frame(f), at(moved.nq)}, X);
      for (std::size_t k = 0; k < goals.size(); ++k) {
        Vec3& foot = goals[k].X_WF[at(f)].p;
        const double sink = -(heights[k][at(f)] + shift[at(f)].z) * follows[k][at(f)];  // a swinging foot stays above the ground
        foot += shift[at(f)] * follows[k][at(f)];
        foot.z += positive_part(sink, sink_ease);
        // a swinging foot that is out of reach comes closer to the body, which does not sink for it
        if (const motion_edit::FootLimb& limb = contacts.feet[k]; !limb.chain.empty()) {
          const Vec3 way = foot - X[at(limb.chain.front())].p;
          const double beyond = norm(way) - limb.length;
          if (beyond > 0) foot -= way * (beyond / norm(way) * follows[k][at(f)]);
        }
        // in a flight, a foot is lifted before its leg would hold the body back
        if (!plan.flies[at(f)]) continue;
        const double lack = -motion_edit::headroom(contacts.feet[k], foot, X, lock.stretch * contacts.feet[k].length);
        foot.z += 0.5 * (lack + std::sqrt(lack * lack + lift_ease * lift_ease));
      }
    }
    out = motion_edit::follow_paths(m, moved, contacts.feet, goals, lock);
    for (int f = 0; f < motion.frames; ++f) {
      calc_poses(m, {out.frame(f), at(out.nq)}, X);
      Vec3 error = plan.seen.centre[at(f)] + plan.displacement[at(f)] - centre_of_mass(m, X);
      // A root that was lowered because a limb is too short does not rise in further rounds, beyond what the masses of limbs cause.
      if (moved.frame(f)[2] - out.frame(f)[2] > 1e-4)
        error.z = std::min(error.z, std::max(0.0, plan.displacement[at(f)].z + max_rise - shift[at(f)].z));
      shift[at(f)] += error;
      shift[at(f)].z = std::max(shift[at(f)].z, -plan.seen.trunk_clearance[at(f)]);  // the trunk stays above the floor
    }
  }
  return out;
}

}  // namespace ugoki::correction
