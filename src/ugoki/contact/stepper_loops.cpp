// The loops of closed link systems in a step: rows without a sign, eliminated exactly before contacts are solved.

#include <algorithm>
#include <cmath>

#include "ugoki/contact/stepper.h"

namespace ugoki::contact {

void Stepper::add_loop_rows(std::size_t s, const StepSystem& system, double dt) {
  SystemScratch& x = scratch_[s];
  if (!x.loops) return;
  const std::span<const Loop> loops = mechanisms_[s]->loops();
  dynamics::update_loop_rows(*mechanisms_[s], workspaces_[s], loops, system.q, system.v, x.loops->rows);
  for (std::size_t i = 0; i < loops.size(); ++i)
    for (int k = 0; x.loops->links.is_closed(static_cast<int>(i)) && k < loops[i].rows(); ++k)
      add_loop_row(s, loops[i], static_cast<int>(i), x.loops->rows.first[i] + k, dt);
}

void Stepper::add_loop_row(std::size_t s, const Loop& loop, int index, int row, double dt) {
  const dynamics::Workspace& ws = workspaces_[s];
  const SystemScratch& x = scratch_[s];
  Block block{RowKind::loop, static_cast<int>(target_.size()), 1, static_cast<int>(segments_.size()), 0, -1, 0, 0, 0};
  double u = 0;
  const auto add = [&](int last, auto&& entry) {
    if (last < 0) return;
    const int offset = add_segment(s, last, 1);
    ++block.segments;
    const int* chain = ws.chain.data() + ws.row_start[static_cast<std::size_t>(last)];
    for (int k = 0; k <= ws.depth[static_cast<std::size_t>(last)]; ++k) {
      const double J = entry(chain[k]);
      data_[static_cast<std::size_t>(offset + k)] = J;
      u += J * x.free_v[static_cast<std::size_t>(chain[k])];
    }
  };
  if (loop.type == LoopType::gear) {
    const double slope = x.loops->rows.slope[static_cast<std::size_t>(index)];
    add(loop.freedom_a, [&](int f) { return f == loop.freedom_a ? 1.0 : 0.0; });
    add(loop.freedom_b, [&](int f) { return f == loop.freedom_b ? -slope : 0.0; });
  } else {
    const Vec6 w = x.loops->rows.W[static_cast<std::size_t>(row)];
    const auto last = [&](int link) { return link < 0 ? -1 : ws.link_chain[static_cast<std::size_t>(link)]; };
    add(last(loop.link_b), [&](int f) { return dot(w, ws.S[static_cast<std::size_t>(f)]); });
    add(last(loop.link_a), [&](int f) { return -dot(w, ws.S[static_cast<std::size_t>(f)]); });
  }
  if (block.segments == 0) return;  // between the world and what is fixed to it
  target_.push_back(u + x.loops->rows.gap[static_cast<std::size_t>(row)] / dt);
  finish_rows(block);
}

// Right-looking Cholesky over the loop rows alone. Row k of loop_L_ is what pivot k takes from all rows that are left:
//   A <- A - l l^T,   target <- target - l t
void Stepper::eliminate_loops() {
  pivots_.clear();
  loop_L_.clear();
  loop_t_.clear();
  const std::size_t rows = target_.size();
  const auto loop_rows = static_cast<std::size_t>(loop_rows_);
  if (loop_rows == 0) return;
  double greatest = 0;
  for (std::size_t r = 0; r < loop_rows; ++r) greatest = std::max(greatest, A_[r * rows + r]);
  std::vector<char>& gone = eliminated_;
  gone.assign(rows, 0);
  for (std::size_t k = 0; k < loop_rows; ++k) {
    std::size_t best = rows;
    for (std::size_t r = 0; r < loop_rows; ++r)
      if (!gone[r] && (best == rows || A_[r * rows + r] > A_[best * rows + best])) best = r;
    const double pivot = A_[best * rows + best];
    if (!(pivot > dynamics::dependent_correction * 1e-4 * greatest)) break;  // the rest follow from these
    const double inverse = 1 / std::sqrt(pivot);
    gone[best] = 1;
    pivots_.push_back(static_cast<int>(best));
    const std::size_t at = loop_L_.size();
    loop_L_.resize(at + rows);
    double* const l = loop_L_.data() + at;
    for (std::size_t r = 0; r < rows; ++r) l[r] = gone[r] ? 0 : A_[r * rows + best] * inverse;
    const double t = target_[best] * inverse;
    l[best] = 1 / inverse;
    loop_t_.push_back(t);
    for (std::size_t r = 0; r < rows; ++r) {
      if (gone[r]) continue;
      target_[r] -= l[r] * t;
      for (std::size_t c = 0; c < rows; ++c) A_[r * rows + c] -= gone[c] ? 0 : l[r] * l[c];
    }
  }
  // What the sweeps see of the loops: nothing.
  for (std::size_t r = 0; r < loop_rows; ++r)
    for (std::size_t c = 0; c < rows; ++c) A_[r * rows + c] = A_[c * rows + r] = 0;
}

void Stepper::recover_loops() {
  const std::size_t rows = target_.size();
  for (std::size_t k = pivots_.size(); k-- > 0;) {
    const double* const l = loop_L_.data() + k * rows;
    const auto pivot = static_cast<std::size_t>(pivots_[k]);
    double sum = loop_t_[k];
    for (std::size_t r = 0; r < rows; ++r) sum += r == pivot ? 0 : l[r] * p_[r];
    p_[pivot] = -sum / l[pivot];
  }
}

void Stepper::close_loops(std::size_t s, StepSystem& system, StepReport& report) {
  SystemScratch::Loops& loops = *scratch_[s].loops;
  double gap = 0;
  (void)dynamics::project_position(*mechanisms_[s], loops.ws, loops.links, system.q, system.v, gap, 4);
  report.loop_gap = std::max(report.loop_gap, gap);
}

}  // namespace ugoki::contact
