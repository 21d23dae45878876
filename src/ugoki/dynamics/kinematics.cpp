#include "ugoki/base/check.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/dynamics/link_kernels.h"
#include "ugoki/mechanism/link_pose.h"

namespace ugoki::dynamics {

namespace {

/// Pose, motion subspace, velocity and velocity-product acceleration of link i, from the pose and velocity of its parent. For joints that
/// LinkKernels::kinematics does not compute.
void update_link(const Mechanism& m, std::size_t i, std::span<const double> q, std::span<const double> v, Kinematics& out) {
  const Link& link = m.links()[i];
  const Joint& joint = link.joint;
  const double* qj = q.data() + link.q_index;
  const double* vj = v.data() + link.v_index;
  const bool based = link.parent >= 0;
  const auto parent = static_cast<std::size_t>(link.parent);
  const Pose X_WJ = based ? joint_frame_pose(out.X_WB[parent], joint.X_PJ) : joint.X_PJ;
  const Pose X_WB = link_pose(X_WJ, joint, qj);
  if (i == 0) out.p0 = X_WB.p;
  out.X_WB[i] = X_WB;
  const Pose X{X_WB.R, X_WB.p - out.p0};
  Vec6* S = out.S.data() + link.v_index;
  Vec6 S_B[6], vJ;
  const int n = joint_subspace(joint, qj, S_B);
  for (int k = 0; k < n; ++k) {
    S[k] = X.motion_to_parent(S_B[k]);
    vJ += S[k] * vj[k];
  }
  out.V[i] = based ? out.V[parent] + vJ : vJ;
  out.C[i] = cross_motion(out.V[i], vJ) + X.motion_to_parent(joint_bias(joint, qj, vj));
}

/// Kinematics of the links from `begin` to `end`.
void update_links(const Mechanism& m, std::span<const double> q, std::span<const double> v, std::size_t begin, std::size_t end,
                  bool inertias, Kinematics& k) {
  const KinematicsArguments a{m.links().data(), m.places().data(), q.data(),   v.data(),   &k.p0,
                              k.X_WB.data(),    k.S.data(),        k.V.data(), k.C.data(), inertias ? k.I.data() : nullptr};
  for (std::size_t i = begin;; ++i) {
    i = link_kernels().kinematics(a, i, end);
    if (i == end) return;
    update_link(m, i, q, v, k);
    if (inertias) k.I[i] = m.links()[i].inertia.in_parent({k.X_WB[i].R, k.X_WB[i].p - k.p0});
  }
}

/// update_link() for a mechanism that is one free body. The motion subspace is exact: rotation about the body's axes, translation along the
/// joint's axes.
void update_free_body(const Link& link, std::span<const double> q, std::span<const double> v, Kinematics& out) {
  const Mat3& T = link.joint.X_PJ.R;
  const Pose X_WB = link_pose(link.joint.X_PJ, link.joint, q.data());
  out.p0 = X_WB.p;
  out.X_WB[0] = X_WB;
  for (int k = 0; k < 3; ++k) {
    out.S[static_cast<std::size_t>(k)] = {X_WB.R.column(k), {}};
    out.S[static_cast<std::size_t>(k) + 3] = {{}, T.column(k)};
  }
  const Vec6 V{X_WB.R * Vec3{v[0], v[1], v[2]}, T * Vec3{v[3], v[4], v[5]}};
  out.V[0] = V;
  out.C[0] = {{}, -cross(V.w, V.v)};
  out.I[0] = {link.inertia.mass, X_WB.R * link.inertia.h, rotated(link.inertia.I, X_WB.R)};
}

}  // namespace

void update_kinematics(const Mechanism& m, std::span<const double> q, std::span<const double> v, Kinematics& out) {
  UGOKI_CHECK(static_cast<int>(q.size()) == m.nq() && static_cast<int>(v.size()) == m.nv());
  if (out.X_WB.size() == 1 && m.link(0).joint.type == JointType::floating) return update_free_body(m.link(0), q, v, out);
  update_links(m, q, v, 0, out.X_WB.size(), true, out);
}

void update_path_kinematics(const Mechanism& m, std::span<const double> q, std::span<const double> v, int link, std::span<char> known,
                            Kinematics& out) {
  UGOKI_CHECK(static_cast<int>(q.size()) == m.nq() && static_cast<int>(v.size()) == m.nv());
  UGOKI_CHECK(static_cast<int>(known.size()) == m.link_count());
  if (known[0] == 0) update_links(m, q, v, 0, 1, false, out);  // all other links use the reference point p0
  known[0] = 1;
  while (known[static_cast<std::size_t>(link)] == 0) {
    int next = link;  // the unknown link of the path that is closest to the base
    for (int parent = m.link(next).parent; parent >= 0 && known[static_cast<std::size_t>(parent)] == 0; parent = m.link(next).parent)
      next = parent;
    update_links(m, q, v, static_cast<std::size_t>(next), static_cast<std::size_t>(next) + 1, false, out);
    known[static_cast<std::size_t>(next)] = 1;
  }
}

void calc_point_jacobian(const Workspace& ws, int link, const Vec3& p_W, std::span<Vec3> rows) {
  const std::span<const int> chain = chain_of_link(ws, link);
  const Vec3 r = p_W - ws.p0;
  for (std::size_t k = 0; k < chain.size(); ++k) {
    const Vec6& S = ws.S[static_cast<std::size_t>(chain[k])];
    rows[k] = S.v + cross(S.w, r);
  }
}

Vec3 point_velocity(const Kinematics& k, int link, const Vec3& p_W) {
  const Vec6& V = k.V[static_cast<std::size_t>(link)];
  return V.v + cross(V.w, p_W - k.p0);
}

double kinetic_energy(const Mechanism& m, const Workspace& ws) {
  double twice = 0;
  for (std::size_t i = 0; i < ws.V.size(); ++i) twice += dot(ws.V[i], ws.I[i] * ws.V[i]);
  UGOKI_CHECK(ws.V.size() == m.links().size());
  return 0.5 * twice;
}

double potential_energy(const Mechanism& m, const Workspace& ws, const Vec3& gravity) {
  UGOKI_CHECK(ws.I.size() == m.links().size());
  double energy = 0;
  for (const Inertia& I : ws.I) energy -= dot(gravity, I.h + ws.p0 * I.mass);
  return energy;
}

Vec6 momentum(const Mechanism& m, const Workspace& ws) {
  UGOKI_CHECK(ws.V.size() == m.links().size());
  Vec6 h;
  for (std::size_t i = 0; i < ws.V.size(); ++i) h += ws.I[i] * ws.V[i];
  return {h.w + cross(ws.p0, h.v), h.v};
}

}  // namespace ugoki::dynamics
