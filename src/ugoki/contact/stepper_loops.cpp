// The loops of closed link systems in a step: equality constraints, eliminated exactly before contacts are solved.
//
// Loop impulses change the whitened velocity w (velocity_solver.h) along the whitened loop rows. Let the rows of Q be an orthonormal basis
// of these rows. The loops require Q w = c, so w = Q^T c + (1 - Q^T Q) w. Every other row y acts through its projection y (1 - Q^T Q).

#include <algorithm>
#include <cmath>

#include "ugoki/contact/stepper.h"

namespace ugoki::contact {

Stepper::SystemScratch::Loops::Loops(const Mechanism& m) : links(m), rows(m.loops()), ws(m) {
  const auto n = static_cast<std::size_t>(m.nv()), count = static_cast<std::size_t>(rows.count());
  basis.resize(count * n);
  target.resize(count);
  minimum.resize(count);
  sparse.resize(3 * n);
}

/// Calculates one whitened row of a loop.
/// @param y      [nv, out] whitened row
/// @param terms  [out] sum of the squares of all contributions to y: an upper scale of y . y, used to detect rows that are only rounding
/// @return m/s | rad/s: velocity along the row without impulses
double Stepper::make_loop_row(std::size_t s, const Loop& loop, int index, int row, std::span<double> y, double& terms) {
  const dynamics::Workspace& ws = workspaces_[s];
  SystemScratch& x = scratch_[s];
  std::ranges::fill(y, 0.0);
  double u = 0;
  terms = 0;
  const auto add = [&](int last, auto&& entry, auto&& square) {
    if (last < 0) return;
    const int* chain = ws.chain.data() + ws.row_start[static_cast<std::size_t>(last)];
    const auto length = static_cast<std::size_t>(ws.depth[static_cast<std::size_t>(last)] + 1);
    const std::span<double> part(x.loops->sparse.data(), length);
    for (std::size_t k = 0; k < length; ++k) {
      const auto f = static_cast<std::size_t>(chain[k]);
      part[k] = entry(chain[k]);
      u += part[k] * x.free_v[f];
      terms += x.sqrt_D_inverse[f] * x.sqrt_D_inverse[f] * square(chain[k]);
    }
    whiten(s, last, part);
    for (std::size_t k = 0; k < length; ++k) y[static_cast<std::size_t>(chain[k])] += part[k];
  };
  if (loop.type == LoopType::gear) {
    const double slope = x.loops->rows.slope[static_cast<std::size_t>(index)];
    add(loop.dof_a, [&](int f) { return f == loop.dof_a ? 1.0 : 0.0; }, [&](int f) { return f == loop.dof_a ? 1.0 : 0.0; });
    add(loop.dof_b, [&](int f) { return f == loop.dof_b ? -slope : 0.0; }, [&](int f) { return f == loop.dof_b ? slope * slope : 0.0; });
  } else {
    const Vec6 w = x.loops->rows.W[static_cast<std::size_t>(row)];
    const auto last = [&](int link) { return link < 0 ? -1 : ws.link_chain[static_cast<std::size_t>(link)]; };
    const double turning = dot(w.w, w.w), sliding = dot(w.v, w.v);
    const auto square = [&](int f) {
      const Vec6& S = ws.S[static_cast<std::size_t>(f)];
      return turning * dot(S.w, S.w) + sliding * dot(S.v, S.v);
    };
    add(last(loop.link_b), [&](int f) { return dot(w, ws.S[static_cast<std::size_t>(f)]); }, square);
    add(last(loop.link_a), [&](int f) { return -dot(w, ws.S[static_cast<std::size_t>(f)]); }, square);
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
  std::ranges::fill(x.impulse, 0.0);
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
    for (std::size_t e = 0; e < n; ++e) x.impulse[e] += loops.target[rank] * row(rank)[e];
  }
  loops.rank = static_cast<int>(rank);
  add_impulses(s);
}

/// Writes the last segment of the solver: rows with entries on one chain become rows on all DOFs, projected onto what the loops allow.
/// @param row [rows * chain length] whitened rows on the chain of DOF `last`
void Stepper::spread_over_loops(std::size_t s, int last, int rows, const double* row) {
  const dynamics::Workspace& ws = workspaces_[s];
  const SystemScratch::Loops& loops = *scratch_[s].loops;
  const std::size_t n = scratch_[s].v.size();
  const int* chain = ws.chain.data() + ws.row_start[static_cast<std::size_t>(last)];
  const int length = ws.depth[static_cast<std::size_t>(last)] + 1;
  const std::span<double> all = solver_.last_segment();
  std::ranges::fill(all, 0.0);
  for (int r = 0; r < rows; ++r) {
    const std::span<double> y = all.subspan(static_cast<std::size_t>(r) * n, n);
    for (int e = 0; e < length; ++e) y[static_cast<std::size_t>(chain[e])] = row[r * length + e];
    for (std::size_t k = 0; k < static_cast<std::size_t>(loops.rank); ++k) {
      const double* const q = loops.basis.data() + k * n;
      double part = 0;
      for (std::size_t e = 0; e < n; ++e) part += q[e] * y[e];
      for (std::size_t e = 0; e < n; ++e) y[e] -= part * q[e];
    }
  }
}

void Stepper::close_loops(std::size_t s, StepSystem& system, StepReport& report) {
  SystemScratch::Loops& loops = *scratch_[s].loops;
  double gap = 0;
  (void)dynamics::project_position(*mechanisms_[s], loops.ws, loops.links, system.q, system.v, gap, 4);
  report.loop_gap = std::max(report.loop_gap, gap);
}

}  // namespace ugoki::contact
