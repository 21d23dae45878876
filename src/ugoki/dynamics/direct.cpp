// The functions of dynamics.h that start from (q, v). They run the fast kernels on one instance.

#include "ugoki/base/check.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/dynamics/kernels.h"

namespace ugoki::dynamics {
namespace {

KernelArguments<double> arguments(const Mechanism& m, Workspace& ws, std::span<const double> q) {
  const LinkProgram& program = ws.program;
  UGOKI_CHECK(program.nq == m.nq() && program.links.size() == m.links().size() && static_cast<int>(q.size()) == m.nq());
  return {.order = program.order.data(),
          .constants = program.constants.data(),
          .nodes = program.nodes(),
          .slots = program.slots,
          .nv = program.nv,
          .links = program.links.data(),
          .link_count = static_cast<int>(program.links.size()),
          .angle_q = program.angle_q.data(),
          .angle_sign = program.angle_sign.data(),
          .angles = program.angles(),
          .q = q.data(),
          .v = nullptr,
          .in = nullptr,
          .external = nullptr,
          .out = nullptr,
          .gravity = {},
          .scratch = ws.scratch.data()->bytes,
          .entry_index = nullptr,
          .stride = 1};
}

KernelArguments<double> arguments(const Mechanism& m, Workspace& ws, std::span<const double> q, std::span<const double> v,
                                  std::span<const double> in, const Vec3& gravity, std::span<const Vec6> external, std::span<double> out) {
  KernelArguments<double> a = arguments(m, ws, q);
  UGOKI_CHECK(static_cast<int>(v.size()) == m.nv() && out.size() == v.size() && (in.empty() || in.size() == v.size()));
  UGOKI_CHECK(external.empty() || external.size() == m.links().size());
  a.v = v.data();
  a.in = in.empty() ? nullptr : in.data();
  a.external = nonzero_wrenches(external);
  a.out = out.data();
  a.gravity[0] = gravity.x;
  a.gravity[1] = gravity.y;
  a.gravity[2] = gravity.z;
  return a;
}

}  // namespace

void calc_inverse_dynamics(const Mechanism& m, Workspace& ws, std::span<const double> q, std::span<const double> v,
                           std::span<const double> vdot, const Vec3& gravity, std::span<const Vec6> external, std::span<double> tau) {
  const KernelArguments<double> a = arguments(m, ws, q, v, vdot, gravity, external, tau);
  if (a.external == nullptr && !ws.twins.pairs.empty())
    kernels().inverse_twins(ws.twins.arguments(a));
  else
    kernels().inverse(a);
}

bool calc_forward_dynamics(const Mechanism& m, Workspace& ws, std::span<const double> q, std::span<const double> v,
                           std::span<const double> tau, const Vec3& gravity, std::span<const Vec6> external, std::span<double> vdot) {
  const KernelArguments<double> a = arguments(m, ws, q, v, tau, gravity, external, vdot);
  if (a.external == nullptr && !ws.twins.pairs.empty()) return kernels().forward_twins(ws.twins.arguments(a));
  return kernels().forward(a);
}

void calc_inertia_rows(const Mechanism& m, Workspace& ws, std::span<const double> q) {
  if (ws.chain.empty()) ws.make_rows(m);
  KernelArguments<double> a = arguments(m, ws, q);
  a.out = ws.M.data();
  a.entry_index = ws.entry_index.data();
  if (ws.twins.pairs.empty())
    kernels().inertia(a);
  else
    kernels().inertia_twins(ws.twins.arguments(a));
}

}  // namespace ugoki::dynamics
