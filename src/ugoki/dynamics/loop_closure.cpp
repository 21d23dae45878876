#include "ugoki/dynamics/loop_closure.h"

#include <algorithm>
#include <cmath>

#include "ugoki/dynamics/dynamics.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::dynamics {
namespace {

constexpr double accepted_gap = 1e-11;      // rad, or fraction of cw.length: well above rounding error, far below visible gaps
constexpr double max_assembly_work = 1e10;  // multiplications: limit of close_positions(), and of assemble() for further starts
constexpr int max_starts = 24;              // number of start configurations that assemble() tries, the given one included

/// Maximum distance [m] of a link's origin from the reference point; at least cw.length. Scale of the rounding errors of gaps.
double extent(const ClosedWorkspace& cw) {
  double maximum = cw.length;
  for (const Pose& X : cw.open.X_WB) maximum = std::max(maximum, norm(X.p - cw.open.p0));
  return maximum;
}

/// Gap of a closed loop's row: distances in units of cw.length, angles in rad. @param active_row index into cw.active
double scaled_gap(const ClosedWorkspace& cw, int active_row) {
  const auto row = static_cast<std::size_t>(cw.active[static_cast<std::size_t>(active_row)]);
  return cw.row_scale[row] * cw.rows.gap[row];
}

/// Maximum absolute scaled gap of the first `count` rows in the order of cw.row_order (independent rows first).
double max_gap(const ClosedWorkspace& cw, int count) {
  double maximum = 0;
  for (int i = 0; i < count; ++i) {
    const int row = cw.rank < 0 ? i : cw.row_order[static_cast<std::size_t>(i)];
    maximum = std::max(maximum, std::fabs(scaled_gap(cw, row)));
  }
  return maximum;
}

/// True if a closed revolute, cylindrical or planar loop has antiparallel axes. Its rows have no gap there, but the intended
/// configuration has parallel axes.
bool has_reversed_axis(const ClosedWorkspace& cw) {
  for (std::size_t i = 0; i < cw.loops.size(); ++i) {
    const Loop& loop = cw.loops[i];
    if (!cw.closed[i] || (loop.type != LoopType::revolute && loop.type != LoopType::cylindrical && loop.type != LoopType::planar)) continue;
    const auto axis = [&](int link, const Pose& X) {
      const Vec3 a = X.R * loop.axis;
      return link < 0 ? a : cw.open.X_WB[static_cast<std::size_t>(link)].R * a;
    };
    if (dot(axis(loop.link_a, loop.X_AJ), axis(loop.link_b, loop.X_BJ)) < 0) return true;
  }
  return false;
}

/// One damped least-squares step of damped_step() for more rows than twice the DOFs: with W = D^1/2 the step is
/// -W (W J^T J W + damping s E)^-1 W J^T g, by the identity A^T (A A^T + c E)^-1 = (A^T A + c E)^-1 A^T. The matrix has the size of the
/// DOFs.
bool damped_step_of_dofs(ClosedWorkspace& cw, std::span<const double> weights, double damping, std::span<double> y) {
  const std::size_t n = y.size(), rows = cw.active.size();
  const auto W = [&](std::size_t j) { return weights.empty() ? 1.0 : std::sqrt(1.0 / weights[j]); };
  cw.normal.assign(n * n, 0.0);
  std::ranges::fill(y, 0.0);
  double maximum = 0;
  for (std::size_t a = 0; a < rows; ++a) {
    const double* row = cw.J.data() + a * n;
    const double gap = scaled_gap(cw, static_cast<int>(a));
    double diagonal = 0;  // entry of J D J^T
    for (std::size_t i = 0; i < n; ++i) {
      const double x = W(i) * row[i];
      if (x == 0) continue;
      diagonal += x * x;
      y[i] -= x * gap;
      for (std::size_t j = 0; j <= i; ++j) cw.normal[i * n + j] += x * W(j) * row[j];
    }
    maximum = std::max(maximum, diagonal);
  }
  for (std::size_t j = 0; j < n; ++j) cw.normal[j * n + j] += damping * std::max(maximum, 1e-30);
  if (!factor_cholesky(cw.normal, static_cast<int>(n), 0)) return false;
  solve_cholesky(cw.normal, static_cast<int>(n), y);
  for (std::size_t j = 0; j < n; ++j) y[j] *= W(j);
  return true;
}

/// One damped least-squares step: y = -D J^T (J D J^T + damping s E)^-1 g. E is the identity, D = 1 / weights (diagonal), g the scaled
/// gaps, and s the maximum diagonal entry of J D J^T. All quantities are scaled to one unit.
/// @param y [nv, out] @return false if the damping is too small for a Cholesky factorisation
bool damped_step(ClosedWorkspace& cw, std::span<const double> weights, double damping, std::span<double> y) {
  const std::size_t n = y.size(), rows = cw.active.size();
  if (rows > 2 * n) return damped_step_of_dofs(cw, weights, damping, y);
  const auto inverse_weight = [&](std::size_t j) { return weights.empty() ? 1.0 : 1.0 / weights[j]; };
  cw.normal.resize(rows * rows);
  double maximum = 0;
  for (std::size_t a = 0; a < rows; ++a) {
    const double* row = cw.J.data() + a * n;
    for (std::size_t j = 0; j < n; ++j) y[j] = row[j] * inverse_weight(j);
    for (std::size_t b = 0; b <= a; ++b) {
      const double* other = cw.J.data() + b * n;
      double sum = 0;
      for (std::size_t j = 0; j < n; ++j) sum += y[j] * other[j];
      cw.normal[a * rows + b] = sum;
    }
    maximum = std::max(maximum, cw.normal[a * rows + a]);
    cw.multipliers[a] = scaled_gap(cw, static_cast<int>(a));
  }
  for (std::size_t a = 0; a < rows; ++a) cw.normal[a * rows + a] += damping * std::max(maximum, 1e-30);
  if (!factor_cholesky(cw.normal, static_cast<int>(rows), 0)) return false;
  solve_cholesky(cw.normal, static_cast<int>(rows), std::span(cw.multipliers).first(rows));
  for (std::size_t j = 0; j < n; ++j) {
    double sum = 0;
    for (std::size_t a = 0; a < rows; ++a) sum += cw.J[a * n + j] * cw.multipliers[a];
    y[j] = -inverse_weight(j) * sum;
  }
  return true;
}

/// Estimate of the multiplications of one damped_step().
double work_of_step(const ClosedWorkspace& cw, std::size_t dofs) {
  const auto rows = static_cast<double>(cw.active.size()), n = static_cast<double>(dofs);
  const double size = rows > 2 * n ? n : rows;  // of the matrix that is factored
  return rows * n * size / 2 + size * size * size / 6;
}

/// Scales y so that no entry exceeds `limit` in absolute value, then converts it to the units of v.
void to_displacement(const ClosedWorkspace& cw, double limit, std::span<double> y) {
  double largest = 0;
  for (const double x : y) largest = std::max(largest, std::fabs(x));
  const double scale = largest > limit ? limit / largest : 1.0;
  for (std::size_t j = 0; j < y.size(); ++j) y[j] *= scale * cw.dof_scale[j];
}

double squared_gap(const ClosedWorkspace& cw) {
  double sum = 0;
  for (std::size_t i = 0; i < cw.active.size(); ++i) sum += scaled_gap(cw, static_cast<int>(i)) * scaled_gap(cw, static_cast<int>(i));
  return sum;
}

/// Pseudo-random values in [-1, 1) from a linear congruential generator; the same sequence on every machine.
class PseudoRandom {
 public:
  double next() {
    state_ = state_ * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(state_ >> 11) * 0x1p-52 - 1.0;
  }

