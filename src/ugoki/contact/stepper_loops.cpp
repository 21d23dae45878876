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

/// Scalar product: eight sums, added in a fixed order.
double product(std::span<const double> a, std::span<const double> b) {
  RowLanes even = {}, odd = {};
  const std::size_t n = a.size();
  std::size_t k = 0;
  for (; k + 8 <= n; k += 8) {
    even += *reinterpret_cast<const RowLanes*>(a.data() + k) * *reinterpret_cast<const RowLanes*>(b.data() + k);
    odd += *reinterpret_cast<const RowLanes*>(a.data() + k + 4) * *reinterpret_cast<const RowLanes*>(b.data() + k + 4);
  }
  even += odd;
  double sum = (even[0] + even[1]) + (even[2] + even[3]);
  for (; k < n; ++k) sum += a[k] * b[k];
  return sum;
}

}  // namespace

Stepper::SystemScratch::Loops::Loops(const Mechanism& m) : links(m), rows(m.loops()), ws(m) {
  const auto n = static_cast<std::size_t>(m.nv()), count = static_cast<std::size_t>(rows.count());
  impulse.resize(n);
  target.resize(count);
  minimum.resize(count);
  sparse.resize(4 * n);
  w.resize(n);
  parts.resize(4 * count);
}

void Stepper::SystemScratch::Loops::make_room_for_basis(std::size_t dofs) { basis.resize(static_cast<std::size_t>(rows.count()) * dofs); }

/// Calculates the whitened rows of a loop.
/// @param y      [rows of the loop][nv, out] whitened rows
/// @param terms  [rows of the loop, out] sum of the squared contributions to y; if y . y is a tiny fraction of this sum, the row is only
///               rounding
void Stepper::make_loop_rows(std::size_t s, int index, std::span<double> y, std::span<double> terms) {
  const Loop& loop = mechanisms_[s]->loops()[static_cast<std::size_t>(index)];
  const dynamics::Workspace& ws = workspaces_[s];
  SystemScratch& x = scratch_[s];
  const std::size_t n = x.v.size(), count = static_cast<std::size_t>(loop.rows());
  std::fill_n(y.begin(), count * n, 0.0);
  double* const lanes = x.loops->sparse.data();
  // Adds the lanes, as whitened rows on the chain of DOF `last`, to rows first, first + 1 ... of the loop.
  const auto add = [&](int last, std::size_t first, std::size_t rows) {
    const int* chain = ws.chain.data() + ws.row_start[static_cast<std::size_t>(last)];
    for (int k = 0; k <= ws.depth[static_cast<std::size_t>(last)]; ++k)
      for (std::size_t r = 0; r < rows; ++r) y[(first + r) * n + static_cast<std::size_t>(chain[k])] += lanes[4 * k + static_cast<int>(r)];
  };
  if (loop.type == LoopType::gear) {
    terms[0] = 0;
    const auto add_dof = [&](int dof, double value) {
      if (dof < 0) return;
      x.factor.whiten_row(dof, {&value, 1}, lanes);
      add(dof, 0, 1);
      terms[0] += x.factor.inverse_pivot(static_cast<std::size_t>(dof)) * value * value;
    };
    add_dof(loop.dof_a, 1);
    add_dof(loop.dof_b, -x.loops->rows.slope[static_cast<std::size_t>(index)]);
    return;
  }
  const Vec6* const W = x.loops->rows.W.data() + x.loops->rows.first[static_cast<std::size_t>(index)];
  double turning = 0, sliding = 0;  // sums of the squared contributions to a row of unit moment and of unit force
  const auto add_link = [&](int link, double sign) {
    const int last = link < 0 ? -1 : ws.link_chain[static_cast<std::size_t>(link)];
    if (last < 0) return;
    for (std::size_t first = 0; first < count; first += 3) {
      const std::size_t rows = std::min<std::size_t>(3, count - first);
      Vec6 wrenches[3] = {};
      for (std::size_t r = 0; r < rows; ++r) wrenches[r] = W[first + r] * sign;
      x.factor.whiten_wrenches(last, wrenches, lanes);
      add(last, first, rows);
    }
    const int* chain = ws.chain.data() + ws.row_start[static_cast<std::size_t>(last)];
    for (int k = 0; k <= ws.depth[static_cast<std::size_t>(last)]; ++k) {
      const Vec6& S = ws.S[static_cast<std::size_t>(chain[k])];
      const double inverse = x.factor.inverse_pivot(static_cast<std::size_t>(chain[k]));
      turning += inverse * dot(S.w, S.w);
      sliding += inverse * dot(S.v, S.v);
    }
  };
  add_link(loop.link_b, 1);
  add_link(loop.link_a, -1);
  for (std::size_t r = 0; r < count; ++r) terms[r] = dot(W[r].w, W[r].w) * turning + dot(W[r].v, W[r].v) * sliding;
}

