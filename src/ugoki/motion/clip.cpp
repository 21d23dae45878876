#include "ugoki/motion/clip.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/check.h"

namespace ugoki {

Placement operator*(const Placement& a, const Placement& b) {
  const SinCos h = sin_cos(a.heading);
  return {a.x + h.cos * b.x - h.sin * b.y, a.y + h.sin * b.x + h.cos * b.y, a.z + b.z, a.heading + b.heading};
}

Placement inverse(const Placement& a) {
  const SinCos h = sin_cos(a.heading);
  return {-(h.cos * a.x + h.sin * a.y), h.sin * a.x - h.cos * a.y, -a.z, -a.heading};
}

Placement repeated(const Placement& a, long count) {
  Placement out, power = a;
  for (; count > 0; count >>= 1) {
    if (count & 1) out = power * out;
    power = power * power;
  }
  return out;
}

Pose to_pose(const Placement& a) { return {to_matrix(axis_angle({0, 0, 1}, a.heading)), {a.x, a.y, a.z}}; }

namespace {

enum class Root { none, floating, planar };

Root root_of(const Mechanism& mechanism) {
  if (mechanism.link_count() == 0) return Root::none;
  const JointType type = mechanism.link(0).joint.type;
  return type == JointType::floating ? Root::floating : type == JointType::planar ? Root::planar : Root::none;
}

double heading_of(const Quat& q) { return 2 * atan2(q.w < 0 ? -q.z : q.z, std::fabs(q.w)); }

}  // namespace

Placement root_placement(const Mechanism& mechanism, std::span<const double> q) {
  UGOKI_CHECK(q.size() == static_cast<std::size_t>(mechanism.nq()));
  if (root_of(mechanism) == Root::none) return {};
  const Joint& joint = mechanism.link(0).joint;
  const Pose X = joint.X_PJ * joint_pose(joint, q.data());
  return {X.p.x, X.p.y, X.p.z, heading_of(to_quat(X.R))};
}

void displace_root(const Mechanism& mechanism, const Placement& by, std::span<double> q) {
  UGOKI_CHECK(q.size() == static_cast<std::size_t>(mechanism.nq()));
  const Root root = root_of(mechanism);
  if (root == Root::none) return;
  const Joint& joint = mechanism.link(0).joint;
  // The displacement expressed in the joint's frame: X_PJ^-1 * by * X_PJ.
  const Pose D = joint.X_PJ.inverse() * to_pose(by) * joint.X_PJ;
  if (root == Root::planar) {
    const Vec3 p = D * Vec3{q[0], q[1], 0};  // a planar joint has no coordinate for a displacement out of its plane
    q[0] = p.x;
    q[1] = p.y;
    q[2] += joint.X_PJ.R.zz >= 0 ? by.heading : -by.heading;
    return;
  }
  const Vec3 p = D * Vec3{q[0], q[1], q[2]};
  const Quat turn = axis_angle(transpose_times(joint.X_PJ.R, Vec3{0, 0, 1}), by.heading);
  const Quat r = normalized(turn * Quat{q[3], q[4], q[5], q[6]});
  q[0] = p.x;
  q[1] = p.y;
  q[2] = p.z;
  q[3] = r.w;
  q[4] = r.x;
  q[5] = r.y;
  q[6] = r.z;
}

ClipPhase phase_of(const Clip& clip, double duration, double t) {
  const double local = std::clamp(t - clip.start, 0.0, std::max(0.0, clip.length));
  const double at = clip.offset + local * clip.speed;
  if (!clip.loop || !(duration > 0)) return {std::clamp(at, 0.0, std::max(0.0, duration)), 0};
  const double rounds = std::floor(at / duration);
  return {std::clamp(at - rounds * duration, 0.0, duration), static_cast<long>(rounds)};
}

Placement placement_in(const Clip& clip, long rounds) {
  return rounds > 0 ? clip.placement * repeated(clip.cycle, rounds) : clip.placement;
}

Placement cycle_of(const Motion& motion, const Mechanism& mechanism) {
  const auto n = static_cast<std::size_t>(motion.nq);
  const Placement first = root_placement(mechanism, {motion.frame(0), n});
  const Placement last = root_placement(mechanism, {motion.frame(motion.frames - 1), n});
  Placement cycle = last * inverse(first);
  cycle.z = 0;  // repetitions must not accumulate a change of height
  return cycle;
}

void sample(const Clip& clip, const Motion& motion, const Mechanism& mechanism, double t, std::span<double> q) {
  const ClipPhase phase = phase_of(clip, motion.duration(), t);
  sample(motion, mechanism, phase.time, q);
  displace_root(mechanism, placement_in(clip, phase.rounds), q);
}

void lay_clip(Clip& clip, const Motion& motion, const Mechanism& mechanism, const Placement& at) {
  clip.cycle = clip.loop ? cycle_of(motion, mechanism) : Placement{};
  clip.placement = {};
  std::vector<double> q(static_cast<std::size_t>(motion.nq));
  sample(clip, motion, mechanism, clip.start, q);
  Placement root = root_placement(mechanism, q);
  root.z = 0;
  clip.placement = at * inverse(root);
}

Placement floor_placement(const Clip& clip, const Motion& motion, const Mechanism& mechanism, double t) {
  std::vector<double> q(static_cast<std::size_t>(motion.nq));
  sample(clip, motion, mechanism, t, q);
  Placement root = root_placement(mechanism, q);
  root.z = clip.placement.z;
  return root;
}

}  // namespace ugoki
