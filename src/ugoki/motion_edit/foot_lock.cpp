#include "ugoki/motion_edit/foot_lock.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/number.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/limb_reach.h"
#include "ugoki/motion_edit/rounds.h"

namespace ugoki::motion_edit {
namespace {

constexpr double max_drop = 0.3;  // maximum lowering of the root as a fraction of the limb's length; goals that need more are missed
constexpr ReachOptions foot_reach = {.damping = 0.01, .keep = true, .lever = 0.15, .enough = 2e-6, .iterations = 40};

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Distance [m] by which the root must be lowered so that the limb of this foot is not extended beyond its maximum.
double drop_for(const FootLimb& foot, const Vec3& goal, std::span<const Pose> X, double stretch) {
  if (!(foot.length > 0)) return 0;
  const double extension = norm(X[at(foot.link)].p - X[at(foot.chain.front())].p);
  const double limit = std::max(stretch * foot.length, std::min(extension, foot.length));
  return std::clamp(-headroom(foot, goal, X, limit), 0.0, max_drop * foot.length);
}

/// The single hinge between a limb's base and its end (the knee); its angle determines the distance between base and end, sqrt(a + b
/// cos(angle)), with the angle measured from the straight limb. Damped least squares cannot bend a straight limb, because its Jacobian is
/// singular there; this closed form can.
class Knee {
 public:
  /// @param motion used to find the side to which the limb bends
  Knee(const Mechanism& m, const Motion& motion, const FootLimb& foot) : m_(m), foot_(foot) {
    std::vector<Pose> X(at(m.link_count()));
    calc_poses(m, std::span(motion.frame(0), at(motion.nq)), X);
    for (std::size_t k = 1; k + 1 < foot.chain.size(); ++k) {
      const int link = foot.chain[k];
      if (m.link(link).joint.nv() == 0 || norm(X[at(link)].p - X[at(foot.chain.front())].p) < 0.1 * foot.length ||
          norm(X[at(link)].p - X[at(foot.link)].p) < 0.1 * foot.length)
        continue;
      const bool another = link_ >= 0;
      link_ = link;
      if (another || m.link(link).joint.type != JointType::revolute) {
        link_ = -1;
        return;
      }
    }
    if (link_ < 0) return;
    for (int f = 0; f < motion.frames; ++f) {
      const double* q = motion.frame(f);
      calc_poses(m, std::span(q, at(motion.nq)), X);
      side_ += from_straight(X).angle;
    }
    side_ = side_ < 0 ? -1 : 1;
  }

  /// Index of the hinge's link; -1: no joint or several joints between base and end.
  [[nodiscard]] int link() const { return link_; }

  /// Sets the hinge, within its limits, so that the distance from base to end equals the distance from base to `goal`. Updates q and X.
  void bend(const Vec3& goal, double* q, std::span<Pose> X) const {
    if (link_ < 0) return;
    double& angle = q[m_.link(link_).q_index];
    const Arc arc = from_straight(X);
    if (!(arc.b > 0)) return;
    const Vec3 way = goal - X[at(foot_.chain.front())].p;
    const double wanted = (dot(way, way) - arc.a) / arc.b;
    const Dof& limit = m_.link(link_).joint.dofs[0];
    const double before = angle, bent = angle - arc.angle + side_ * acos(std::clamp(wanted, -1.0, 1.0));
    angle = std::clamp(bent, std::min(before, limit.lower), std::max(before, limit.upper));
    for (const int i : foot_.chain) {
      const Link& link = m_.link(i);
      X[at(i)] = X[at(link.parent)] * link.joint.X_PJ * joint_pose(link.joint, q + link.q_index);
    }
  }

 private:
  struct Arc {
    double a = 0, b = 0;  ///< m^2: the squared distance from the limb's base to its end is a + b cos(angle)
    double angle = 0;     ///< rad, angle of the hinge from the straight limb, in (-pi, pi]
  };
  /// Coefficients a and b (see Arc) and the present angle of the hinge.
  [[nodiscard]] Arc from_straight(std::span<const Pose> X) const {
    const Pose& knee = X[at(link_)];
    const Vec3 n = knee.R * m_.link(link_).joint.axis;
    const Vec3 to_base = X[at(foot_.chain.front())].p - knee.p, to_end = X[at(foot_.link)].p - knee.p;
    const Vec3 u = to_base - n * dot(n, to_base),
               v = to_end - n * dot(n, to_end);  // components perpendicular to n; v is opposite to u when the limb is straight
    const double along = dot(n, to_end) - dot(n, to_base);
    return {dot(u, u) + dot(v, v) + along * along, 2 * norm(u) * norm(v), atan2(-dot(n, cross(u, v)), -dot(u, v))};
  }