/// Calculates the orthonormal basis of the loop rows (Gram-Schmidt, longest row first), and the velocities along it that close the loops.
/// Rows that no joint moves, and remainders of dependent rows, are rounding and left out. Their threshold is calculated for each loop
/// separately, because the loops of one mechanism may differ in mass by many orders of magnitude.
void Stepper::make_loop_basis(std::size_t s, const StepSystem& system, double dt) {
  SystemScratch& x = scratch_[s];
  SystemScratch::Loops& loops = *x.loops;
  const std::size_t n = x.v.size();
  const std::span<const Loop> all = mechanisms_[s]->loops();
  if (loops.basis.empty()) loops.make_room_for_basis(n);  // TreeIsland has solved the system until now
  dynamics::update_loop_rows(*mechanisms_[s], workspaces_[s], all, system.q, x.v, loops.rows);
  const auto row = [&](std::size_t k) { return std::span(loops.basis).subspan(k * n, n); };
  std::size_t count = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!loops.links.is_closed(static_cast<int>(i))) continue;
    double maximum[2] = {};  // maximum squared length of the position rows and of the rotation rows
    const auto kind = [&](int k) -> double& { return maximum[k < position_row_count(all[i].type) ? 0 : 1]; };
    make_loop_rows(s, static_cast<int>(i), std::span(loops.basis).subspan(count * n), std::span(loops.minimum).subspan(count));
    for (int k = 0; k < all[i].rows(); ++k) {
      const auto r = count + static_cast<std::size_t>(k);
      loops.minimum[r] *= dynamics::immobile_row;
      // Bounded: a mechanism whose loops are open at the start must not close them at a high speed. Positions are closed after the step.
      const double gap = loops.rows.gap[static_cast<std::size_t>(loops.rows.first[i] + k)];
      loops.target[r] = -std::clamp(gap / dt, -options_.recovery_speed, options_.recovery_speed);
      kind(k) = std::max(kind(k), product(row(r), row(r)));
    }
    for (int k = 0; k < all[i].rows(); ++k, ++count)
      loops.minimum[count] = std::max(loops.minimum[count], dynamics::dependent_correction * 1e-4 * kind(k));
  }
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
    // Repeated orthogonalisation removes the rounding of short rows. It is done for all rows: if rows that keep half of their squared
    // length are left out, a five-bar linkage gains energy at its change point (FallingRobots tests).
    for (std::size_t k = 0; k < rank; ++k) remove(rank, k);
    const double inverse = 1 / std::sqrt(product(row(rank), row(rank)));
    for (double& e : row(rank)) e *= inverse;
    loops.target[rank] *= inverse;
    for (std::size_t k = rank + 1; k < count; ++k) remove(k, rank);
  }
  loops.rank = static_cast<int>(rank);
  loops.has_basis = true;
}

/// Changes free_v so that the loops close: w' = w + Q^T (c - Q w), with w the whitened velocity of free_v. The basis Q and the velocities c
/// depend only on the positions, so that they are calculated once while the bias forces are iterated.
void Stepper::solve_loops(std::size_t s, const StepSystem& system, double dt) {
  SystemScratch& x = scratch_[s];
  SystemScratch::Loops& loops = *x.loops;
  const std::size_t n = x.v.size();
  if (!loops.has_basis) make_loop_basis(s, system, dt);
  x.factor.whiten_velocity(x.free_v, loops.w);
  std::ranges::fill(loops.impulse, 0.0);
  for (std::size_t k = 0; k < static_cast<std::size_t>(loops.rank); ++k) {
    const std::span<const double> row = std::span(loops.basis).subspan(k * n, n);
    const double part = loops.target[k] - product(row, loops.w);
    for (std::size_t e = 0; e < n; ++e) loops.impulse[e] += part * row[e];
  }
  x.factor.add_whitened(loops.impulse, x.free_v);
}

/// Writes the last segment of the solver: the whitened rows on the chain of DOF `last` in Loops::sparse become rows on all DOFs, projected
/// onto what the loops allow.
/// @return how much of the first row's mobility the loops leave: its inverse inertia with loops divided by that without, 0 to 1
double Stepper::spread_over_loops(std::size_t s, int last) {
  const dynamics::Workspace& ws = workspaces_[s];
  SystemScratch::Loops& loops = *scratch_[s].loops;
  const int n = static_cast<int>(scratch_[s].v.size()), length = ws.depth[static_cast<std::size_t>(last)] + 1;
  const int* const chain = ws.chain.data() + ws.row_start[static_cast<std::size_t>(last)];
  const double* const sparse = loops.sparse.data();
  double* const y = solver_.last_segment().data();
  std::fill_n(y, 4 * n, 0.0);
  double open = 0, closed = 0;
  for (int e = 0; e < length; ++e) {
    row_lanes(y, chain[e]) = row_lanes(sparse, e);
    open += sparse[4 * e] * sparse[4 * e];
  }
  // y (1 - Q^T Q): first the components along the basis, then their removal.
  if (solver_.blocks().back().rows == 1) {
    for (int k = 0; k < loops.rank; ++k) {
      const double* const q = loops.basis.data() + static_cast<std::ptrdiff_t>(k) * n;
      double part = 0;
      for (int e = 0; e < length; ++e) part += q[chain[e]] * sparse[4 * e];
      for (int e = 0; e < n; ++e) y[4 * e] -= part * q[e];
    }
  } else {
    double* const parts = loops.parts.data();
    for (int k = 0; k < loops.rank; ++k) {
      const double* const q = loops.basis.data() + static_cast<std::ptrdiff_t>(k) * n;
      RowLanes part = {};
      for (int e = 0; e < length; ++e) part += q[chain[e]] * row_lanes(sparse, e);
      row_lanes(parts, k) = part;
    }
    for (int e = 0; e < n; ++e) {
      RowLanes rest = row_lanes(y, e);
      const double* q = loops.basis.data() + e;
      for (int k = 0; k < loops.rank; ++k, q += n) rest -= *q * row_lanes(parts, k);
      row_lanes(y, e) = rest;
    }
  }
  for (int e = 0; e < n; ++e) closed += y[4 * e] * y[4 * e];
  return open > 0 ? std::min(closed / open, 1.0) : 1;
}

void Stepper::close_loops(std::size_t s, StepSystem& system) {
  SystemScratch::Loops& loops = *scratch_[s].loops;
  // The returned status is ignored and the gap is reported, because the status is not_closed even for gaps of 1e-12.
  (void)dynamics::close_position(*mechanisms_[s], loops.ws, loops.links, system.q, system.v, scratch_[s].loop_gap, max_closing_steps);
}

}  // namespace ugoki::contact
