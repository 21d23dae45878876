// The loops of closed link systems in a step: equality constraints, eliminated exactly before contacts are solved.
//
// Loop impulses change the whitened velocity w (velocity_solver.h) along the whitened loop rows. Let the rows of Q be an orthonormal basis
// of these rows. The loops require Q w = c, so w = Q^T c + (1 - Q^T Q) w. Every other row y acts through its projection y (1 - Q^T Q).

#include <algorithm>
#include <cmath>

#include "ugoki/contact/stepper.h"

namespace ugoki::contact {
namespace {
// Newton steps that close the loops after a step; 4 left gaps of 1e-7 m where an impact turned a ring by a tenth of a radian in a step.
constexpr int max_closing_steps = 8;
}  // namespace

Stepper::SystemScratch::Loops::Loops(const Mechanism& m) : links(m), rows(m.loops()), ws(m) {
  const auto n = static_cast<std::size_t>(m.nv()), count = static_cast<std::size_t>(rows.count());
  impulse.resize(n);
  basis.resize(count * n);
  target.resize(count);
  minimum.resize(count);
  sparse.resize(4 * n);
}

/// Calculates one whitened row of a loop.
/// @param y      [nv, out] whitened row
/// @param terms  [out] sum of the squared contributions to y; if y . y is a tiny fraction of this sum, the row is only rounding
/// @return m/s | rad/s: velocity along the row without impulses
double Stepper::make_loop_row(std::size_t s, const Loop& loop, int index, int row, std::span<double> y, double& terms) {
  const dynamics::Workspace& ws = workspaces_[s];
  SystemScratch& x = scratch_[s];
  std::ranges::fill(y, 0.0);
  double u = 0;
  terms = 0;
  double* const rows = x.loops->sparse.data();
  // Adds lane `lane` of the whitened rows in `rows`, and the velocity and upper bound of the part of J on the chain of DOF `last`.
  const auto add = [&](int last, auto&& entry, auto&& square) {
    const int* chain = ws.chain.data() + ws.row_start[static_cast<std::size_t>(last)];
    for (int k = 0; k <= ws.depth[static_cast<std::size_t>(last)]; ++k) {
      const auto f = static_cast<std::size_t>(chain[k]);
      y[f] += rows[4 * k];
      u += entry(chain[k]) * x.free_v[f];
      terms += x.factor.inverse_pivot(f) * square(chain[k]);
    }
  };
  if (loop.type == LoopType::gear) {
    const double slope = x.loops->rows.slope[static_cast<std::size_t>(index)];
    const auto add_dof = [&](int dof, double value) {
      if (dof < 0) return;
      x.factor.whiten_row(dof, {&value, 1}, rows);
      add(dof, [&](int f) { return f == dof ? value : 0.0; }, [&](int f) { return f == dof ? value * value : 0.0; });
    };
    add_dof(loop.dof_a, 1);
    add_dof(loop.dof_b, -slope);
  } else {
    const Vec6 w = x.loops->rows.W[static_cast<std::size_t>(row)];
    const double turning = dot(w.w, w.w), sliding = dot(w.v, w.v);
    const auto add_link = [&](int link, double sign) {
      const int last = link < 0 ? -1 : ws.link_chain[static_cast<std::size_t>(link)];
      if (last < 0) return;
      const Vec6 wrenches[3] = {w * sign, {}, {}};
      x.factor.whiten_wrenches(last, wrenches, rows);
      add(
          last, [&](int f) { return sign * dot(w, ws.S[static_cast<std::size_t>(f)]); },
          [&](int f) {
            const Vec6& S = ws.S[static_cast<std::size_t>(f)];
            return turning * dot(S.w, S.w) + sliding * dot(S.v, S.v);
          });
    };
    add_link(loop.link_b, 1);
    add_link(loop.link_a, -1);
  }
  return u;
}

/// Calculates the orthonormal basis of the loop rows (Gram-Schmidt, longest row first) and changes free_v so that the loops close.
/// Rows that no joint moves, and remainders of dependent rows, are rounding and left out. Their threshold is calculated for each loop
/// separately, because the loops of one mechanism may differ in mass by many orders of magnitude.
void Stepper::solve_loops(std::size_t s, const StepSystem& system, double dt) {
  SystemScratch& x = scratch_[s];
  SystemScratch::Loops& loops = *x.loops;
  const std::size_t n = x.v.size();
  const std::span<const Loop> all = mechanisms_[s]->loops();
  dynamics::update_loop_rows(*mechanisms_[s], workspaces_[s], all, system.q, x.v, loops.rows);
  const auto row = [&](std::size_t k) { return std::span(loops.basis).subspan(k * n, n); };
  const auto product = [&](std::span<const double> a, std::span<const double> b) {
    double sum = 0;
    for (std::size_t k = 0; k < n; ++k) sum += a[k] * b[k];
    return sum;
  };
  std::size_t count = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!loops.links.is_closed(static_cast<int>(i))) continue;
    double maximum[2] = {};  // maximum squared length of the position rows and of the rotation rows
    const auto kind = [&](int k) -> double& { return maximum[k < position_row_count(all[i].type) ? 0 : 1]; };
    for (int k = 0; k < all[i].rows(); ++k) {
      const auto r = count + static_cast<std::size_t>(k);
      const int at = loops.rows.first[i] + k;
      const double u = make_loop_row(s, all[i], static_cast<int>(i), at, row(r), loops.minimum[r]);
      loops.minimum[r] *= dynamics::immobile_row;
      // Bounded: a mechanism whose loops are open at the start must not close them at a high speed. Positions are closed after the step.
      const double closing =
          std::clamp(loops.rows.gap[static_cast<std::size_t>(at)] / dt, -options_.recovery_speed, options_.recovery_speed);
      loops.target[r] = -(u + closing);
      kind(k) = std::max(kind(k), product(row(r), row(r)));
    }
    for (int k = 0; k < all[i].rows(); ++k, ++count)
      loops.minimum[count] = std::max(loops.minimum[count], dynamics::dependent_correction * 1e-4 * kind(k));
  }
  std::vector<double>& impulse = loops.impulse;
  std::ranges::fill(impulse, 0.0);
  std::size_t rank = 0;
  for (; rank < count; ++rank) {
    std::size_t best = rank;
    double maximum = 0;
    for (std::size_t k = rank; k < count; ++k)
      if (const double square = product(row(k), row(k)); square > maximum && square > loops.minimum[k]) {
        maximum = square;
        best = k;
      }
    if (!(maximum > 0)) break;  // all remaining rows depend on those in the basis
    std::ranges::swap_ranges(row(rank), row(best));
    std::swap(loops.target[rank], loops.target[best]);
    std::swap(loops.minimum[rank], loops.minimum[best]);
    const auto remove = [&](std::size_t from, std::size_t k) {
      const double part = product(row(k), row(from));
      for (std::size_t e = 0; e < n; ++e) row(from)[e] -= part * row(k)[e];
      loops.target[from] -= part * loops.target[k];
    };
    for (std::size_t k = 0; k < rank; ++k) remove(rank, k);  // repeated orthogonalisation removes the rounding of short rows
    const double inverse = 1 / std::sqrt(product(row(rank), row(rank)));
    for (double& e : row(rank)) e *= inverse;
    loops.target[rank] *= inverse;
    for (std::size_t k = rank + 1; k < count; ++k) remove(k, rank);
    for (std::size_t e = 0; e < n; ++e) impulse[e] += loops.target[rank] * row(rank)[e];
  }
  loops.rank = static_cast<int>(rank);
  x.factor.add_whitened(impulse, x.free_v);
}