 private:
  unsigned long long state_ = 0x9e3779b97f4a7c15ULL;
};

}  // namespace

void update_gaps(const Mechanism& m, std::span<const double> q, ClosedWorkspace& cw) {
  std::ranges::fill(cw.v1, 0.0);
  update_kinematics(m, q, cw.v1, cw.open);
  update_loop_rows(m, cw.open, cw.loops, q, cw.v1, cw.rows);
}

Closure measure_gap(const ClosedWorkspace& cw) {
  Closure c{.closed = true};
  double maximum = -1;
  for (std::size_t i = 0; i < cw.active.size(); ++i) {
    const double gap = std::fabs(scaled_gap(cw, static_cast<int>(i)));
    if (gap <= maximum) continue;
    maximum = gap;
    c.row = cw.active[i];
    c.gap = std::fabs(cw.rows.gap[static_cast<std::size_t>(c.row)]);
    if (!std::isfinite(gap)) break;
  }
  c.closed = maximum <= accepted_gap;
  return c;
}

Closure close_theta_S(const Mechanism& m, std::span<double> q, ClosedWorkspace& cw) {
  double last = 0;
  int iterations = 0;
  bool settled = false;
  if (cw.rank != cw.full_rank) cw.rank = -1;  // the dependent DOFs were chosen at a singular configuration: choose again
  for (; iterations < 20; ++iterations) {
    update_gaps(m, q, cw);
    const double gap = max_gap(cw, cw.rank < 0 ? static_cast<int>(cw.active.size()) : cw.rank);
    settled = gap <= cw.gap_tolerance * extent(cw) / cw.length;
    if (settled || !std::isfinite(gap)) break;
    // The gap no longer halves per iteration: it is rounding error, or there is no convergence
    if (iterations > 1 && gap > 0.5 * last) {
      settled = gap <= accepted_gap;
      break;
    }
    last = gap;
    update_partition(m, cw);
    const auto rank = static_cast<std::size_t>(cw.rank);
    for (std::size_t i = 0; i < rank; ++i) cw.column[i] = -scaled_gap(cw, cw.row_order[i]);
    cw.J_S.solve(std::span(cw.column).first(rank));
    std::ranges::fill(cw.step, 0.0);
    for (std::size_t i = 0; i < rank; ++i) cw.step[static_cast<std::size_t>(cw.dof_order[i])] = cw.column[i];
    to_displacement(cw, 0.5, cw.step);
    integrate(m, q, cw.step, 1.0, q);
  }
  Closure c = measure_gap(cw);
  c.iterations = iterations;
  // When the independent rows close, the redundant rows must close too. Otherwise the rank here differs from cw.full_rank, and closing the
  // independent rows alone was not enough. The bound 1e-8 is far above the gap after convergence.
  const double redundant_gap = c.row < 0 ? 0.0 : c.gap * cw.row_scale[static_cast<std::size_t>(c.row)];
  c.closed = settled && (cw.is_singular() || redundant_gap <= 1e-8 + 2 * cw.contradiction);
  return c;
}

