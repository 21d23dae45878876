#include <algorithm>
#include <cmath>

#include "ugoki/base/check.h"
#include "ugoki/dynamics/derivatives.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::dynamics {
namespace {

/// Rows of D^-1/2 L^-1 on the chains: row i of L^-1 is e_i minus L's entries times the rows of its ancestors, each a prefix.
void invert_factor(const Workspace& ws, std::span<double> G) {
  const std::size_t n = ws.depth.size();
  for (std::size_t i = 0; i < n; ++i) {
    const auto start = static_cast<std::size_t>(ws.row_start[i]);
    const auto depth = static_cast<std::size_t>(ws.depth[i]);
    double* row = G.data() + start;
    for (std::size_t e = 0; e < depth; ++e) row[e] = 0;
    row[depth] = 1;
    for (std::size_t e = 0; e < depth; ++e) {
      const double* above = G.data() + ws.row_start[static_cast<std::size_t>(ws.chain[start + e])];
      const double l = ws.L[start + e];
      for (std::size_t c = 0; c <= e; ++c) row[c] -= l * above[c];
    }
  }
  for (std::size_t i = 0; i < n; ++i)
    for (auto at = static_cast<std::size_t>(ws.row_start[i]); at < static_cast<std::size_t>(ws.row_start[i + 1]); ++at)
      G[at] *= std::sqrt(ws.D_inverse[static_cast<std::size_t>(ws.chain[at])]);
}

/// Freedoms that the chains of i and j share, j <= i.
std::size_t common_depth(const Workspace& ws, std::size_t i, std::size_t j) {
  const int* a = ws.chain.data() + ws.row_start[i];
  const int* b = ws.chain.data() + ws.row_start[j];
  int low = 0, high = std::min(ws.depth[i], ws.depth[j]) + 1;  // chains agree before `low`, differ from `high` on
  while (low < high) {
    const int middle = (low + high) / 2;
    if (a[middle] == b[middle])
      low = middle + 1;
    else
      high = middle;
  }
  return static_cast<std::size_t>(low);
}

}  // namespace

void calc_inverse_of_inertia(const Workspace& ws, std::span<double> M_inverse, std::span<double> scratch) {
  const std::size_t n = ws.depth.size();
  UGOKI_CHECK(M_inverse.size() == n * n && scratch.size() >= ws.chain.size());
  invert_factor(ws, scratch);
  for (std::size_t i = 0; i < n; ++i) {
    const double* row_i = scratch.data() + ws.row_start[i];
    for (std::size_t j = 0; j <= i; ++j) {
      const double* row_j = scratch.data() + ws.row_start[j];
      const std::size_t common = common_depth(ws, i, j);
      double sum = 0;
      for (std::size_t k = 0; k < common; ++k) sum += row_i[k] * row_j[k];
      M_inverse[i * n + j] = M_inverse[j * n + i] = sum;
    }
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
    : vdot(ws.S.size()), dq(ws.S.size() * ws.S.size()), dv(dq.size()), dtau(dq.size()), inverse(m, ws), scratch_(ws.chain.size()) {}

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
  calc_inverse_of_inertia(ws, d.dtau, d.scratch_);
  return -1;
}

}  // namespace ugoki::dynamics
