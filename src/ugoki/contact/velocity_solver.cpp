#include "ugoki/contact/velocity_solver.h"

#include <algorithm>
#include <cmath>

#include "ugoki/contact/solver_kernels.h"

namespace ugoki::contact {
void VelocitySolver::set_systems(std::span<const int> first) {
  first_.assign(first.begin(), first.end());
  const std::size_t systems = first.size() - 1;
  w_.assign(static_cast<std::size_t>(first.back()), 0.0);
  motion_.assign(systems, 0.0);
  base_.assign(w_.size(), 0.0);
  scratch_w_.assign(w_.size(), 0.0);
  in_subset_.assign(systems, 0);
  solved_.assign(systems, 0);
  failed_.assign(systems, 0);
  for (std::vector<int>* v : {&root_, &island_, &members_, &cursor_, &local_}) v->resize(systems + 1);
  // Reserve memory for a usual scene: a dozen contacts for each system.
  const std::size_t n = w_.size(), blocks = 64 + 12 * systems + 2 * n;
  blocks_.reserve(blocks);
  segments_.reserve(2 * blocks);
  rows_.reserve(4 * 6 * 2 * blocks);
  order_.reserve(2 * blocks);
  members_.reserve(2 * systems + 1);
  islands_.reserve(systems);
  systems_.reserve(systems + 1, blocks);
  for (std::vector<double>* v : {&target_, &p_, &old_p_, &hat_, &shift_}) v->reserve(3 * blocks);
  for (std::vector<double>* v : {&F_, &step_, &x_}) v->reserve(n);
  H_.reserve(n, std::min<std::size_t>(n * n, 1 << 15));
}

void VelocitySolver::clear() {
  blocks_.clear();
  segments_.clear();
  rows_.clear();
  target_.clear();
  p_.clear();
  std::ranges::fill(w_, 0.0);
}

RowBlock& VelocitySolver::begin_block(RowKind kind, std::uint64_t key) {
  RowBlock& b = blocks_.emplace_back();
  b = {};
  b.kind = kind;
  b.rows = kind == RowKind::limit || kind == RowKind::friction ? 1 : 3;
  b.row = static_cast<int>(target_.size());
  b.first_segment = static_cast<int>(segments_.size());
  b.contact = -1;
  b.lever = 1;
  b.key = key;
  return b;
}

std::span<double> VelocitySolver::add_segment(int system, const int* index, int length) {
  RowBlock& b = blocks_.back();
  const std::size_t offset = rows_.size(), count = 4 * static_cast<std::size_t>(length);
  segments_.push_back({system, first_[static_cast<std::size_t>(system)], index, length, static_cast<int>(offset)});
  rows_.resize(offset + count);
  ++b.segments;
  return std::span(rows_).subspan(offset, count);
}

void VelocitySolver::end_block(std::span<const double> target, std::span<const double> warm) {
  RowBlock& b = blocks_.back();
  for (std::size_t r = 0; r < static_cast<std::size_t>(b.rows); ++r) {
    target_.push_back(target[r]);
    p_.push_back(warm.empty() ? 0 : warm[r]);
  }
  // The lower triangle of Y Y^T in lanes: products with rows 0, 1 and 2.
  RowLanes sums[3] = {};
  const auto add = [&](const double* x, const double* y, int length) {
    if (b.rows == 1) {
      for (int e = 0; e < length; ++e) sums[0] += x[4 * e] * row_lanes(y, e);
      return;
    }
    for (int e = 0; e < length; ++e) {
      const RowLanes lanes = row_lanes(y, e);
      for (int r = 0; r < 3; ++r) sums[r] += x[4 * e + r] * lanes;
    }
  };
  const auto values = [&](const RowSegment& x) { return rows_.data() + x.offset; };
  for (int s = 0; s < b.segments; ++s) {
    const RowSegment& x = segments_[static_cast<std::size_t>(b.first_segment + s)];
    add(values(x), values(x), x.length);
  }
  if (b.segments == 2) {  // Both sides are on one system: add the products of the two rows on the DOFs that both chains contain.
    const RowSegment& one = segments_[static_cast<std::size_t>(b.first_segment)];
    const RowSegment& two = segments_[static_cast<std::size_t>(b.first_segment + 1)];
    if (one.system == two.system) {
      const auto dof = [](const RowSegment& x, int e) { return x.index ? x.index[e] : e; };
      int common = std::min(one.length, two.length);
      while (common > 0 && dof(one, common - 1) != dof(two, common - 1)) --common;
      add(values(one), values(two), common);
      add(values(two), values(one), common);
    }
  }
  b.B[0] = sums[0][0];
  if (b.rows < 3) return;
  b.B[1] = sums[1][1];
  b.B[2] = sums[2][2];
  b.B[3] = sums[0][1];
  b.B[4] = sums[0][2];
  b.B[5] = sums[1][2];
}

void VelocitySolver::drop_block() {
  const RowBlock& b = blocks_.back();
  if (b.segments > 0) rows_.resize(static_cast<std::size_t>(segments_[static_cast<std::size_t>(b.first_segment)].offset));
  segments_.resize(static_cast<std::size_t>(b.first_segment));
  blocks_.pop_back();
}

void VelocitySolver::velocities(const RowBlock& b, double* u) const {
  RowLanes sum = {};
  for (int s = 0; s < b.segments; ++s) {
    const RowSegment& segment = segments_[static_cast<std::size_t>(b.first_segment + s)];
    const double* y = rows_.data() + segment.offset;
    const double* w = w_.data() + segment.first;
    if (segment.index)
      for (int e = 0; e < segment.length; ++e) sum += row_lanes(y, e) * w[segment.index[e]];
    else
      for (int e = 0; e < segment.length; ++e) sum += row_lanes(y, e) * w[e];
  }
  for (int r = 0; r < b.rows; ++r) u[r] = target_[static_cast<std::size_t>(b.row + r)] + sum[r];
}

void VelocitySolver::apply(const RowBlock& b, const double* p) {
  for (int s = 0; s < b.segments; ++s) {
    const RowSegment& segment = segments_[static_cast<std::size_t>(b.first_segment + s)];
    const double* y = rows_.data() + segment.offset;
    double* w = w_.data() + segment.first;
    for (int e = 0; e < segment.length; ++e, y += 4) {
      double& entry = w[segment.index ? segment.index[e] : e];
      entry += b.rows == 3 ? y[0] * p[0] + y[1] * p[1] + y[2] * p[2] : y[0] * p[0];
    }
  }
}

/// Solves every block whose velocity may have changed by more than `minimum` [m/s] since the block was last solved.
/// @return m/s: maximum change of a velocity
double VelocitySolver::sweep(const Island& island, bool forward, double minimum) {
  return solver_kernels().sweep({blocks_.data(), order_.data() + island.first_block, island.blocks, segments_.data(), rows_.data(),
                                 target_.data(), p_.data(), w_.data(), motion_.data()},
                                forward, minimum);
}

void VelocitySolver::find_islands() {
  const std::size_t systems = first_.size() - 1;
  for (std::size_t s = 0; s < systems; ++s) root_[s] = static_cast<int>(s);
  const auto find = [&](int s) {
    while (root_[static_cast<std::size_t>(s)] != s) {
      int& up = root_[static_cast<std::size_t>(s)];
      up = root_[static_cast<std::size_t>(up)];
      s = up;
    }
    return s;
  };
  for (const RowBlock& b : blocks_) {
    if (b.segments < 2) continue;
    const int x = find(segments_[static_cast<std::size_t>(b.first_segment)].system);
    const int y = find(segments_[static_cast<std::size_t>(b.first_segment + 1)].system);
    if (x != y) root_[static_cast<std::size_t>(std::max(x, y))] = std::min(x, y);
  }
  // The lowest system index is the root, so that islands are ordered by their first system.
  islands_.clear();
  for (std::size_t s = 0; s < systems; ++s) {
    const int root = find(static_cast<int>(s));
    if (root == static_cast<int>(s)) {
      island_[s] = static_cast<int>(islands_.size());
      islands_.push_back({0, 0, 0, 0});
    } else {
      island_[s] = island_[static_cast<std::size_t>(root)];
    }
    ++islands_[static_cast<std::size_t>(island_[s])].systems;
  }
  const auto island_of = [&](const RowBlock& b) {
    return static_cast<std::size_t>(island_[static_cast<std::size_t>(segments_[static_cast<std::size_t>(b.first_segment)].system)]);
  };
  for (const RowBlock& b : blocks_) ++islands_[island_of(b)].blocks;
  int block = 0, member = 0;
  for (Island& i : islands_) {
    i.first_block = block;
    i.first_system = member;
    block += i.blocks;
    member += i.systems;
    i.blocks = i.systems = 0;
  }
  order_.resize(blocks_.size());
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    Island& i = islands_[island_of(blocks_[b])];
    order_[static_cast<std::size_t>(i.first_block + i.blocks++)] = static_cast<int>(b);
  }
  for (std::size_t s = 0; s < systems; ++s) {
    Island& i = islands_[static_cast<std::size_t>(island_[s])];
    members_[static_cast<std::size_t>(i.first_system + i.systems++)] = static_cast<int>(s);
  }
}

