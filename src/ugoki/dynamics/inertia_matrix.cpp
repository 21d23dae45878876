#include <cmath>

#include "ugoki/base/check.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::dynamics {

void calc_inertia_rows(const Mechanism& m, Workspace& ws) {
  if (ws.chain.empty()) ws.make_rows(m);
  const std::span<const Link> links = m.links();
  for (std::size_t i = 0; i < links.size(); ++i) ws.Ic[i] = ws.I[i];
  for (std::size_t i = links.size(); i-- > 0;) {
    const Link& link = links[i];
    if (link.parent >= 0) ws.Ic[static_cast<std::size_t>(link.parent)] += ws.Ic[i];
    const int n = link.joint.nv();
    for (int k = 0; k < n; ++k) {
      const auto f = static_cast<std::size_t>(link.v_index + k);
      const Vec6 F = ws.Ic[i] * ws.S[f];
      const auto start = static_cast<std::size_t>(ws.row_start[f]);
      const auto last = static_cast<std::size_t>(ws.depth[f]);
      for (std::size_t d = 0; d <= last; ++d) ws.M[start + d] = dot(ws.S[static_cast<std::size_t>(ws.chain[start + d])], F);
      ws.M[start + last] += ws.armature[f];
    }
  }
}

void calc_inertia_matrix(const Mechanism& m, Workspace& ws, std::span<double> M) {
  const auto n = static_cast<std::size_t>(m.nv());
  UGOKI_CHECK(M.size() == n * n);
  calc_inertia_rows(m, ws);
  copy_inertia_rows(ws, M);
}

void copy_inertia_rows(const Workspace& ws, std::span<double> M) {
  const std::size_t n = ws.depth.size();
  for (double& x : M) x = 0;
  for (std::size_t i = 0; i < n; ++i) {
    for (int e = ws.row_start[i]; e < ws.row_start[i + 1]; ++e) {
      const auto j = static_cast<std::size_t>(ws.chain[static_cast<std::size_t>(e)]);
      M[i * n + j] = M[j * n + i] = ws.M[static_cast<std::size_t>(e)];
    }
  }
}

int factor(Workspace& ws, std::span<const double> extra) {
  const std::size_t n = ws.depth.size();
  ws.L = ws.M;
  if (!extra.empty())
    for (std::size_t i = 0; i < n; ++i) ws.L[static_cast<std::size_t>(ws.row_start[i + 1] - 1)] += extra[i];
  for (std::size_t k = n; k-- > 0;) {
    double* row = ws.L.data() + ws.row_start[k];
    const int depth = ws.depth[k];
    const double pivot = row[depth];
    if (!(pivot > 0) || !std::isfinite(pivot)) return static_cast<int>(k);
    const double inverse_pivot = 1.0 / pivot;
    ws.D_inverse[k] = inverse_pivot;
    const int* chain = ws.chain.data() + ws.row_start[k];
    for (int d = depth - 1; d >= 0; --d) {
      const double a = row[d] * inverse_pivot;
      double* above = ws.L.data() + ws.row_start[static_cast<std::size_t>(chain[d])];
      for (int e = 0; e <= d; ++e) above[e] -= a * row[e];
    }
    for (int d = 0; d < depth; ++d) row[d] *= inverse_pivot;
  }
  return -1;
}

void solve(const Workspace& ws, std::span<double> x) {
  const std::size_t n = ws.depth.size();
  for (std::size_t k = n; k-- > 0;) {
    const double* row = ws.L.data() + ws.row_start[k];
    const int* chain = ws.chain.data() + ws.row_start[k];
    for (int d = 0; d < ws.depth[k]; ++d) x[static_cast<std::size_t>(chain[d])] -= row[d] * x[k];
  }
  for (std::size_t k = 0; k < n; ++k) x[k] *= ws.D_inverse[k];
  for (std::size_t k = 0; k < n; ++k) {
    const double* row = ws.L.data() + ws.row_start[k];
    const int* chain = ws.chain.data() + ws.row_start[k];
    double sum = x[k];
    for (int d = 0; d < ws.depth[k]; ++d) sum -= row[d] * x[static_cast<std::size_t>(chain[d])];
    x[k] = sum;
  }
}

void apply_inverse_transposed_factor(const Workspace& ws, int last, std::span<double> y) {
  const int* chain = ws.chain.data() + ws.row_start[static_cast<std::size_t>(last)];
  for (int d = ws.depth[static_cast<std::size_t>(last)]; d > 0; --d) {
    const double* row = ws.L.data() + ws.row_start[static_cast<std::size_t>(chain[d])];
    const double yd = y[static_cast<std::size_t>(d)];
    for (int e = 0; e < d; ++e) y[static_cast<std::size_t>(e)] -= row[e] * yd;
  }
}

}  // namespace ugoki::dynamics
