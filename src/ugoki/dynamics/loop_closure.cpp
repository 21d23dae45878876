#include "ugoki/dynamics/loop_closure.h"

#include <algorithm>
#include <cmath>

#include "ugoki/dynamics/dynamics.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::dynamics {
namespace {

constexpr double accepted_gap = 1e-11;  // in units of cw.length and rad: well above rounding, far below anything visible
constexpr int starts = 24;

/// Greatest distance from the reference point: what gaps are rounded to.
double extent(const ClosedWorkspace& cw) {
  double most = cw.length;
  for (const Pose& X : cw.open.X_WB) most = std::max(most, norm(X.p - cw.open.p0));
  return most;
}

double scaled_gap(const ClosedWorkspace& cw, int active_row) {
  const auto row = static_cast<std::size_t>(cw.active[static_cast<std::size_t>(active_row)]);
  return cw.row_scale[row] * cw.rows.gap[row];
}

/// Of the first `count` rows in the order of the choice: all of them, or the independent ones.
double greatest_gap(const ClosedWorkspace& cw, int count) {
  double most = 0;
  for (int i = 0; i < count; ++i) {
    const int row = cw.rank < 0 ? i : cw.row_order[static_cast<std::size_t>(i)];
    most = std::max(most, std::fabs(scaled_gap(cw, row)));
  }
  return most;
}

/// A revolute, cylindrical or planar closure whose axes point against each other has no gap and is still not what was meant.
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

/// One damped least-squares step: y = -D J^T (J D J^T + damping 1)^-1 g with D = 1 / weights, in one unit.
/// @param y [nv, out] @return false where the damping is too small for a factor
bool damped_step(ClosedWorkspace& cw, std::span<const double> weights, double damping, std::span<double> y) {
  const std::size_t n = y.size(), rows = cw.active.size();
  const auto inverse_weight = [&](std::size_t j) { return weights.empty() ? 1.0 : 1.0 / weights[j]; };
  cw.normal.resize(rows * rows);
  double greatest = 0;
  for (std::size_t a = 0; a < rows; ++a) {
    const double* row = cw.J.data() + a * n;
    for (std::size_t j = 0; j < n; ++j) y[j] = row[j] * inverse_weight(j);
    for (std::size_t b = 0; b <= a; ++b) {
      const double* other = cw.J.data() + b * n;
      double sum = 0;
      for (std::size_t j = 0; j < n; ++j) sum += y[j] * other[j];
      cw.normal[a * rows + b] = sum;
    }
    greatest = std::max(greatest, cw.normal[a * rows + a]);
    cw.multipliers[a] = scaled_gap(cw, static_cast<int>(a));
  }
  for (std::size_t a = 0; a < rows; ++a) cw.normal[a * rows + a] += damping * std::max(greatest, 1e-30);
  if (!factor_cholesky(cw.normal, static_cast<int>(rows), 0)) return false;
  solve_cholesky(cw.normal, static_cast<int>(rows), std::span(cw.multipliers).first(rows));
  for (std::size_t j = 0; j < n; ++j) {
    double sum = 0;
    for (std::size_t a = 0; a < rows; ++a) sum += cw.J[a * n + j] * cw.multipliers[a];
    y[j] = -inverse_weight(j) * sum;
  }
  return true;
}

/// y, at most `most` in any freedom, turned into the units of v.
void to_displacement(const ClosedWorkspace& cw, double most, std::span<double> y) {
  double greatest = 0;
  for (const double x : y) greatest = std::max(greatest, std::fabs(x));
  const double scale = greatest > most ? most / greatest : 1.0;
  for (std::size_t j = 0; j < y.size(); ++j) y[j] *= scale * cw.freedom_scale[j];
}

double squared_gap(const ClosedWorkspace& cw) {
  double sum = 0;
  for (std::size_t i = 0; i < cw.active.size(); ++i) sum += scaled_gap(cw, static_cast<int>(i)) * scaled_gap(cw, static_cast<int>(i));
  return sum;
}

/// Numbers in [-1, 1), the same on every machine.
class Sequence {
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
  double most = -1;
  for (std::size_t i = 0; i < cw.active.size(); ++i) {
    const double gap = std::fabs(scaled_gap(cw, static_cast<int>(i)));
    if (gap <= most) continue;
    most = gap;
    c.row = cw.active[i];
    c.gap = std::fabs(cw.rows.gap[static_cast<std::size_t>(c.row)]);
    if (!std::isfinite(gap)) break;
  }
  c.closed = most <= accepted_gap;
  return c;
}

Closure close_theta_S(const Mechanism& m, std::span<double> q, ClosedWorkspace& cw) {
  double last = 0;
  int iterations = 0;
  bool settled = false;
  if (cw.rank != cw.full_rank) cw.rank = -1;  // left from a singular position
  for (; iterations < 20; ++iterations) {
    update_gaps(m, q, cw);
    const double gap = greatest_gap(cw, cw.rank < 0 ? static_cast<int>(cw.active.size()) : cw.rank);
    settled = gap <= cw.gap_tolerance * extent(cw) / cw.length;
    if (settled || !std::isfinite(gap)) break;
    // At rounding the gap no longer shrinks
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
    for (std::size_t i = 0; i < rank; ++i) cw.step[static_cast<std::size_t>(cw.freedom_order[i])] = cw.column[i];
    to_displacement(cw, 0.5, cw.step);
    integrate(m, q, cw.step, 1.0, q);
  }
  Closure c = measure_gap(cw);
  c.iterations = iterations;
  // Redundant rows close with the others; if they do not, the rank is another one here
  const double redundant_gap = c.row < 0 ? 0.0 : c.gap * cw.row_scale[static_cast<std::size_t>(c.row)];
  c.closed = settled && (cw.is_singular() || redundant_gap <= 1e-8 + 2 * cw.contradiction);
  return c;
}

Closure close_positions(const Mechanism& m, std::span<double> q, ClosedWorkspace& cw, std::span<const double> weights) {
  update_gaps(m, q, cw);
  double cost = squared_gap(cw), damping = 1e-3;
  int iterations = 0;
  bool renewed = true;
  for (; iterations < 300 && std::isfinite(cost); ++iterations) {
    if (const Closure c = measure_gap(cw); c.row < 0 || std::sqrt(cost) <= cw.gap_tolerance) break;
    if (renewed) update_constraint_matrix(m, cw);
    if (!damped_step(cw, weights, damping, cw.step)) {
      damping *= 10;
      renewed = false;
      continue;
    }
    to_displacement(cw, 0.5, cw.step);
    integrate(m, q, cw.step, 1.0, cw.q1);
    update_gaps(m, cw.q1, cw);
    const double trial = squared_gap(cw);
    if (renewed = trial < cost * (1 - 1e-6); renewed) {
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
  Sequence sequence;
  Closure closure;
  double least = 0;
  for (int k = 0; k < starts; ++k) {
    const Closure c = close_positions(m, trial, cw, weights);
    const bool good = c.closed && !has_reversed_axis(cw);
    const double cost = squared_gap(cw) + (has_reversed_axis(cw) ? 4.0 : 0.0);
    if (k == 0 || cost < least) {
      least = cost;
      closure = c;
      closure.closed = good;
      best = trial;
    }
    if (good || cw.active.empty()) break;
    const double size = 0.2 + 0.12 * k;  // rad: ever farther from where the caller began
    for (std::size_t j = 0; j < perturbation.size(); ++j) {
      const bool held = !weights.empty() && !std::isfinite(weights[j]);
      perturbation[j] = held ? 0.0 : size * sequence.next() * cw.freedom_scale[j];
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
  // Least |W^1/2 (v' - v)| with v' = H v_G', in one unit: (H^T W H) v_G' = H^T W v. What is held weighs far more than the rest, and
  // what it still misses is made good in a second round.
  const std::size_t n = v.size(), g = static_cast<std::size_t>(cw.freedoms());
  double heaviest = 1;
  for (const double w : weights)
    if (std::isfinite(w)) heaviest = std::max(heaviest, w);
  const auto is_held = [&](std::size_t j) { return !weights.empty() && !std::isfinite(weights[j]); };
  const auto W = [&](std::size_t j) {
    const double weight = weights.empty() ? 1.0 : is_held(j) ? 1e7 * heaviest : weights[j];
    return weight / (cw.freedom_scale[j] * cw.freedom_scale[j]);
  };
  std::fill_n(cw.A_G.begin(), g * g, 0.0);
  for (std::size_t j = 0; j < n; ++j) {
    const double* H = cw.H.data() + j * g;
    for (std::size_t a = 0; a < g; ++a)
      for (std::size_t b = 0; b <= a; ++b) cw.A_G[a * g + b] += W(j) * H[a] * H[b];
  }
  if (!factor_cholesky(cw.A_G, static_cast<int>(g), 0)) return;  // H^T W H is positive: only a number that is not finite fails
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
  std::vector<double> best_place(q.begin(), q.end()), moved = best_place, direction(static_cast<std::size_t>(m.nv()));
  int best = rank_at(best_place);
  double pivot_part = cw.pivot_part;
  cw.contradiction = std::sqrt(squared_gap(cw));
  Sequence sequence;
  for (int tries = 0; tries < 8 && best < m.nv(); ++tries) {
    rank_at(best_place);
    for (const int f : cw.theta_G())
      direction[static_cast<std::size_t>(f)] = sequence.next() * cw.freedom_scale[static_cast<std::size_t>(f)];
    apply_partition(cw, direction);
    integrate(m, best_place, direction, tries % 2 == 0 ? 0.05 : 0.2, moved);
    if (!close_positions(m, moved, cw).closed) continue;
    const int rank = rank_at(moved);
    if (rank > best) {
      best = rank;
      best_place = moved;
      pivot_part = 0;
      tries = 0;
    }
    if (rank == best) pivot_part = std::max(pivot_part, cw.pivot_part);
  }
  std::ranges::copy(best_place.begin(), best_place.begin() + static_cast<std::ptrdiff_t>(general.size()), general.begin());
  cw.rank = -1;
  cw.full_pivot_part = pivot_part;
  return cw.full_rank = best;
}

}  // namespace ugoki::dynamics