/// Solves an island of few rows by its dense matrix. @return whether the solution converged; if not, p and w are the best ones found
bool VelocitySolver::solve_densely(const Island& island, const SolverOptions& options, double tolerance, SolverReport& report) {
  const std::span<const int> order =
      std::span(order_).subspan(static_cast<std::size_t>(island.first_block), static_cast<std::size_t>(island.blocks));
  int rows = 0;
  for (const int i : order) rows += blocks_[static_cast<std::size_t>(i)].rows;
  if (rows > std::min(options.max_dense_rows, DenseIsland::max_rows)) return false;
  const DenseResult result = dense_.solve({blocks_, order, segments_, rows_.data(), target_.data(), p_.data()}, tolerance);
  for (int k = 0; k < island.systems; ++k) {
    const auto s = static_cast<std::size_t>(members_[static_cast<std::size_t>(island.first_system + k)]);
    std::fill(w_.begin() + first_[s], w_.begin() + first_[s + 1], 0.0);
  }
  for (const int i : order) {
    const RowBlock& b = blocks_[static_cast<std::size_t>(i)];
    apply(b, p_.data() + b.row);
  }
  report.sweeps = std::max(report.sweeps, result.sweeps);
  report.newton_steps += result.newton_steps;
  if (result.converged)
    report.residual = std::max(report.residual, result.change);
  else
    ++report.handed_over;
  return result.converged;
}

