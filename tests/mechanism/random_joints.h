#pragma once
// Random joints and coordinates of every type.

#include <array>
#include <random>

#include "ugoki/mechanism/joint.h"

namespace ugoki::test {

inline constexpr std::array all_joint_types = {JointType::fixed,     JointType::revolute,    JointType::prismatic,
                                               JointType::helical,   JointType::cylindrical, JointType::planar,
                                               JointType::universal, JointType::spherical,   JointType::floating};

class Random {
 public:
  double in(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  int below(int n) { return std::uniform_int_distribution<int>(0, n - 1)(engine_); }
  Vec3 vec(double size = 1) { return {in(-size, size), in(-size, size), in(-size, size)}; }
  Vec3 unit() {
    for (;;) {
      const Vec3 v = vec();
      if (norm(v) > 0.1 && norm(v) < 1) return v / norm(v);
    }
  }
  Pose pose() { return {rotation_about(unit(), in(-pi, pi)), vec()}; }
  Joint joint(JointType type) {
    Joint j;
    j.type = type;
    j.axis = unit();
    j.axis2 = normalized(cross(j.axis, unit()) + j.axis * 0.2);  // deliberately not perpendicular to axis
    j.pitch = in(-0.3, 0.3);
    j.X_PJ = pose();
    return j;
  }
  void coordinates(const Joint& j, double* q) {
    for (int i = 0; i < j.nq(); ++i) q[i] = in(-2, 2);
    const int at = j.type == JointType::spherical ? 0 : j.type == JointType::floating ? 3 : -1;
    if (at < 0) return;
    const Quat r = axis_angle(unit(), in(-pi, pi));
    q[at] = r.w;
    q[at + 1] = r.x;
    q[at + 2] = r.y;
    q[at + 3] = r.z;
  }

 private:
  std::mt19937_64 engine_{123};
};

}  // namespace ugoki::test
