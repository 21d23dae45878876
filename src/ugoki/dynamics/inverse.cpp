#include "ugoki/base/check.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::dynamics {

void calc_inverse_dynamics(const Mechanism& m, Workspace& ws, std::span<const double> vdot, const Vec3& gravity,
                           std::span<const Vec6> external, std::span<double> tau) {
  UGOKI_CHECK(static_cast<int>(tau.size()) == m.nv() && (vdot.empty() || vdot.size() == tau.size()));
  const std::span<const LinkPlace> links = m.places();
  const Vec6 A0{{}, -gravity};
  for (std::size_t i = 0; i < links.size(); ++i) {
    const LinkPlace& link = links[i];
    Vec6 A = (link.parent >= 0 ? ws.A[static_cast<std::size_t>(link.parent)] : A0) + ws.C[i];
    if (!vdot.empty()) {
      for (int k = 0; k < link.nv; ++k)
        A += ws.S[static_cast<std::size_t>(link.v_index + k)] * vdot[static_cast<std::size_t>(link.v_index + k)];
    }
    ws.A[i] = A;
    ws.F[i] = ws.I[i] * A + cross_force(ws.V[i], ws.I[i] * ws.V[i]);
    if (!external.empty()) ws.F[i] -= Vec6{external[i].w - cross(ws.p0, external[i].v), external[i].v};
  }
  for (std::size_t i = links.size(); i-- > 0;) {
    const LinkPlace& link = links[i];
    for (int k = 0; k < link.nv; ++k) {
      const auto f = static_cast<std::size_t>(link.v_index + k);
      tau[f] = dot(ws.S[f], ws.F[i]) + (vdot.empty() ? 0.0 : ws.armature[f] * vdot[f]);
    }
    if (link.parent >= 0) ws.F[static_cast<std::size_t>(link.parent)] += ws.F[i];
  }
}

void calc_bias_forces(const Mechanism& m, Workspace& ws, std::span<const double> q, std::span<const double> v, const Vec3& gravity,
                      std::span<const Vec6> external, std::span<double> b) {
  UGOKI_CHECK(static_cast<int>(q.size()) == m.nq() && static_cast<int>(v.size()) == m.nv() && b.size() == v.size());
  const std::span<const LinkPlace> links = m.places();
  const Vec6 A0{{}, -gravity};
  std::vector<Vec6>& V = ws.pA;
  for (std::size_t i = 0; i < links.size(); ++i) {
    const LinkPlace& link = links[i];
    const bool based = link.parent >= 0;
    const auto parent = static_cast<std::size_t>(link.parent);
    Vec6 vJ;
    for (int k = link.v_index; k < link.v_index + link.nv; ++k) vJ += ws.S[static_cast<std::size_t>(k)] * v[static_cast<std::size_t>(k)];
    V[i] = based ? V[parent] + vJ : vJ;
    ws.A[i] = (based ? ws.A[parent] : A0) + cross_motion(V[i], vJ);
    if (link.type == JointType::planar || link.type == JointType::universal || link.type == JointType::floating)
      ws.A[i] += Pose{ws.X_WB[i].R, ws.X_WB[i].p - ws.p0}.motion_to_parent(
          joint_bias(m.links()[i].joint, q.data() + link.q_index, v.data() + link.v_index));
    ws.F[i] = {};
    if (ws.I[i].mass > 0) ws.F[i] = ws.I[i] * ws.A[i] + cross_force(V[i], ws.I[i] * V[i]);
    if (!external.empty()) ws.F[i] -= Vec6{external[i].w - cross(ws.p0, external[i].v), external[i].v};
  }
  for (std::size_t i = links.size(); i-- > 0;) {
    const LinkPlace& link = links[i];
    for (int k = link.v_index; k < link.v_index + link.nv; ++k)
      b[static_cast<std::size_t>(k)] = dot(ws.S[static_cast<std::size_t>(k)], ws.F[i]);
    if (link.parent >= 0) ws.F[static_cast<std::size_t>(link.parent)] += ws.F[i];
  }
}

}  // namespace ugoki::dynamics
