// Newton's method on the whitened velocities w of an island (velocity_solver.h). For fixed p^ it solves
//   F(w) = w - sum Y^T p(u(w)) = 0,   p = the law's projection of p^ - u / R   (augmented Lagrangian, p^ = the last impulses)
// Y are the whitened rows of a block, u its velocity. R is a small fraction of the block's own inverse inertia. It only sets how fast p^
// converges; at the solution p = p^ it cancels.
// If only a subset of an island's systems is solved, the contribution of the blocks outside the subset is subtracted from w in F; their
// impulses are constant.
// H = dF/dw = 1 + sum Y^T G Y with G = -dp/du. The coupling of a sliding contact's friction to its normal impulse is left out, so that H is
// symmetric and positive definite. F is then the gradient of a convex function of w, the merit, and a line search along the Newton step
// looks for the zero of its slope.

#include <algorithm>
#include <cmath>
#include <limits>

#include "ugoki/contact/augmented_law.h"
#include "ugoki/contact/solver_kernels.h"
#include "ugoki/contact/velocity_solver.h"

namespace ugoki::contact {
namespace {
// First and minimum value of R, relative to a block's inverse inertia. Each update of p^ divides R by ten.
constexpr double first_regularization = 1e-3, min_regularization = 1e-6;
constexpr int max_updates = 8;
constexpr double slope_ratio = 0.1;  // the line search ends when the slope of the merit has fallen to this fraction
constexpr int max_trials = 8;        // of the line search
}  // namespace

/// Row of the Newton matrix for entry e of a segment. The DOFs deepest in a system's tree have the lowest rows, so that branches do not
/// fill in entries between each other.
int VelocitySolver::matrix_row(const RowSegment& x, int e) const {
  const auto s = static_cast<std::size_t>(x.system);
  return local_[s] + first_[s + 1] - first_[s] - 1 - (x.index ? x.index[e] : e);
}

/// Orders the island's systems (system_order.h) and sizes the envelope of the Newton matrix.
/// @return false if `steps` Newton steps would cost more than budget_
bool VelocitySolver::order_systems(const Island& island, int steps) {
  const auto segment = [&](const RowBlock& b, int k) -> const RowSegment& {
    return segments_[static_cast<std::size_t>(b.first_segment + k)];
  };
  systems_.clear();
  for (int i = 0; i < island.blocks; ++i)
    if (const RowBlock& b = block(island, i); b.segments == 2) systems_.add(segment(b, 0).system, segment(b, 1).system);
  int n = 0;
  for (const int system : systems_.find(
           std::span(members_).subspan(static_cast<std::size_t>(island.first_system), static_cast<std::size_t>(island.systems)))) {
    const auto s = static_cast<std::size_t>(system);
    local_[s] = n;
    n += first_[s + 1] - first_[s];
  }
  H_.begin(n);
  for (int i = 0; i < island.blocks; ++i) {
    const RowBlock& b = block(island, i);
    int low = n;
    for (int k = 0; k < b.segments; ++k)  // a chain's deepest DOF has its lowest row
      low = std::min(low, matrix_row(segment(b, k), segment(b, k).length - 1));
    for (int k = 0; k < b.segments; ++k)
      for (int e = 0; e < segment(b, k).length; ++e) H_.include(matrix_row(segment(b, k), e), low);
  }
  cost_ = H_.finish() + 300.0 * island.blocks;
  for (int i = 0; i < island.blocks; ++i) {  // H from the blocks' rows
    double length = 0;
    for (int k = 0; k < block(island, i).segments; ++k) length += segment(block(island, i), k).length;
    cost_ += 0.5 * block(island, i).rows * length * length;
  }
  if (steps * cost_ > budget_) return false;
  H_.allocate();
  F_.resize(static_cast<std::size_t>(n));
  step_.resize(F_.size());
  G_.resize(9 * static_cast<std::size_t>(island.blocks));
  x_.resize(F_.size());
  u_.resize(3 * static_cast<std::size_t>(island.blocks));
  du_.resize(u_.size());
  sort_rows(island);
  return true;
}

/// Copies the rows of each block to z_, ordered by matrix row, so that the loops over H run along consecutive entries. The entries of both
/// segments of a block on one system are added.
void VelocitySolver::sort_rows(const Island& island) {
  sorted_.clear();
  z_.clear();
  z_row_.clear();
  for (int i = 0; i < island.blocks; ++i) {
    const RowBlock& b = block(island, i);
    const RowSegment& x = segments_[static_cast<std::size_t>(b.first_segment)];
    const RowSegment& y = segments_[static_cast<std::size_t>(b.first_segment + b.segments - 1)];
    const std::size_t first = z_row_.size(), values = z_.size();
    constexpr int none = std::numeric_limits<int>::max();
    // A chain's deepest DOF is its last entry and has its lowest matrix row.
    int e = x.length - 1, f = b.segments == 2 ? y.length - 1 : -1;
    while (e >= 0 || f >= 0) {
      const int at = e >= 0 ? matrix_row(x, e) : none, other = f >= 0 ? matrix_row(y, f) : none;
      RowLanes sum = {};
      if (at <= other) sum += row_lanes(rows_.data() + x.offset, e--);
      if (other <= at) sum += row_lanes(rows_.data() + y.offset, f--);
      z_row_.push_back(std::min(at, other));
      for (int r = 0; r < b.rows; ++r) z_.push_back(sum[r]);
    }
    const std::size_t length = z_row_.size() - first;
    if (b.rows == 3) {  // from entry by entry to row by row
      swap_.assign(z_.begin() + static_cast<std::ptrdiff_t>(values), z_.end());
      for (std::size_t k = 0; k < length; ++k)
        for (std::size_t r = 0; r < 3; ++r) z_[values + r * length + k] = swap_[3 * k + r];
    }
    sorted_.push_back({static_cast<int>(first), static_cast<int>(length), static_cast<int>(values)});
  }
  z_run_.resize(z_row_.size());
  for (const SortedRows& s : sorted_)
    for (int k = s.length - 1; k >= 0; --k) {
      const auto at = static_cast<std::size_t>(s.first + k);
      z_run_[at] = k + 1 < s.length && z_row_[at + 1] == z_row_[at] + 1 ? z_run_[at + 1] : k + 1;
    }
}

/// Sets the quantities that stay fixed during minimise(): p^ and the shifts of sliding contacts (augmented_law.h).
void VelocitySolver::fix_law(const Island& island) {
  hat_ = p_;
  shift_.resize(p_.size());
  for (int i = 0; i < island.blocks; ++i)
    if (const RowBlock& b = block(island, i); b.kind == RowKind::contact)
      shift_[static_cast<std::size_t>(b.row)] = sliding_shift(b, p_.data() + b.row, u_.data() + 3 * static_cast<std::size_t>(i));
}

/// Calculates the law's impulses p and the matrices G of all blocks at the velocities u_ - length du_. @return the slope and curvature of
/// the merit along the step, without the part of |w|^2 / 2
std::pair<double, double> VelocitySolver::apply_laws(const Island& island, double length) {
  double slope = 0, curvature = 0;
  double* G = G_.data();
  const double *u = u_.data(), *du = du_.data();
  for (int i = 0; i < island.blocks; ++i, G += 9, u += 3, du += 3) {
    const RowBlock& b = block(island, i);
    double* p = p_.data() + b.row;
    const double next[3] = {u[0] - length * du[0], u[1] - length * du[1], u[2] - length * du[2]};
    double normal = 0;
    if (b.kind == RowKind::roll) {
      const RowBlock& leader = blocks_[static_cast<std::size_t>(b.contact_block)];
      normal = hat_[static_cast<std::size_t>(leader.row)] + leader.impact_impulse;
    }
    augmented_impulse(b, {regularization_, hat_.data() + b.row, shift_[static_cast<std::size_t>(b.row)], normal}, next, p, G);
    for (int r = 0; r < b.rows; ++r) {
      slope += p[r] * du[r];
      for (int c = 0; c < b.rows; ++c) curvature += du[r] * G[3 * r + c] * du[c];
    }
  }
  return {slope, curvature};
}

/// Calculates F from x_ (w without the contribution of other blocks) and the impulses p.
void VelocitySolver::calc_residual(const Island& island) {
  F_ = x_;
  for (int i = 0; i < island.blocks; ++i) {
    const RowBlock& b = block(island, i);
    const SortedRows& s = sorted_[static_cast<std::size_t>(i)];
    const double* Z = z_.data() + s.values;
    for (int r = 0; r < b.rows; ++r, Z += s.length) {
      const double p = p_[static_cast<std::size_t>(b.row + r)];
      if (p == 0) continue;
      for (int e = 0; e < s.length; ++e) F_[static_cast<std::size_t>(z_row_[static_cast<std::size_t>(s.first + e)])] -= Z[e] * p;
    }
  }
}

/// Calculates the Newton matrix H = 1 + sum Y^T G Y, with G from apply_laws().
void VelocitySolver::assemble_matrix(const Island& island) {
  H_.set_identity();
  const EnvelopeArguments H = H_.arguments();
  const double* G = G_.data();
  for (int i = 0; i < island.blocks; ++i, G += 9) {
    const int rows = block(island, i).rows;
    if (!(G[0] + (rows == 3 ? G[4] + G[8] : 0) > 0)) continue;
    const SortedRows& s = sorted_[static_cast<std::size_t>(i)];
    solver_kernels().add_to_envelope({rows, s.length, z_.data() + s.values, z_row_.data() + s.first, z_run_.data() + s.first}, G, H);
  }
}

/// Recalculates w from the impulses and marks all blocks of the island, so that the next sweep solves each of them.
void VelocitySolver::recompute_w(const Island& island) {
  const auto each_system = [&](auto&& visit) {
    for (int k = 0; k < island.systems; ++k) {
      const auto s = static_cast<std::size_t>(members_[static_cast<std::size_t>(island.first_system + k)]);
      visit(s, static_cast<std::size_t>(first_[s]), static_cast<std::size_t>(first_[s + 1]));
    }
  };
  each_system([&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t e = begin; e < end; ++e) {
      scratch_w_[e] = w_[e];
      w_[e] = base_[e];
    }
  });
  for (int i = 0; i < island.blocks; ++i) {
    RowBlock& b = block(island, i);
    apply(b, p_.data() + b.row);
    b.solved_motion = -HUGE_VAL;
  }
  each_system([&](std::size_t s, std::size_t begin, std::size_t end) {
    double square = 0;
    for (std::size_t e = begin; e < end; ++e) square += (w_[e] - scratch_w_[e]) * (w_[e] - scratch_w_[e]);
    motion_[s] += std::sqrt(square);
  });
}

