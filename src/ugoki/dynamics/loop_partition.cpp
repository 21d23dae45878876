#include "ugoki/dynamics/loop_partition.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ugoki/dynamics/dynamics.h"

namespace ugoki::dynamics {
namespace {

// Minimum of keep_limit. A choice of theta_S, the dependent DOFs (loop_partition.h), is kept while all entries of J_S^-1 J_G are below
// keep_limit. Just after full pivoting the maximum entry is about 1.
constexpr double min_keep_limit = 4;

/// Number of rows with a distance as gap in a loop of this type; these rows come first in the loop.
int distance_rows(LoopType type) {
  switch (type) {
    case LoopType::weld:
    case LoopType::ball:
    case LoopType::revolute:
    case LoopType::universal: return 3;
    case LoopType::prismatic:
    case LoopType::cylindrical: return 2;
    case LoopType::planar:
    case LoopType::distance: return 1;
    case LoopType::gear: return 0;
  }
  return 0;
}

/// Mean nonzero offset between joints, m: the typical lever arm between an angle and a displacement. 1 if all offsets are zero.
double mean_offset(const Mechanism& m, std::span<const Loop> loops) {
  double sum = 0;
  int count = 0;
  const auto add = [&](double x) {
    if (x > 0) {
      sum += x;
      ++count;
    }
  };
  for (const Link& link : m.links()) add(norm(link.joint.X_PJ.p));
  for (const Loop& loop : loops) {
    add(norm(loop.X_AJ.p));
    add(norm(loop.X_BJ.p));
    add(loop.length);
  }
  return count > 0 ? sum / count : 1.0;
}

void list_active_rows(const Mechanism& m, ClosedWorkspace& cw) {
  cw.active.clear();
  for (std::size_t i = 0; i < cw.closed.size(); ++i)
    for (int k = cw.rows.first[i]; cw.closed[i] && k < cw.rows.first[i + 1]; ++k) cw.active.push_back(k);
  cw.row_order.resize(cw.active.size());
  cw.J.resize(cw.active.size() * static_cast<std::size_t>(m.nv()));
  cw.rank = -1;
  cw.full_rank = -1;
}

/// Factors J_S, and computes K = -J_S^-1 J_G, for the present choice of theta_S and theta_G (loop_partition.h).
void solve_choice(ClosedWorkspace& cw) {
  const std::size_t n = cw.dof_order.size(), r = static_cast<std::size_t>(cw.rank), g = n - r;
  const std::span<double> J_S = cw.J_S.begin(cw.rank);
  for (std::size_t i = 0; i < r; ++i) {
    const double* row = cw.J.data() + static_cast<std::size_t>(cw.row_order[i]) * n;
    for (std::size_t j = 0; j < r; ++j) J_S[i * r + j] = row[cw.dof_order[j]];
    for (std::size_t j = 0; j < g; ++j) cw.K[i * g + j] = -row[cw.dof_order[r + j]];
  }
  cw.pivot_ratio = cw.J_S.factor();
  if (cw.pivot_ratio > 0) cw.J_S.solve_many(cw.K, static_cast<int>(g));
}

/// Maximum absolute value of the entries of K = -J_S^-1 J_G.
double max_entry(const ClosedWorkspace& cw) {
  double maximum = 0;
  const std::size_t count = static_cast<std::size_t>(cw.rank) * static_cast<std::size_t>(cw.dofs());
  for (std::size_t i = 0; i < count; ++i) maximum = std::max(maximum, std::fabs(cw.K[i]));
  return maximum;
}

/// Makes a new choice of the independent rows of J and of theta_S, the dependent DOFs, by full pivoting (loop_partition.h).
void choose(ClosedWorkspace& cw) {
  cw.pivots = cw.J;
  const int max_rank = cw.full_rank >= 0 ? cw.full_rank : static_cast<int>(cw.dof_order.size());
  cw.rank = choose_pivots(cw.pivots, cw.rank_tolerance, max_rank, cw.row_order, cw.dof_order);
  cw.rechosen = true;
  solve_choice(cw);
  cw.keep_limit = std::max(min_keep_limit, 2 * max_entry(cw));
}

/// Calls solve_choice() for the present choice. @return true if the choice is good enough to be kept
bool keep(ClosedWorkspace& cw) {
  if (cw.rank < 0 || cw.rank != cw.full_rank) return false;
  solve_choice(cw);
  return cw.pivot_ratio > cw.rank_tolerance && (cw.hold_choice || max_entry(cw) < cw.keep_limit);
}

/// Tries a new choice. The new choice replaces the present one only if it has the full rank and a pivot ratio more than 4 times as large.
/// Near a singular configuration every choice has small pivots, so a change would often not help.
void choose_if_better(ClosedWorkspace& cw) {
  const double previous_ratio = cw.pivot_ratio, limit = cw.keep_limit;
  cw.kept_dofs = cw.dof_order;
  cw.kept_rows = cw.row_order;
  choose(cw);
  if (cw.rank == cw.full_rank && cw.pivot_ratio > 4 * previous_ratio) return;
  cw.dof_order.swap(cw.kept_dofs);
  cw.row_order.swap(cw.kept_rows);
  cw.rank = cw.full_rank;
  cw.keep_limit = limit;
  cw.rechosen = false;
  solve_choice(cw);
}

/// Computes H (v = H v_G), in the units of v, from K = -J_S^-1 J_G.
void fill_H(ClosedWorkspace& cw) {
  const auto r = static_cast<std::size_t>(cw.rank), g = static_cast<std::size_t>(cw.dofs());
  const std::span<const int> S = cw.theta_S(), G = cw.theta_G();
  for (std::size_t j = 0; j < g; ++j) {
    const double unit = 1 / cw.dof_scale[static_cast<std::size_t>(G[j])];
    for (std::size_t i = 0; i < r; ++i) {
      const auto f = static_cast<std::size_t>(S[i]);
      cw.H[f * g + j] = cw.dof_scale[f] * cw.K[i * g + j] * unit;
    }
    for (std::size_t i = 0; i < g; ++i) cw.H[static_cast<std::size_t>(G[i]) * g + j] = i == j ? 1 : 0;
  }
}

}  // namespace

ClosedWorkspace::ClosedWorkspace(const Mechanism& m, std::span<const Loop> all_loops)
    : loops(all_loops.begin(), all_loops.end()), open(m), rows(loops) {
  const auto n = static_cast<std::size_t>(m.nv()), nq = static_cast<std::size_t>(m.nq());
  const auto max_rows = static_cast<std::size_t>(rows.count());
  length = mean_offset(m, loops);
  for (const Link& link : m.links())
    for (int k = 0; k < link.joint.nv(); ++k) dof_scale.push_back(is_distance(link.joint, k) ? length : 1.0);
  for (const Loop& loop : loops) {
    for (int r = 0; r < loop.rows(); ++r) row_scale.push_back(r < distance_rows(loop.type) ? 1 / length : 1.0);
    if (loop.type == LoopType::gear) row_scale.back() = 1 / dof_scale[static_cast<std::size_t>(loop.dof_a)];
    closed.push_back(loop.closed);
  }
  active.reserve(max_rows);
  row_order.reserve(max_rows);
  kept_rows.reserve(max_rows);
  kept_dofs.resize(n);
  J.reserve(max_rows * n);
  pivots.reserve(max_rows * n);
  dof_order.resize(n);
  const std::size_t max_rank = std::min(max_rows, n);
  J_S.resize(static_cast<int>(max_rank));
  K.resize(n * n);
  H.resize(n * n);
  A_G.resize(n * n);
  normal.reserve(max_rows * max_rows);
  for (auto* x : {&h, &v1, &v2, &v3, &vdot1, &vdot2, &tau1, &column, &b_G, &step}) x->resize(n);
  rest_V.resize(open.V.size());
  rest_C.resize(open.C.size());
  for (auto* x : {&q1, &q2, &q3}) x->resize(nq);
  products.resize(max_rows);
  multipliers.resize(max_rows);
  branch.resize(8 * n);
  list_active_rows(m, *this);
}

bool is_distance(const Joint& joint, int k) {
  switch (joint.type) {
    case JointType::prismatic: return true;
    case JointType::cylindrical: return k == 1;
    case JointType::planar: return k < 2;
    case JointType::floating: return k >= 3;
    default: return false;
  }
}

void set_closed(const Mechanism& m, ClosedWorkspace& cw, int loop, bool closed) {
  cw.closed[static_cast<std::size_t>(loop)] = closed;
  list_active_rows(m, cw);
}

void update_constraint_matrix(const Mechanism& m, ClosedWorkspace& cw) {
  const auto n = static_cast<std::size_t>(m.nv());
  double* row = cw.J.data();
  for (std::size_t i = 0; i < cw.closed.size(); ++i) {
    if (!cw.closed[i]) continue;
    const Loop& loop = cw.loops[i];
    for (int r = 0; r < loop.rows(); ++r, row += n) {
      calc_loop_jacobian_row(m, cw.open, loop, cw.rows, static_cast<int>(i), r, {row, n});
      const double scale = cw.row_scale[static_cast<std::size_t>(cw.rows.first[i] + r)];
      for (std::size_t j = 0; j < n; ++j) row[j] *= scale * cw.dof_scale[j];
    }
  }
}

void update_partition(const Mechanism& m, ClosedWorkspace& cw) {
  update_constraint_matrix(m, cw);
  cw.rechosen = false;
  if (!keep(cw))
    choose(cw);
  else if (cw.is_nearly_singular() && !cw.hold_choice)
    choose_if_better(cw);
  fill_H(cw);
}

void update_closed(const Mechanism& m, std::span<const double> q, std::span<const double> v, ClosedWorkspace& cw) {
  update_kinematics(m, q, v, cw.open);
  update_loop_rows(m, cw.open, cw.loops, q, v, cw.rows);
  update_partition(m, cw);
  calc_loop_velocity_products(m, cw.open, cw.loops, cw.rows, cw.products);
  std::ranges::fill(cw.h, 0.0);
  for (std::size_t i = 0; i < static_cast<std::size_t>(cw.rank); ++i) {
    const auto row = static_cast<std::size_t>(cw.active[static_cast<std::size_t>(cw.row_order[i])]);
    cw.column[i] = -cw.products[row] * cw.row_scale[row];
  }
  cw.J_S.solve(cw.column);
  for (std::size_t i = 0; i < static_cast<std::size_t>(cw.rank); ++i) {
    const auto f = static_cast<std::size_t>(cw.theta_S()[i]);
    cw.h[f] = cw.column[i] * cw.dof_scale[f];
  }
}

void apply_partition(const ClosedWorkspace& cw, std::span<double> v) {
  const auto g = static_cast<std::size_t>(cw.dofs());
  const std::span<const int> G = cw.theta_G();
  for (const int s : cw.theta_S()) {
    double sum = 0;
    for (std::size_t j = 0; j < g; ++j) sum += cw.H[static_cast<std::size_t>(s) * g + j] * v[static_cast<std::size_t>(G[j])];
    v[static_cast<std::size_t>(s)] = sum;
  }
}

void reduce_forces(const ClosedWorkspace& cw, std::span<const double> x, std::span<double> x_G) {
  const auto g = static_cast<std::size_t>(cw.dofs());
  for (std::size_t a = 0; a < g; ++a) x_G[a] = 0;
  for (std::size_t i = 0; i < x.size(); ++i)
    for (std::size_t a = 0; a < g; ++a) x_G[a] += cw.H[i * g + a] * x[i];
}

}  // namespace ugoki::dynamics
