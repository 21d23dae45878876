#include "ugoki/mechanism/state.h"

#include <cmath>

#include "ugoki/base/check.h"
#include "ugoki/mechanism/link_pose.h"

namespace ugoki {

void calc_poses(const Mechanism& m, std::span<const double> q, std::span<Pose> X_WB) {
  UGOKI_CHECK(static_cast<int>(q.size()) == m.nq() && static_cast<int>(X_WB.size()) == m.link_count());
  for (std::size_t i = 0; i < X_WB.size(); ++i) {
    const Link& link = m.links()[i];
    const Pose& X_PJ = link.joint.X_PJ;
    const Pose X_WJ = link.parent < 0 ? X_PJ : joint_frame_pose(X_WB[static_cast<std::size_t>(link.parent)], X_PJ);
    X_WB[i] = link_pose(X_WJ, link.joint, q.data() + link.q_index);
  }
}

void calc_velocities(const Mechanism& m, std::span<const double> q, std::span<const double> v, std::span<Vec6> V) {
  UGOKI_CHECK(static_cast<int>(v.size()) == m.nv() && static_cast<int>(V.size()) == m.link_count());
  for (std::size_t i = 0; i < V.size(); ++i) {
    const Link& link = m.links()[i];
    Vec6 S[6];
    const int n = joint_subspace(link.joint, q.data() + link.q_index, S);
    Vec6 V_B;
    if (link.parent >= 0) {
      const Pose X_PB = link.joint.X_PJ * joint_pose(link.joint, q.data() + link.q_index);
      V_B = X_PB.motion_to_child(V[static_cast<std::size_t>(link.parent)]);
    }
    for (int k = 0; k < n; ++k) V_B += S[k] * v[static_cast<std::size_t>(link.v_index + k)];
    V[i] = V_B;
  }
}

void integrate(const Mechanism& m, std::span<const double> q, std::span<const double> v, double dt, std::span<double> q_out) {
  for (const LinkPlace& link : m.places())
    joint_integrate(link.type, q.data() + link.q_index, v.data() + link.v_index, dt, q_out.data() + link.q_index);
}

void difference(const Mechanism& m, std::span<const double> q0, std::span<const double> q1, std::span<double> v) {
  for (const LinkPlace& link : m.places())
    joint_difference(link.type, q0.data() + link.q_index, q1.data() + link.q_index, v.data() + link.v_index);
}

void interpolate(const Mechanism& m, std::span<const double> q0, std::span<const double> q1, double s, std::span<double> q_out) {
  for (const Link& link : m.links()) {
    double d[6];
    joint_difference(link.joint, q0.data() + link.q_index, q1.data() + link.q_index, d);
    joint_integrate(link.joint, q0.data() + link.q_index, d, s, q_out.data() + link.q_index);
  }
}

Vec3 centre_of_mass(const Mechanism& m, std::span<const Pose> X_WB) {
  Vec3 first_moment;
  double mass = 0;
  for (std::size_t i = 0; i < X_WB.size(); ++i) {
    const Inertia& inertia = m.links()[i].inertia;
    first_moment += X_WB[i].R * inertia.h + X_WB[i].p * inertia.mass;
    mass += inertia.mass;
  }
  return mass > 0 ? first_moment / mass : Vec3{};
}

bool is_finite(std::span<const double> values) {
  for (const double x : values)
    if (!std::isfinite(x)) return false;
  return true;
}

}  // namespace ugoki