/// Minimises the merit, starting from x_ and u_, with p^ and the shifts of sliding contacts fixed; sets p to the law's impulses.
/// @return number of Newton steps
int VelocitySolver::minimise(const Island& island) {
  const int limit = static_cast<int>(std::min(12.0, budget_ / cost_));
  std::ranges::fill(du_, 0.0);
  apply_laws(island, 0);
  for (int steps = 1; steps <= limit; ++steps) {
    budget_ -= cost_;
    calc_residual(island);
    assemble_matrix(island);
    H_.solve(F_, step_);
    double slope = 0, square = 0, along = 0;  // slope: minus the slope of the merit along the step
    for (std::size_t i = 0; i < F_.size(); ++i) {
      slope += F_[i] * step_[i];
      square += step_[i] * step_[i];
      along += x_[i] * step_[i];
    }
    if (!(slope > 1e-26)) return steps;
    for (int i = 0; i < island.blocks; ++i) {
      const RowBlock& b = block(island, i);
      const SortedRows& s = sorted_[static_cast<std::size_t>(i)];
      const double* Z = z_.data() + s.values;
      for (int r = 0; r < b.rows; ++r, Z += s.length) {
        double sum = 0;
        for (int e = 0; e < s.length; ++e) sum += Z[e] * step_[static_cast<std::size_t>(z_row_[static_cast<std::size_t>(s.first + e)])];
        du_[static_cast<std::size_t>(3 * i + r)] = sum;
      }
    }
    // Along w - length step the slope of the merit grows from -slope and has one zero: Newton's method, kept between `low` and `high`.
    double length = 1, low = 0, high = HUGE_VAL;
    for (int trial = 1;; ++trial) {
      const auto [laws, curvature] = apply_laws(island, length);
      const double now = length * square - along + laws;
      if (std::fabs(now) <= slope_ratio * slope || trial == max_trials) break;
      (now > 0 ? high : low) = length;
      const double next = length - now / (square + curvature);
      length = next > low && next < high ? next : high < HUGE_VAL ? 0.5 * (low + high) : 2 * length;
    }
    for (std::size_t i = 0; i < x_.size(); ++i) x_[i] -= length * step_[i];
    for (std::size_t i = 0; i < u_.size(); ++i) u_[i] -= length * du_[i];
    if (slope < 1e-20) return steps;
  }
  return limit;
}