Closure close_positions(const Mechanism& m, std::span<double> q, ClosedWorkspace& cw, std::span<const double> weights) {
  update_gaps(m, q, cw);
  double cost = squared_gap(cw), damping = 1e-3;
  int iterations = 0;
  bool moved = true;
  const double affordable = max_assembly_work / work_of_step(cw, static_cast<std::size_t>(m.nv()));
  const int max_iterations = affordable < 300 ? std::max(30, static_cast<int>(affordable)) : 300;
  for (; iterations < max_iterations && std::isfinite(cost); ++iterations) {
    if (const Closure c = measure_gap(cw); c.row < 0 || std::sqrt(cost) <= cw.gap_tolerance) break;
    if (moved) update_constraint_matrix(m, cw);
    if (!damped_step(cw, weights, damping, cw.step)) {
      damping *= 10;
      moved = false;
      continue;
    }
    to_displacement(cw, 0.5, cw.step);
    integrate(m, q, cw.step, 1.0, cw.q1);
    update_gaps(m, cw.q1, cw);
    const double trial = squared_gap(cw);
    if (moved = trial < cost * (1 - 1e-6); moved) {
      std::ranges::copy(cw.q1, q.begin());
      cost = trial;
      damping = std::max(damping * 0.03, 1e-14);
    } else {
      update_gaps(m, q, cw);
      if (damping > 1e6 || cost < accepted_gap * accepted_gap * 1e-2) break;
      damping *= 10;
    }
  }
  update_gaps(m, q, cw);
  Closure c = measure_gap(cw);
  c.iterations = iterations;
  return c;
}

Closure assemble(const Mechanism& m, std::span<double> q, ClosedWorkspace& cw, std::span<const double> weights) {
  const std::vector<double> start(q.begin(), q.end());
  std::vector<double> trial = start, best = start, perturbation(static_cast<std::size_t>(m.nv()));
  PseudoRandom random;
  Closure closure;
  double minimum = 0, work = 0;
  for (int k = 0; k < max_starts && work <= max_assembly_work; ++k) {
    const Closure c = close_positions(m, trial, cw, weights);
    work += c.iterations * work_of_step(cw, static_cast<std::size_t>(m.nv()));
    const bool good = c.closed && !has_reversed_axis(cw);
    const double cost = squared_gap(cw) + (has_reversed_axis(cw) ? 4.0 : 0.0);
    if (k == 0 || cost < minimum) {
      minimum = cost;
      closure = c;
      closure.closed = good;
      best = trial;
    }
    if (good || cw.active.empty()) break;
    const double size = 0.2 + 0.12 * k;  // rad: the perturbation of the given start grows with each attempt
    for (std::size_t j = 0; j < perturbation.size(); ++j) {
      const bool held = !weights.empty() && !std::isfinite(weights[j]);
      perturbation[j] = held ? 0.0 : size * random.next() * cw.dof_scale[j];
    }
    integrate(m, start, perturbation, 1.0, trial);
  }
  std::ranges::copy(best, q.begin());
  update_gaps(m, q, cw);
  return closure;
}