/// @return true if the last sweep changed every velocity by less than the tolerance, or by less than DenseIsland::accepted_residual
bool VelocitySolver::solve_island(const Island& island, const SolverOptions& options, SolverReport& report) {
  constexpr int round = 12;       // sweeps between two checks of the convergence rate
  constexpr int short_round = 4;  // the same before the semi-smooth Newton method is tried, which usually takes one to five steps
  constexpr int first_check = 2;  // sweeps before the first check
  constexpr int patience = 8;     // sweeps that cost about as much as Newton's method
  // Newton's methods are tried for islands of several systems if this number of symmetric steps is affordable. Where it is not, they
  // reached the tolerance for 1 % of the islands of falling heaps of 200 bodies, and took two thirds of the time of these islands. One
  // system, for example a long chain at rest, needs a step or two (TreeIsland tests).
  constexpr int affordable_steps = 16;
  constexpr int crowd = 256;  // number of blocks of an island above which the coarse tolerance and half the sweeps are used
  budget_ = island_budget_;
  const bool crowded = island.blocks > crowd;
  const int maximum = crowded ? options.iterations / 2 : options.iterations;
  double tolerance = crowded ? std::max(options.coarse, options.tolerance) : options.tolerance;
  if (!crowded && solve_densely(island, options, tolerance, report)) return true;
  bool newton_helps = true, semi_smooth_helps = true;
  double change = 0, before = HUGE_VAL;
  for (int sweeps = 1;; ++sweeps) {
    change = sweep(island, (sweeps & 1) != 0, crowded ? 0.01 * tolerance : 0);
    report.sweeps = std::max(report.sweeps, sweeps);
    if (change < tolerance || sweeps >= maximum) break;
    const int interval = semi_smooth_helps && !crowded ? short_round : round;
    if (sweeps != first_check && sweeps % interval != 0) {
      if (sweeps == 1) before = change;
      continue;
    }
    // Predict from the present rate whether a few more sweeps suffice: `patience` sweeps at the first check, then one round.
    const double rate = change / before;
    double then = change;
    for (int k = sweeps == first_check ? patience : 1; k > 0 && then >= tolerance; --k) then *= rate;
    before = change;
    if (then < tolerance || (crowded && sweeps <= round)) continue;
    const bool many_steps = crowded || (semi_smooth_helps && island.systems > 1);
    newton_helps = newton_helps && order_systems(island, many_steps ? affordable_steps : 1);
    if (semi_smooth_helps) {  // it is tried at most once; at the next check, the augmented Lagrangian is used instead
      semi_smooth_helps = false;
      const bool affordable = newton_helps && budget_ > affordable_steps * cost_;
      if (affordable) report.newton_steps += semi_smooth_newton(island, change, tolerance);
      if (affordable || (sweeps % round != 0 && (many_steps || sweeps != first_check))) continue;
    }
    if (newton_helps) {
      report.newton_steps += newton(island, false, change, tolerance);
    } else {
      tolerance = std::max(tolerance, 0.2 * options.coarse);
      report.newton_steps += newton_on_subset(island, tolerance);
    }
  }
  report.residual = std::max(report.residual, change);
  return change < std::max(tolerance, DenseIsland::accepted_residual);
}

