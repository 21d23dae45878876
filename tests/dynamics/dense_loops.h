#pragma once
// Forward dynamics of closed link systems in joint space as one dense linear system: a slow reference, independent of the recursions.

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "ugoki/dynamics/dynamics.h"
#include "ugoki/dynamics/loop_rows.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::testing {

/// Solves A x = b by elimination with full pivoting. A is symmetric and may be rank-deficient; the equations must be consistent.
/// @return the rank of A
inline int solve_dense(std::vector<double> A, std::vector<double> b, std::vector<double>& x) {
  const std::size_t n = b.size();
  std::vector<std::size_t> column(n);
  for (std::size_t i = 0; i < n; ++i) column[i] = i;
  double first = 0;
  std::size_t rank = 0;
  for (; rank < n; ++rank) {
    std::size_t r = rank, c = rank;
    for (std::size_t i = rank; i < n; ++i)
      for (std::size_t j = rank; j < n; ++j)
        if (std::fabs(A[i * n + j]) > std::fabs(A[r * n + c])) r = i, c = j;
    const double pivot = std::fabs(A[r * n + c]);
    first = std::max(first, pivot);
    if (!(pivot > 1e-11 * first)) break;
    for (std::size_t j = 0; j < n; ++j) std::swap(A[r * n + j], A[rank * n + j]);
    std::swap(b[r], b[rank]);
    for (std::size_t i = 0; i < n; ++i) std::swap(A[i * n + c], A[i * n + rank]);
    std::swap(column[c], column[rank]);
    for (std::size_t i = rank + 1; i < n; ++i) {
      const double f = A[i * n + rank] / A[rank * n + rank];
      for (std::size_t j = rank; j < n; ++j) A[i * n + j] -= f * A[rank * n + j];
      b[i] -= f * b[rank];
    }
  }
  x.assign(n, 0.0);
  for (std::size_t k = rank; k-- > 0;) {
    double y = b[k];
    for (std::size_t j = k + 1; j < rank; ++j) y -= A[k * n + j] * x[column[j]];
    x[column[k]] = y / A[k * n + k];
  }
  return static_cast<int>(rank);
}

/// Result of solve_by_kkt().
struct Dense {
  std::vector<double> vdot, force;  ///< force = J^T lambda
  int rank = 0;                     ///< number of independent rows of J
};

/// Solves M vdot - J^T lambda = tau - b, J vdot = -dJ/dt v for vdot and lambda. @param closed [loops] the loops that take part
inline Dense solve_by_kkt(const Mechanism& m, const State& s, const std::vector<Loop>& loops, std::span<const char> closed,
                          const Vec3& gravity = {0, 0, -9.81}) {
  dynamics::Workspace ws(m);
  dynamics::update_kinematics(m, s.q, s.v, ws);
  dynamics::LoopRows rows(loops);
  dynamics::update_loop_rows(m, ws, loops, s.q, s.v, rows);
  std::vector<double> products(static_cast<std::size_t>(rows.count())), J;
  dynamics::calc_loop_velocity_products(m, ws, loops, rows, products);
  const auto n = static_cast<std::size_t>(m.nv());
  std::vector<double> rates, row(n);
  for (std::size_t i = 0; i < loops.size(); ++i)
    for (int r = 0; closed[i] && r < loops[i].rows(); ++r) {
      dynamics::calc_loop_jacobian_row(m, ws, loops[i], rows, static_cast<int>(i), r, row);
      J.insert(J.end(), row.begin(), row.end());
      rates.push_back(products[static_cast<std::size_t>(rows.first[i] + r)]);
    }
  const std::size_t c = rates.size(), size = n + c;
  std::vector<double> M(n * n), b(n), A(size * size), rhs(size), x;
  dynamics::calc_inertia_matrix(m, ws, M);
  dynamics::calc_inverse_dynamics(m, ws, {}, gravity, s.external, b);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) A[i * size + j] = M[i * n + j];
    rhs[i] = s.tau[i] - b[i];
  }
  for (std::size_t k = 0; k < c; ++k) {
    for (std::size_t j = 0; j < n; ++j) A[(n + k) * size + j] = A[j * size + n + k] = J[k * n + j];
    rhs[n + k] = -rates[k];
  }
  Dense out;
  out.rank = solve_dense(A, rhs, x) - static_cast<int>(n);
  out.vdot.assign(x.begin(), x.begin() + static_cast<std::ptrdiff_t>(n));
  out.force.assign(n, 0.0);
  for (std::size_t k = 0; k < c; ++k)
    for (std::size_t j = 0; j < n; ++j) out.force[j] -= J[k * n + j] * x[n + k];
  return out;
}

/// Maximum absolute difference, divided by the maximum absolute entry of b (at least 1).
inline double max_difference(std::span<const double> a, std::span<const double> b) {
  double difference = 0, size = 1;
  for (std::size_t i = 0; i < a.size(); ++i) {
    difference = std::max(difference, std::fabs(a[i] - b[i]));
    size = std::max(size, std::fabs(b[i]));
  }
  return difference / size;
}

}  // namespace ugoki::testing