/// Writes the last segment of the solver: the whitened rows on the chain of DOF `last` in Loops::sparse become rows on all DOFs, projected
/// onto what the loops allow.
/// @return how much of the first row's mobility the loops leave: its inverse inertia with loops divided by that without, 0 to 1
double Stepper::spread_over_loops(std::size_t s, int last) {
  const dynamics::Workspace& ws = workspaces_[s];
  const SystemScratch::Loops& loops = *scratch_[s].loops;
  const int n = static_cast<int>(scratch_[s].v.size());
  const int* chain = ws.chain.data() + ws.row_start[static_cast<std::size_t>(last)];
  double* const y = solver_.last_segment().data();
  std::fill_n(y, 4 * n, 0.0);
  double open = 0, closed = 0;
  for (int e = 0; e <= ws.depth[static_cast<std::size_t>(last)]; ++e) {
    row_lanes(y, chain[e]) = row_lanes(loops.sparse.data(), e);
    open += y[4 * chain[e]] * y[4 * chain[e]];
  }
  for (int k = 0; k < loops.rank; ++k) {
    const double* const q = loops.basis.data() + static_cast<std::ptrdiff_t>(k) * n;
    RowLanes part = {};
    for (int e = 0; e < n; ++e) part += q[e] * row_lanes(y, e);
    for (int e = 0; e < n; ++e) row_lanes(y, e) -= part * q[e];
  }
  for (int e = 0; e < n; ++e) closed += y[4 * e] * y[4 * e];
  return open > 0 ? std::min(closed / open, 1.0) : 1;
}

void Stepper::close_loops(std::size_t s, StepSystem& system) {
  SystemScratch::Loops& loops = *scratch_[s].loops;
  // The returned status is ignored and the gap is reported, because the status is not_closed even for gaps of 1e-12.
  (void)dynamics::project_position(*mechanisms_[s], loops.ws, loops.links, system.q, system.v, scratch_[s].loop_gap, max_closing_steps);
}

}  // namespace ugoki::contact