void VelocitySolver::begin_blocks(const SolverOptions& options, std::size_t first) {
  constexpr double max_operations = 1e6;  // floating-point operations: bounds the cost of Newton's method for one island in one call
  island_budget_ = std::min(max_operations, newton_left_);
  std::ranges::fill(motion_, 0.0);
  std::ranges::fill(solved_, char{0});
  for (RowBlock& b : blocks_) b.solved_motion = -HUGE_VAL;
  for (RowBlock& b : std::span(blocks_).subspan(first)) {
    finish_block(b, options.softness);
    apply(b, p_.data() + b.row);
  }
  find_islands();
}

SolverReport VelocitySolver::solve(const SolverOptions& options) {
  std::ranges::fill(failed_, char{0});
  return solve_again(options, 0);
}

SolverReport VelocitySolver::solve_again(const SolverOptions& options, std::size_t first_new) {
  SolverReport report;
  begin_blocks(options, first_new);
  const bool threads = executor_ != nullptr && w_.size() >= min_parallel_dofs;
  to_solve_.clear();
  for (const Island& island : islands_) {
    // The blocks of an island are in ascending order, so that its last block is new if any of its blocks is.
    if (island.blocks == 0 ||
        static_cast<std::size_t>(order_[static_cast<std::size_t>(island.first_block + island.blocks - 1)]) < first_new)
      continue;
    const std::span<const int> members =
        std::span(members_).subspan(static_cast<std::size_t>(island.first_system), static_cast<std::size_t>(island.systems));
    for (const int s : members) {
      solved_[static_cast<std::size_t>(s)] = 1;
      failed_[static_cast<std::size_t>(s)] = 0;
    }
    ++report.islands;
    if (threads) {
      to_solve_.push_back(static_cast<int>(&island - islands_.data()));
      continue;
    }
    if (!solve_island(island, options, report)) failed_[static_cast<std::size_t>(members.front())] = 1;
    newton_left_ -= island_budget_ - budget_;
  }
  if (threads) solve_on_threads(options, report);
  report.not_converged = static_cast<int>(std::ranges::count(failed_, char{1}));
  return report;
}

}  // namespace ugoki::contact
