#include "ugoki/dynamics/loop_partition.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ugoki/dynamics/dynamics.h"

namespace ugoki::dynamics {
namespace {

constexpr double least_keep_limit = 4;  // entries of J_S^-1 J_G; full pivoting leaves about 1

/// How many rows of the loop, the first ones, are distances.
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

/// Mean of the mechanism's offsets between joints: the arm over which an angle moves something.
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

/// J_S and K = -J_S^-1 J_G for the present choice.
void solve_choice(ClosedWorkspace& cw) {
  const std::size_t n = cw.freedom_order.size(), r = static_cast<std::size_t>(cw.rank), g = n - r;
  const std::span<double> J_S = cw.J_S.begin(cw.rank);
  for (std::size_t i = 0; i < r; ++i) {
    const double* row = cw.J.data() + static_cast<std::size_t>(cw.row_order[i]) * n;
    for (std::size_t j = 0; j < r; ++j) J_S[i * r + j] = row[cw.freedom_order[j]];
    for (std::size_t j = 0; j < g; ++j) cw.K[i * g + j] = -row[cw.freedom_order[r + j]];
  }
  cw.pivot_part = cw.J_S.factor();
  if (cw.pivot_part > 0) cw.J_S.solve_many(cw.K, static_cast<int>(g));
}

double greatest_entry(const ClosedWorkspace& cw) {
  double greatest = 0;
  const std::size_t count = static_cast<std::size_t>(cw.rank) * static_cast<std::size_t>(cw.freedoms());
  for (std::size_t i = 0; i < count; ++i) greatest = std::max(greatest, std::fabs(cw.K[i]));
  return greatest;
}

void choose(ClosedWorkspace& cw) {
  cw.pivots = cw.J;
  const int most = cw.full_rank >= 0 ? cw.full_rank : static_cast<int>(cw.freedom_order.size());
  cw.rank = choose_pivots(cw.pivots, cw.rank_tolerance, most, cw.row_order, cw.freedom_order);
  cw.chosen_anew = true;
  solve_choice(cw);
  cw.keep_limit = std::max(least_keep_limit, 2 * greatest_entry(cw));
}

/// True if the present choice still stands.
bool keep(ClosedWorkspace& cw) {
  if (cw.rank < 0 || cw.rank != cw.full_rank) return false;
  solve_choice(cw);
  return cw.pivot_part > cw.rank_tolerance && (cw.hold_choice || greatest_entry(cw) < cw.keep_limit);
}

/// Small pivots can come from the choice as well as from the position: in the latter case no choice is better, and the present one stays.
void choose_if_better(ClosedWorkspace& cw) {
  const double part = cw.pivot_part, limit = cw.keep_limit;
  cw.kept_freedoms = cw.freedom_order;
  cw.kept_rows = cw.row_order;
  choose(cw);
  if (cw.rank == cw.full_rank && cw.pivot_part > 4 * part) return;
  cw.freedom_order.swap(cw.kept_freedoms);
  cw.row_order.swap(cw.kept_rows);
  cw.rank = cw.full_rank;
  cw.keep_limit = limit;
  cw.chosen_anew = false;
  solve_choice(cw);
}

void fill_H(ClosedWorkspace& cw) {
  const auto r = static_cast<std::size_t>(cw.rank), g = static_cast<std::size_t>(cw.freedoms());
  const std::span<const int> S = cw.theta_S(), G = cw.theta_G();
  for (std::size_t j = 0; j < g; ++j) {
    const double unit = 1 / cw.freedom_scale[static_cast<std::size_t>(G[j])];
    for (std::size_t i = 0; i < r; ++i) {
      const auto f = static_cast<std::size_t>(S[i]);
      cw.H[f * g + j] = cw.freedom_scale[f] * cw.K[i * g + j] * unit;
    }
    for (std::size_t i = 0; i < g; ++i) cw.H[static_cast<std::size_t>(G[i]) * g + j] = i == j ? 1 : 0;
  }
}

}  // namespace

ClosedWorkspace::ClosedWorkspace(const Mechanism& m, std::span<const Loop> all_loops)
    : loops(all_loops.begin(), all_loops.end()), open(m), rows(loops) {
  const auto n = static_cast<std::size_t>(m.nv()), nq = static_cast<std::size_t>(m.nq());
  const auto most_rows = static_cast<std::size_t>(rows.count());
  length = mean_offset(m, loops);
  for (const Link& link : m.links())
    for (int k = 0; k < link.joint.nv(); ++k) freedom_scale.push_back(is_distance(link.joint, k) ? length : 1.0);
  for (const Loop& loop : loops) {
    for (int r = 0; r < loop.rows(); ++r) row_scale.push_back(r < distance_rows(loop.type) ? 1 / length : 1.0);
    if (loop.type == LoopType::gear) row_scale.back() = 1 / freedom_scale[static_cast<std::size_t>(loop.freedom_a)];
    closed.push_back(loop.closed);
  }
  active.reserve(most_rows);
  row_order.reserve(most_rows);
  kept_rows.reserve(most_rows);
  kept_freedoms.resize(n);
  J.reserve(most_rows * n);
  pivots.reserve(most_rows * n);
  freedom_order.resize(n);
  const std::size_t most_rank = std::min(most_rows, n);
  J_S.resize(static_cast<int>(most_rank));
  K.resize(n * n);
  H.resize(n * n);
  A_G.resize(n * n);
  normal.reserve(most_rows * most_rows);
  for (auto* x : {&h, &v1, &v2, &v3, &vdot1, &vdot2, &tau1, &column, &b_G, &step}) x->resize(n);
  rest_V.resize(open.V.size());
  rest_C.resize(open.C.size());
  for (auto* x : {&q1, &q2, &q3}) x->resize(nq);
  products.resize(most_rows);
  multipliers.resize(most_rows);
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
      for (std::size_t j = 0; j < n; ++j) row[j] *= scale * cw.freedom_scale[j];
    }
  }
}

void update_partition(const Mechanism& m, ClosedWorkspace& cw) {
  update_constraint_matrix(m, cw);
  cw.chosen_anew = false;
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
    cw.h[f] = cw.column[i] * cw.freedom_scale[f];
  }
}

void apply_partition(const ClosedWorkspace& cw, std::span<double> v) {
  const auto g = static_cast<std::size_t>(cw.freedoms());
  const std::span<const int> G = cw.theta_G();
  for (const int s : cw.theta_S()) {
    double sum = 0;
    for (std::size_t j = 0; j < g; ++j) sum += cw.H[static_cast<std::size_t>(s) * g + j] * v[static_cast<std::size_t>(G[j])];
    v[static_cast<std::size_t>(s)] = sum;
  }
}

void reduce_forces(const ClosedWorkspace& cw, std::span<const double> x, std::span<double> x_G) {
  const auto g = static_cast<std::size_t>(cw.freedoms());
  for (std::size_t a = 0; a < g; ++a) x_G[a] = 0;
  for (std::size_t i = 0; i < x.size(); ++i)
    for (std::size_t a = 0; a < g; ++a) x_G[a] += cw.H[i * g + a] * x[i];
}

}  // namespace ugoki::dynamics
