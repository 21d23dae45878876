#include "ugoki/base/check.h"
#include "ugoki/dynamics/derivatives.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::dynamics {
// Uses L M^-1 = D^-1 L^-T. The right side is upper triangular. Left of the diagonal, row i of M^-1 is therefore minus row i of L times the
// rows of M^-1 of the ancestors of DOF i. By symmetry, these rows are known up to column i.
void calc_inverse_of_inertia(const Workspace& ws, std::span<double> M_inverse) {
  const std::size_t n = ws.depth.size();
  UGOKI_CHECK(M_inverse.size() == n * n && ws.L.size() == ws.chain.size());
  for (std::size_t i = 0; i < n; ++i) {
    const double* l = ws.L.data() + ws.row_start[i];
    const int* chain = ws.chain.data() + ws.row_start[i];
    double* row = M_inverse.data() + i * n;
    for (std::size_t j = 0; j < i; ++j) row[j] = 0;
    for (int d = 0; d < ws.depth[i]; ++d) {
      const double* above = M_inverse.data() + static_cast<std::size_t>(chain[d]) * n;
      for (std::size_t j = 0; j < i; ++j) row[j] -= l[d] * above[j];
    }
    row[i] = ws.D_inverse[i];
    for (int d = 0; d < ws.depth[i]; ++d) row[i] -= l[d] * row[chain[d]];
    for (std::size_t j = 0; j < i; ++j) M_inverse[j * n + i] = row[j];
  }
}

void solve_columns(const Workspace& ws, std::span<double> X, std::size_t columns) {
  const std::size_t n = ws.depth.size();
  UGOKI_CHECK(X.size() == n * columns);
  for (std::size_t k = n; k-- > 0;) {
    const double* row = ws.L.data() + ws.row_start[k];
    const int* chain = ws.chain.data() + ws.row_start[k];
    const double* from = X.data() + k * columns;
    for (int d = 0; d < ws.depth[k]; ++d) {
      double* to = X.data() + static_cast<std::size_t>(chain[d]) * columns;
      for (std::size_t c = 0; c < columns; ++c) to[c] -= row[d] * from[c];
    }
  }
  for (std::size_t k = 0; k < n; ++k) {
    const double* row = ws.L.data() + ws.row_start[k];
    const int* chain = ws.chain.data() + ws.row_start[k];
    double* to = X.data() + k * columns;
    for (std::size_t c = 0; c < columns; ++c) to[c] *= ws.D_inverse[k];
    for (int d = 0; d < ws.depth[k]; ++d) {
      const double* from = X.data() + static_cast<std::size_t>(chain[d]) * columns;
      for (std::size_t c = 0; c < columns; ++c) to[c] -= row[d] * from[c];
    }
  }
}

ForwardDerivatives::ForwardDerivatives(const Mechanism& m, Workspace& ws)
    : vdot(ws.S.size()), dq(ws.S.size() * ws.S.size()), dv(dq.size()), dtau(dq.size()), inverse(m, ws) {}

int calc_forward_dynamics_derivatives(const Mechanism& m, Workspace& ws, std::span<const double> v, std::span<const double> tau,
                                      const Vec3& gravity, std::span<const Vec6> external, ForwardDerivatives& d) {
  const std::size_t n = d.vdot.size();
  UGOKI_CHECK(static_cast<std::size_t>(m.nv()) == n && tau.size() == n);
  calc_inertia_rows(m, ws);
  if (const int bad = factor(ws, {}); bad >= 0) return bad;
  calc_inverse_dynamics(m, ws, {}, gravity, external, d.vdot);
  for (std::size_t i = 0; i < n; ++i) d.vdot[i] = tau[i] - d.vdot[i];
  solve(ws, d.vdot);
  calc_inverse_dynamics_derivatives(m, ws, v, d.vdot, gravity, external, d.inverse);
  expand(ws, d.inverse.below_q, d.inverse.above_q, d.dq);
  expand(ws, d.inverse.below_v, d.inverse.above_v, d.dv);
  solve_columns(ws, d.dq, n);
  solve_columns(ws, d.dv, n);
  for (double& x : d.dq) x = -x;
  for (double& x : d.dv) x = -x;
  calc_inverse_of_inertia(ws, d.dtau);
  return -1;
}

}  // namespace ugoki::dynamics
