#include "ugoki/base/check.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::dynamics {

void calc_inverse_dynamics(const Mechanism& m, Workspace& ws, std::span<const double> vdot, const Vec3& gravity,
                           std::span<const Vec6> external, std::span<double> tau) {
  UGOKI_CHECK(static_cast<int>(tau.size()) == m.nv() && (vdot.empty() || vdot.size() == tau.size()));
  const std::span<const Link> links = m.links();
  const Vec6 A0{{}, -gravity};
  for (std::size_t i = 0; i < links.size(); ++i) {
    const Link& link = links[i];
    Vec6 A = (link.parent >= 0 ? ws.A[static_cast<std::size_t>(link.parent)] : A0) + ws.C[i];
    if (!vdot.empty()) {
      const int n = link.joint.nv();
      for (int k = 0; k < n; ++k) A += ws.S[static_cast<std::size_t>(link.v_index + k)] * vdot[static_cast<std::size_t>(link.v_index + k)];
    }
    ws.A[i] = A;
    ws.F[i] = ws.I[i] * A + cross_force(ws.V[i], ws.I[i] * ws.V[i]);
    if (!external.empty()) ws.F[i] -= Vec6{external[i].w - cross(ws.p0, external[i].v), external[i].v};
  }
  for (std::size_t i = links.size(); i-- > 0;) {
    const Link& link = links[i];
    const int n = link.joint.nv();
    for (int k = 0; k < n; ++k) {
      const auto f = static_cast<std::size_t>(link.v_index + k);
      tau[f] = dot(ws.S[f], ws.F[i]) + (vdot.empty() ? 0.0 : ws.dofs[f].armature * vdot[f]);
    }
    if (link.parent >= 0) ws.F[static_cast<std::size_t>(link.parent)] += ws.F[i];
  }
}

}  // namespace ugoki::dynamics