  const Mechanism& m_;
  const FootLimb& foot_;
  int link_ = -1;
  double side_ = 0;
};

/// Smooth upper envelope of `need`: maximum within `reach` frames before and after, smoothed by two moving averages over `reach` frames.
std::vector<double> smooth_above(const std::vector<double>& need, int reach) {
  const int n = static_cast<int>(need.size()), half = std::max(1, reach / 2);
  if (std::all_of(need.begin(), need.end(), [](double x) { return x <= 0; })) return need;
  std::vector<double> out(need.size()), next(need.size());
  for (int i = 0; i < n; ++i)
    out[at(i)] = *std::max_element(need.begin() + std::max(0, i - 2 * half), need.begin() + std::min(n, i + 2 * half + 1));
  for (int pass = 0; pass < 2; ++pass) {
    for (int i = 0; i < n; ++i) {
      double sum = 0;
      for (int k = -half; k <= half; ++k) sum += out[at(std::clamp(i + k, 0, n - 1))];
      next[at(i)] = sum / (2 * half + 1);
    }
    std::swap(out, next);
  }
  return out;
}

FootContacts repeated_three_times(const FootContacts& contacts) {
  FootContacts out = contacts;
  for (auto* tracks : {&out.bears, &out.heel, &out.toe})
    for (std::vector<std::uint8_t>& on : *tracks) {
      const std::vector<std::uint8_t> one(on.begin(), on.end() - 1);
      on = one;
      for (int k = 0; k < 2; ++k) on.insert(on.end(), one.begin(), one.end());
      on.push_back(one.front());
    }
  return out;
}

}  // namespace

double headroom(const FootLimb& foot, const Vec3& goal, std::span<const Pose> X, double limit) {
  if (foot.chain.empty()) return 0;
  const Vec3 to_goal = goal - X[at(foot.chain.front())].p;
  if (to_goal.z >= 0) return limit;  // the foot is above the hip
  const double level = to_goal.x * to_goal.x + to_goal.y * to_goal.y, room = limit * limit - level;
  return to_goal.z + (room > 0 ? std::sqrt(room) : 0.0);
}

Motion follow_paths(const Mechanism& m, const Motion& motion, std::span<const FootLimb> feet, const std::vector<FootPath>& paths,
                    const FootLockOptions& o, FootLockReport* report) {
  Motion out = motion;
  FootLockReport unused;
  FootLockReport& reported = report ? *report : unused;
  std::vector<Pose> X(at(m.link_count()));
  const bool floats = m.link_count() > 0 && m.link(0).joint.type == JointType::floating;
  std::vector<double> drop(at(motion.frames), 0.0);
  for (int f = 0; f < motion.frames && floats; ++f) {
    calc_poses(m, std::span(motion.frame(f), at(motion.nq)), X);
    for (std::size_t k = 0; k < feet.size(); ++k)
      drop[at(f)] = std::max(drop[at(f)], drop_for(feet[k], paths[k].X_WF[at(f)].p, X, o.stretch));
  }
  std::vector<Knee> knees;
  for (const FootLimb& foot : feet) knees.emplace_back(m, motion, foot);
  drop = smooth_above(drop, static_cast<int>(o.drop_time * motion.rate + 0.5));
  for (int f = 0; f < motion.frames; ++f) {
    double* q = out.frame(f);
    if (floats) displace_root(m, {0, 0, -drop[at(f)], 0}, {q, at(out.nq)});
    reported.max_drop = std::max(reported.max_drop, drop[at(f)]);
    calc_poses(m, std::span<const double>(q, at(out.nq)), X);
    for (std::size_t k = 0; k < feet.size(); ++k) {
      const FootLimb& foot = feet[k];
      const Pose& goal = paths[k].X_WF[at(f)];
      reported.max_move = std::max(reported.max_move, norm(goal.p - X[at(foot.link)].p - Vec3{0, 0, drop[at(f)]}));
      if (foot.chain.empty()) continue;
      knees[k].bend(goal.p, q, X);
      ReachOptions with_knee = foot_reach;
      with_knee.held = knees[k].link();
      (void)reach(m, foot.chain, goal, with_knee, q, X);
      const double miss = norm(goal.p - X[at(foot.link)].p);
      if (!paths[k].bears[at(f)] || miss <= reported.max_miss) continue;
      reported.max_miss = miss;
      reported.miss_frame = f;
      reported.miss_link = m.link(foot.link).name;
    }
  }
  out.contacts.clear();
  for (std::size_t k = 0; k < feet.size(); ++k) out.contacts.push_back({m.link(feet[k].link).name, paths[k].bears});
  return out;
}

Result<Motion> lock_feet(const Mechanism& m, const Motion& motion, const FootContacts& contacts, const FootLockOptions& o,
                         FootLockReport* report) {
  if (Error wrong = check_motion(motion, m); !wrong.empty()) return fail(std::move(wrong));
  if (contacts.feet.empty())
    return fail(ErrorCode::structure, "mechanism " + m.name(), "The mechanism has no feet to lock.",
                "Name the links that stand on the ground, or label them 'foot' or 'paw'.");
  if (!(o.ease >= 0 && o.ease <= 10 && o.drop_time >= 0 && o.drop_time <= 10))
    return fail(ErrorCode::range, "foot lock",
                "The time of the correction is " + to_text(o.ease) + " s, that of the pelvis " + to_text(o.drop_time) + " s.",
                "Use times from 0 to 10 s.");
  if (!(o.stretch > 0 && o.stretch <= 1) || !(std::fabs(contacts.ground) <= 1e6))
    return fail(
        ErrorCode::range, "foot lock",
        "The maximum stretch is " + to_text(o.stretch) + " of the leg's length, and the ground is at " + to_text(contacts.ground) + " m.",
        "Use a stretch above 0 and at most 1, and a ground within 1e6 m.");
  const bool around = motion.cyclic && motion.frames > 2;
  const FootContacts c = around ? repeated_three_times(contacts) : contacts;
  const Motion extended = around ? three_rounds(motion, m) : motion;
  std::vector<FootPath> paths = foot_paths(m, extended, c);
  pin_stances(paths, motion.rate, c.ground, mean_leg_length(c.feet), o);
  FootLockReport reported;
  Motion out = follow_paths(m, extended, c.feet, paths, o, &reported);
  if (around) {
    out = middle_round(out, m, cycle_of(motion, m));
    if (reported.miss_frame >= 0) reported.miss_frame %= round_frames(motion);
  }
  reported.before = measure_skate(m, motion, contacts);
  reported.after = measure_skate(m, out, contacts);
  if (report) *report = reported;
  return out;
}

}  // namespace ugoki::motion_edit
