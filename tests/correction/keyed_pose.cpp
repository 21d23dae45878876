#include "keyed_pose.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "ugoki/mechanism/state.h"
#include "ugoki/motion/contact_labels.h"
#include "ugoki/spatial/rotation.h"

namespace ugoki::correction {

Vec3 arm_turn(double side, const Vec3& direction) {
  const Vec3 from{0, side, 0}, to = normalized(direction), axis = cross(from, to);
  return axis * (std::atan2(norm(axis), dot(from, to)) / std::max(1e-9, norm(axis)));
}

void set_joint(const Mechanism& m, const std::string& name, const Vec3& turn, std::vector<double>& q) {
  for (const Link& link : m.links()) {
    if (link.name != name) continue;
    const auto i = static_cast<std::size_t>(link.q_index);
    if (link.joint.nq() == 1) {
      q[i] = turn.x + turn.y;
      return;
    }
    const Quat r = exp_map(turn);
    q[i] = r.w, q[i + 1] = r.x, q[i + 2] = r.y, q[i + 3] = r.z;
  }
}

std::vector<double> pose(const Mechanism& m, const Key& k) {
  std::vector<double> q = m.neutral();
  for (const double side : {1.0, -1.0}) {
    const std::string s = side > 0 ? "Left" : "Right";
    const Side& limb = side > 0 ? k.left : k.right;
    set_joint(m, s + "Arm", arm_turn(side, {limb.arm.x, side * limb.arm.y, limb.arm.z}), q);
    set_joint(m, s + "ForeArm", {limb.elbow, 0, 0}, q);
    set_joint(m, s + "UpLeg", {side * limb.out, -limb.hip, 0}, q);
    set_joint(m, s + "Leg", {0, limb.knee, 0}, q);
    set_joint(m, s + "Foot", {0, limb.ankle, 0}, q);
  }
  for (const char* name : {"Spine", "Spine1", "Chest"}) set_joint(m, name, {0, k.spine, 0}, q);
  for (const char* name : {"Neck", "Head"}) set_joint(m, name, {0, k.neck, 0}, q);
  const Quat r = exp_map(k.turn);
  q[0] = k.place.x, q[1] = k.place.y, q[2] = k.place.z;
  q[3] = r.w, q[4] = r.x, q[5] = r.y, q[6] = r.z;
  return q;
}

double lowest_point(const Mechanism& m, std::span<const double> q) {
  std::vector<Pose> X(m.links().size());
  calc_poses(m, q, X);
  double z = 1e9;
  for (std::size_t i = 0; i < X.size(); ++i)
    for (const SupportPoint& p : support_points(m.links()[i])) z = std::min(z, (X[i] * p.p).z - p.radius);
  return z;
}

Motion through_keys(const Mechanism& m, std::span<const Key> keys, double rate, int rounds) {
  const auto nq = static_cast<std::size_t>(m.nq());
  Motion out;
  out.name = "keys";
  out.mechanism = m.name();
  out.rate = rate;
  out.nq = m.nq();
  out.frames = static_cast<int>(std::lround(keys.back().time * rate)) + 1;
  out.q.resize(nq * static_cast<std::size_t>(out.frames));
  const auto frame = [&](int f) { return std::span(out.frame(f), nq); };
  for (int f = 0; f < out.frames; ++f) {
    std::size_t k = 0;
    while (k + 2 < keys.size() && keys[k + 1].time <= f / rate) ++k;
    const double s = std::clamp((f / rate - keys[k].time) / (keys[k + 1].time - keys[k].time), 0.0, 1.0);
    interpolate(m, pose(m, keys[k]), pose(m, keys[k + 1]), s, frame(f));
  }
  std::vector<double> mean(nq);
  for (int round = 0; round < rounds; ++round) {
    const Motion before = out;
    for (int f = 1; f + 1 < out.frames; ++f) {
      interpolate(m, std::span(before.frame(f - 1), nq), std::span(before.frame(f + 1), nq), 0.5, mean);
      interpolate(m, std::span(before.frame(f), nq), mean, 0.5, frame(f));
    }
  }
  return out;
}

void roll_over_ground(const Mechanism& m, Motion& motion) {
  const auto nq = static_cast<std::size_t>(motion.nq);
  std::vector<Pose> X(m.links().size()), before(X.size());
  Vec3 shift;
  for (int f = 0; f < motion.frames; ++f) {
    calc_poses(m, std::span(motion.frame(f), nq), X);
    double low = 1e9;
    std::size_t link = 0;
    Vec3 point;
    for (std::size_t i = 0; i < X.size(); ++i)
      for (const SupportPoint& p : support_points(m.links()[i]))
        if (const double z = (X[i] * p.p).z - p.radius; z < low) {
          low = z;
          link = i;
          point = p.p + transpose_times(X[i].R, Vec3{0, 0, -p.radius});
        }
    if (f > 0) shift -= X[link] * point - before[link] * point;
    shift.z = -low;
    before = X;
    for (int k = 0; k < 3; ++k) motion.frame(f)[k] += shift[k];
  }
}

}  // namespace ugoki::correction
