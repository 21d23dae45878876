#include "ugoki/base/check.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/dynamics/link_kernels.h"

namespace ugoki::dynamics {
namespace {

/// @param vdot [nv] or empty
LinkArguments arguments_of(const Mechanism& m, Workspace& ws, std::span<const double> vdot, const Vec3& gravity,
                           std::span<const Vec6> external, std::span<double> tau) {
  const Vec6* wrenches = nullptr;
  if (!external.empty()) {
    for (std::size_t i = 0; i < ws.F.size(); ++i) ws.F[i] = {external[i].w - cross(ws.p0, external[i].v), external[i].v};
    wrenches = ws.F.data();
  }
  return {m.places().data(),
          m.places().size(),
          ws.S.data(),
          ws.V.data(),
          ws.C.data(),
          ws.I.data(),
          wrenches,
          vdot.empty() ? nullptr : vdot.data(),
          ws.armature.data(),
          {gravity.x, gravity.y, gravity.z},
          reinterpret_cast<double*>(ws.scratch.data()),
          ws.F.data(),
          tau.data()};
}

}  // namespace

void calc_inverse_dynamics(const Mechanism& m, Workspace& ws, std::span<const double> vdot, const Vec3& gravity,
                           std::span<const Vec6> external, std::span<double> tau) {
  UGOKI_CHECK(static_cast<int>(tau.size()) == m.nv() && (vdot.empty() || vdot.size() == tau.size()));
  link_kernels().inverse(arguments_of(m, ws, vdot, gravity, external, tau));
}

void calc_bias_forces(const Mechanism& m, Workspace& ws, std::span<const double> q, std::span<const double> v, const Vec3& gravity,
                      std::span<const Vec6> external, std::span<double> b) {
  UGOKI_CHECK(static_cast<int>(q.size()) == m.nq() && static_cast<int>(v.size()) == m.nv() && b.size() == v.size());
  const std::span<const LinkPlace> links = m.places();
  for (std::size_t i = 0; i < links.size(); ++i)
    if (has_joint_bias(links[i].type))
      ws.pA[i] = Pose{ws.X_WB[i].R, ws.X_WB[i].p - ws.p0}.motion_to_parent(
          joint_bias(m.links()[i].joint, q.data() + links[i].q_index, v.data() + links[i].v_index));
  LinkArguments a = arguments_of(m, ws, v, gravity, external, b);
  a.C = ws.pA.data();
  link_kernels().bias(a);
}

}  // namespace ugoki::dynamics