void close_velocities(const Mechanism& m, std::span<const double> q, std::span<double> v, ClosedWorkspace& cw,
                      std::span<const double> weights) {
  update_gaps(m, q, cw);
  update_partition(m, cw);
  // Minimise |W^1/2 (v' - v)| over v' = H v_G', scaled to one unit: (H^T W H) v_G' = H^T W v. W are the weights. DOFs of infinite weight
  // get 1e7 times the maximum finite weight; two further rounds remove their remaining error.
  const std::size_t n = v.size(), g = static_cast<std::size_t>(cw.dofs());
  double heaviest = 1;
  for (const double w : weights)
    if (std::isfinite(w)) heaviest = std::max(heaviest, w);
  const auto is_held = [&](std::size_t j) { return !weights.empty() && !std::isfinite(weights[j]); };
  const auto W = [&](std::size_t j) {
    const double weight = weights.empty() ? 1.0 : is_held(j) ? 1e7 * heaviest : weights[j];
    return weight / (cw.dof_scale[j] * cw.dof_scale[j]);
  };
  std::fill_n(cw.A_G.begin(), g * g, 0.0);
  for (std::size_t j = 0; j < n; ++j) {
    const double* H = cw.H.data() + j * g;
    for (std::size_t a = 0; a < g; ++a)
      for (std::size_t b = 0; b <= a; ++b) cw.A_G[a * g + b] += W(j) * H[a] * H[b];
  }
  if (!factor_cholesky(cw.A_G, static_cast<int>(g), 0)) return;  // H^T W H is positive definite: fails only if a value is not finite
  const std::span<const int> G = cw.theta_G();
  std::ranges::copy(v, cw.v3.begin());
  std::ranges::fill(v, 0.0);
  for (int round = 0; round < 3; ++round) {
    std::fill_n(cw.b_G.begin(), g, 0.0);
    for (std::size_t j = 0; j < n; ++j) {
      if (round > 0 && !is_held(j)) continue;
      const double missing = W(j) * (cw.v3[j] - v[j]);
      for (std::size_t a = 0; a < g; ++a) cw.b_G[a] += cw.H[j * g + a] * missing;
    }
    solve_cholesky(cw.A_G, static_cast<int>(g), std::span(cw.b_G).first(g));
    for (std::size_t a = 0; a < g; ++a) v[static_cast<std::size_t>(G[a])] += cw.b_G[a];
    apply_partition(cw, v);
  }
}

int find_full_rank(const Mechanism& m, std::span<const double> q, ClosedWorkspace& cw, std::span<double> general) {
  const auto rank_at = [&](std::span<const double> at) {
    update_gaps(m, at, cw);
    cw.full_rank = cw.rank = -1;
    update_partition(m, cw);
    return cw.rank;
  };
  std::vector<double> best_q(q.begin(), q.end()), moved = best_q, direction(static_cast<std::size_t>(m.nv()));
  int best = rank_at(best_q);
  double pivot_ratio = cw.pivot_ratio;
  cw.contradiction = std::sqrt(squared_gap(cw));
  PseudoRandom random;
  for (int tries = 0; tries < 8 && best < m.nv(); ++tries) {
    rank_at(best_q);
    for (const int f : cw.theta_G()) direction[static_cast<std::size_t>(f)] = random.next() * cw.dof_scale[static_cast<std::size_t>(f)];
    apply_partition(cw, direction);
    integrate(m, best_q, direction, tries % 2 == 0 ? 0.05 : 0.2, moved);
    if (!close_positions(m, moved, cw).closed) continue;
    const int rank = rank_at(moved);
    if (rank > best) {
      best = rank;
      best_q = moved;
      pivot_ratio = 0;
      tries = 0;
    }
    if (rank == best) pivot_ratio = std::max(pivot_ratio, cw.pivot_ratio);
  }
  std::ranges::copy(best_q.begin(), best_q.begin() + static_cast<std::ptrdiff_t>(general.size()), general.begin());
  cw.rank = -1;
  cw.full_pivot_ratio = pivot_ratio;
  return cw.full_rank = best;
}

}  // namespace ugoki::dynamics
