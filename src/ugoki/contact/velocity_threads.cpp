// Islands on several threads: each worker copies an island into a solver of its own, solves it, and copies the impulses back.

#include <algorithm>

#include "ugoki/contact/velocity_solver.h"

namespace ugoki::contact {

/// The solver of one worker thread, which solves copies of islands, and the combined reports of these islands.
struct VelocitySolver::Worker {
  VelocitySolver solver;
  SolverReport report;
};

VelocitySolver::VelocitySolver() = default;
VelocitySolver::VelocitySolver(VelocitySolver&&) noexcept = default;
VelocitySolver& VelocitySolver::operator=(VelocitySolver&&) noexcept = default;
VelocitySolver::~VelocitySolver() = default;

void VelocitySolver::set_executor(Executor* executor) {
  executor_ = executor;
  workers_.clear();
  for (int k = 0; executor && k < executor->workers(); ++k) {
    workers_.push_back(std::make_unique<Worker>());
    workers_.back()->solver.set_systems(first_);
  }
}

/// Replaces the data of this solver by a copy of one island of `from`. All indices in the copy count from the beginning of the island.
void VelocitySolver::copy_island(const VelocitySolver& from, const Island& island) {
  const auto members =
      std::span(from.members_).subspan(static_cast<std::size_t>(island.first_system), static_cast<std::size_t>(island.systems));
  const auto order = std::span(from.order_).subspan(static_cast<std::size_t>(island.first_block), static_cast<std::size_t>(island.blocks));
  clear();
  first_.assign(1, 0);
  w_.clear();
  members_.clear();
  order_.clear();
  for (const int member : members) {
    const auto s = static_cast<std::size_t>(member);
    cursor_[s] = static_cast<int>(members_.size());  // index in the island of system s of `from`
    members_.push_back(static_cast<int>(members_.size()));
    w_.insert(w_.end(), from.w_.begin() + from.first_[s], from.w_.begin() + from.first_[s + 1]);
    first_.push_back(static_cast<int>(w_.size()));
  }
  std::ranges::fill(std::span(motion_).first(members.size()), 0.0);
  for (const int i : order) {
    RowBlock b = from.blocks_[static_cast<std::size_t>(i)];
    const auto rows = static_cast<std::ptrdiff_t>(b.rows);
    target_.insert(target_.end(), from.target_.begin() + b.row, from.target_.begin() + b.row + rows);
    p_.insert(p_.end(), from.p_.begin() + b.row, from.p_.begin() + b.row + rows);
    b.row = static_cast<int>(p_.size() - static_cast<std::size_t>(rows));
    const auto segments =
        std::span(from.segments_).subspan(static_cast<std::size_t>(b.first_segment), static_cast<std::size_t>(b.segments));
    b.first_segment = static_cast<int>(segments_.size());
    for (RowSegment x : segments) {
      const double* const y = from.rows_.data() + x.offset;
      x.offset = static_cast<int>(rows_.size());
      rows_.insert(rows_.end(), y, y + 4 * static_cast<std::ptrdiff_t>(x.length));
      x.system = cursor_[static_cast<std::size_t>(x.system)];
      x.first = first_[static_cast<std::size_t>(x.system)];
      segments_.push_back(x);
    }
    order_.push_back(static_cast<int>(blocks_.size()));
    b.contact_block = static_cast<int>(blocks_.size()) - 1;  // a roll block directly follows the block of its contact
    blocks_.push_back(b);
  }
}

/// Copies the impulses and velocity changes of the island back to `to`, from which copy_island() copied the island.
void VelocitySolver::copy_solution_to(VelocitySolver& to, const Island& island) const {
  for (std::size_t k = 0; k < static_cast<std::size_t>(island.systems); ++k) {
    const int s = to.members_[static_cast<std::size_t>(island.first_system) + k];
    std::copy(w_.begin() + first_[k], w_.begin() + first_[k + 1], to.w_.begin() + to.first_[static_cast<std::size_t>(s)]);
  }
  for (std::size_t k = 0; k < blocks_.size(); ++k) {
    const RowBlock& b = to.blocks_[static_cast<std::size_t>(to.order_[static_cast<std::size_t>(island.first_block) + k])];
    std::copy_n(p_.begin() + blocks_[k].row, b.rows, to.p_.begin() + b.row);
  }
}

/// Solves the islands in to_solve_ on all threads. One thread solves a whole island, so results do not depend on the number of threads.
void VelocitySolver::solve_on_threads(const SolverOptions& options, SolverReport& report) {
  for (const auto& w : workers_) {
    w->report = {};
    w->solver.island_budget_ = island_budget_;
  }
  used_.resize(to_solve_.size());
  parallel_for(executor_, to_solve_.size(), [&](std::size_t k, int worker) {
    Worker& w = *workers_[static_cast<std::size_t>(worker)];
    const Island& island = islands_[static_cast<std::size_t>(to_solve_[k])];
    w.solver.copy_island(*this, island);
    const bool solved = w.solver.solve_island({0, island.blocks, 0, island.systems}, options, w.report);
    if (!solved) failed_[static_cast<std::size_t>(members_[static_cast<std::size_t>(island.first_system)])] = 1;
    w.solver.copy_solution_to(*this, island);
    used_[k] = island_budget_ - w.solver.budget_;
  });
  for (const double operations : used_) newton_left_ -= operations;  // summed in the order of the islands, as on one thread
  for (const auto& w : workers_) {
    report.sweeps = std::max(report.sweeps, w->report.sweeps);
    report.newton_steps += w->report.newton_steps;
    report.handed_over += w->report.handed_over;
    report.residual = std::max(report.residual, w->report.residual);
  }
}

}  // namespace ugoki::contact
