#include <algorithm>
#include <cmath>

#include "ugoki/base/check.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::dynamics {
namespace {

ArticulatedInertia articulated(const Inertia& r) { return {r.I, Mat3::skew(r.h), {r.mass, r.mass, r.mass, 0, 0, 0}}; }

Vec6 operator*(const ArticulatedInertia& a, const Vec6& m) { return {a.I * m.w + a.H * m.v, transpose_times(a.H, m.w) + a.M * m.v}; }

Sym3 outer(const Vec3& a, double s) { return {s * a.x * a.x, s * a.y * a.y, s * a.z * a.z, s * a.x * a.y, s * a.x * a.z, s * a.y * a.z}; }

/// a -= u u^T s
void subtract_outer(ArticulatedInertia& a, const Vec6& u, double s) {
  a.I = a.I - outer(u.w, s);
  a.H = a.H - Mat3::outer(u.w, u.v) * s;
  a.M = a.M - outer(u.v, s);
}

}  // namespace

// Articulated-body algorithm (Featherstone 2008, ch. 7). The DOFs of one joint are eliminated one by one, as if massless links connected
// them. All pivots are therefore scalars, and the order of elimination is that of factor().
bool calc_forward_dynamics(const Mechanism& m, Workspace& ws, std::span<const double> tau, const Vec3& gravity,
                           std::span<const Vec6> external, std::span<double> vdot) {
  UGOKI_CHECK(static_cast<int>(tau.size()) == m.nv() && vdot.size() == tau.size());
  const std::span<const Link> links = m.links();
  for (std::size_t i = 0; i < links.size(); ++i) {
    ws.IA[i] = articulated(ws.I[i]);
    ws.pA[i] = cross_force(ws.V[i], ws.I[i] * ws.V[i]);
    if (!external.empty()) ws.pA[i] -= Vec6{external[i].w - cross(ws.p0, external[i].v), external[i].v};
  }
  for (std::size_t i = links.size(); i-- > 0;) {
    const Link& link = links[i];
    ArticulatedInertia& IA = ws.IA[i];
    Vec6 p = ws.pA[i] + IA * ws.C[i];
    for (int k = link.joint.nv(); k-- > 0;) {
      const auto f = static_cast<std::size_t>(link.v_index + k);
      const Vec6& S = ws.S[f];
      ws.U[f] = IA * S;
      const double pivot = dot(S, ws.U[f]) + ws.armature[f];
      if (!(pivot > 0)) return false;
      ws.d[f] = 1.0 / pivot;
      ws.u[f] = tau[f] - dot(S, p);
      subtract_outer(IA, ws.U[f], ws.d[f]);
      p += ws.U[f] * (ws.d[f] * ws.u[f]);
    }
    if (link.parent >= 0) {
      const auto parent = static_cast<std::size_t>(link.parent);
      ArticulatedInertia& up = ws.IA[parent];
      up.I = up.I + IA.I;
      up.H += IA.H;
      up.M = up.M + IA.M;
      ws.pA[parent] += p;
    }
  }
  const Vec6 A0{{}, -gravity};
  for (std::size_t i = 0; i < links.size(); ++i) {
    const Link& link = links[i];
    Vec6 A = link.parent >= 0 ? ws.A[static_cast<std::size_t>(link.parent)] : A0;
    // u already includes the velocity product C through p, so C is added to A only after vdot is computed
    for (int k = 0; k < link.joint.nv(); ++k) {
      const auto f = static_cast<std::size_t>(link.v_index + k);
      vdot[f] = ws.d[f] * (ws.u[f] - dot(ws.U[f], A));
      A += ws.S[f] * vdot[f];
    }
    ws.A[i] = A + ws.C[i];
  }
  return true;
}

bool calc_forward_dynamics_by_factor(const Mechanism& m, Workspace& ws, std::span<const double> tau, const Vec3& gravity,
                                     std::span<const Vec6> external, std::span<double> vdot) {
  calc_inertia_rows(m, ws);
  if (factor(ws, {}) >= 0) return false;
  calc_inverse_dynamics(m, ws, {}, gravity, external, vdot);
  for (std::size_t i = 0; i < vdot.size(); ++i) vdot[i] = tau[i] - vdot[i];
  solve(ws, vdot);
  return true;
}

bool calc_forward_dynamics_by_unit_vectors(const Mechanism& m, Workspace& ws, std::span<const double> tau, const Vec3& gravity,
                                           std::span<const Vec6> external, std::span<double> vdot) {
  const auto n = static_cast<std::size_t>(m.nv());
  std::vector<double> b(n), A(n * n), unit(n), column(n);
  calc_inverse_dynamics(m, ws, {}, gravity, external, b);
  for (std::size_t i = 0; i < n; ++i) {
    unit[i] = 1;
    calc_inverse_dynamics(m, ws, unit, gravity, external, column);
    unit[i] = 0;
    for (std::size_t j = 0; j < n; ++j) A[j * n + i] = column[j] - b[j];
  }
  // Gaussian elimination with row pivoting
  for (std::size_t i = 0; i < n; ++i) vdot[i] = tau[i] - b[i];
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t best = k;
    for (std::size_t r = k + 1; r < n; ++r)
      if (std::fabs(A[r * n + k]) > std::fabs(A[best * n + k])) best = r;
    if (!(std::fabs(A[best * n + k]) > 0)) return false;
    if (best != k) {
      for (std::size_t c = 0; c < n; ++c) std::swap(A[k * n + c], A[best * n + c]);
      std::swap(vdot[k], vdot[best]);
    }
    for (std::size_t r = k + 1; r < n; ++r) {
      const double f = A[r * n + k] / A[k * n + k];
      if (f == 0) continue;
      for (std::size_t c = k; c < n; ++c) A[r * n + c] -= f * A[k * n + c];
      vdot[r] -= f * vdot[k];
    }
  }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t c = k + 1; c < n; ++c) vdot[k] -= A[k * n + c] * vdot[c];
    vdot[k] /= A[k * n + k];
  }
  return true;
}

}  // namespace ugoki::dynamics