/// Improves p and w by Newton's method. If the following sweep changes velocities by `change` or more, p and w are restored.
/// @param subset true: blocks outside `island` act on its systems
/// @param change m/s: maximum change of a velocity in the last sweep
/// @return number of Newton steps
int VelocitySolver::newton(const Island& island, bool subset, double change, double tolerance) {
  for (int k = 0; k < island.systems; ++k) {
    const auto s = static_cast<std::size_t>(members_[static_cast<std::size_t>(island.first_system + k)]);
    for (auto e = static_cast<std::size_t>(first_[s]); e < static_cast<std::size_t>(first_[s + 1]); ++e) base_[e] = subset ? w_[e] : 0;
  }
  for (int i = 0; subset && i < island.blocks; ++i) {
    const RowBlock& b = block(island, i);
    const double* p = p_.data() + b.row;
    for (int k = 0; k < b.segments; ++k) {
      const RowSegment& x = segments_[static_cast<std::size_t>(b.first_segment + k)];
      const double* y = rows_.data() + x.offset;
      for (int r = 0; r < b.rows; ++r)
        for (int e = 0; e < x.length; ++e) base_[static_cast<std::size_t>(x.first + (x.index ? x.index[e] : e))] -= y[4 * e + r] * p[r];
    }
  }
  old_p_ = p_;
  for (int k = 0; k < island.systems; ++k) {
    const auto s = static_cast<std::size_t>(members_[static_cast<std::size_t>(island.first_system + k)]);
    for (int e = first_[s]; e < first_[s + 1]; ++e)
      x_[static_cast<std::size_t>(local_[s] + first_[s + 1] - 1 - e)] =
          w_[static_cast<std::size_t>(e)] - base_[static_cast<std::size_t>(e)];
  }
  for (int i = 0; i < island.blocks; ++i) velocities(block(island, i), u_.data() + 3 * static_cast<std::size_t>(i));
  int steps = 0;
  regularization_ = first_regularization;
  for (int outer = 0; outer < max_updates && budget_ > cost_;
       ++outer, regularization_ = std::max(0.1 * regularization_, min_regularization)) {
    fix_law(island);
    steps += minimise(island);
    double moved = 0;  // m/s: velocity error that corresponds to the last change of p^
    for (int i = 0; i < island.blocks; ++i) {
      const RowBlock& b = block(island, i);
      for (int r = 0; r < b.rows; ++r) {
        const auto at = static_cast<std::size_t>(b.row + r);
        moved = std::max(moved, regularization_ * b.B[r] * std::fabs(p_[at] - hat_[at]));
      }
    }
    if (moved < 0.1 * tolerance) break;
  }
  recompute_w(island);
  if (sweep(island, true, 0) < change) return steps;
  p_ = old_p_;
  recompute_w(island);
  return steps;
}

/// Newton's method for the systems of the blocks that had not converged in the last sweep (for example a wedged body), with all other
/// systems fixed. Used if Newton's method for the complete island would cost too much. @return number of Newton steps
int VelocitySolver::newton_on_subset(const Island& island, double tolerance) {
  const auto inside = [&](const RowBlock& b, int k) -> char& {
    return in_subset_[static_cast<std::size_t>(segments_[static_cast<std::size_t>(b.first_segment + k)].system)];
  };
  double change = 0;
  for (int i = 0; i < island.blocks; ++i) {
    if (block(island, i).change < tolerance) continue;
    change = std::max(change, block(island, i).change);
    for (int k = 0; k < block(island, i).segments; ++k) inside(block(island, i), k) = 1;
  }
  Island subset{static_cast<int>(order_.size()), 0, static_cast<int>(members_.size()), 0};
  for (int i = 0; i < island.blocks; ++i) {
    const RowBlock& b = block(island, i);
    if (inside(b, 0) == 0 || inside(b, b.segments - 1) == 0) continue;
    order_.push_back(order_[static_cast<std::size_t>(island.first_block + i)]);
    ++subset.blocks;
  }
  for (int k = 0; k < island.systems; ++k) {
    const int s = members_[static_cast<std::size_t>(island.first_system + k)];
    if (in_subset_[static_cast<std::size_t>(s)] == 0) continue;
    in_subset_[static_cast<std::size_t>(s)] = 0;
    members_.push_back(s);
    ++subset.systems;
  }
  const int steps = subset.systems > 0 && order_systems(subset, 1) ? newton(subset, true, change, tolerance) : 0;
  order_.resize(static_cast<std::size_t>(subset.first_block));
  members_.resize(static_cast<std::size_t>(subset.first_system));
  return steps;
}

}  // namespace ugoki::contact
