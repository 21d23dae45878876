#include "ugoki/contact/dense_island.h"

#include <algorithm>
#include <cmath>

#include "ugoki/contact/contact_law.h"
#include "ugoki/contact/solver_kernels.h"

namespace ugoki::contact {
namespace {

/// Number of sweeps that classify the blocks. More sweeps save no Newton steps: with 2, 3, 4, 6 or 8 sweeps a step of a falling humanoid
/// needs 1.2 to 1.5.
constexpr int classifying_sweeps = 2;
/// An attempt to solve the island by the Newton method.
struct Attempt {
  enum class Start : unsigned char { present, swept, zero };
  Start start;                 // impulses to start from: present ones, present ones after a few sweeps, or zero
  double augmentation, later;  // a of the natural map (dense_island.h): at first, and after the steps have stopped reducing the residual
};
/// The first attempt solves 99.8 % of the islands of falling and lying characters (10,700 islands, ./bench step), in 1.3 steps each; all
/// three leave 8 islands. With a = 1 instead of 0.1 the first attempt fails three times as often.
constexpr Attempt attempts[] = {
    {Attempt::Start::present, 0.1, 0.02}, {Attempt::Start::swept, 0.003, 0.003}, {Attempt::Start::zero, 0.01, 0.01}};
/// Maximum number of Newton steps of an attempt.
constexpr int max_newton_steps = 24;
/// An attempt continues with `later`, and then ends, when `patience` steps in turn have not reduced the squared residual to the fraction
/// `progress`. Newton's method then usually alternates between the same classes. In a heap of 200 bodies, 99 % of the attempts that
/// converge never need more steps than this without progress, and attempts that fail made more than half of all Newton steps.
constexpr int patience = 4;
constexpr double progress = 0.9;
/// Number of sweeps of Start::swept.
constexpr int restart_sweeps = 20;

}  // namespace

DenseIsland::DenseIsland() {
  constexpr std::size_t n = max_rows;
  local_.reserve(n);
  impact_impulse_.reserve(n);
  B_.reserve(n * (n + 8));
  for (std::vector<double>* x : {&target_, &p_, &u_, &best_p_, &fixed_, &fixed_u_, &made_u_, &step_, &step_u_, &old_p_, &old_u_, &z_})
    x->reserve(n);
  unknowns_.reserve(n);
  sliding_.reserve(n);
  A_.reserve(n * (n + 1));
  S_.reserve(n / 3 * (n / 3 + 1));
  inverse_.reserve(n);
}

/// Numbers the rows of the island.
void DenseIsland::number_rows(const IslandRows& island) {
  const std::size_t count = island.order.size();
  local_.resize(count);
  impact_impulse_.assign(count, 0.0);
  n_ = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const RowBlock& b = island.blocks[static_cast<std::size_t>(island.order[i])];
    if (b.kind == RowKind::roll) impact_impulse_[i] = island.blocks[static_cast<std::size_t>(b.contact_block)].impact_impulse;
    local_[i] = n_;
    n_ += b.rows;
  }
  stride_ = (n_ + 7) & ~3;
}

/// Calculates B = Y Y^T (Y: whitened rows).
void DenseIsland::make_matrix(const IslandRows& island) {
  B_.resize(static_cast<std::size_t>(n_) * static_cast<std::size_t>(stride_));
  solver_kernels().make_matrix({island.blocks.data(), island.order.data(), static_cast<int>(island.order.size()), island.segments.data(),
                                island.rows, local_.data(), B_.data(), stride_});
}

/// Calculates the velocities u = target + B p from the impulses p.
void DenseIsland::update_velocities() {
  std::ranges::copy(target_, u_.begin());
  solver_kernels().add_product(B_.data(), stride_, n_, p_.data(), u_.data());
}

/// Solves each block once, with the impulses of the others fixed. @return m/s: maximum change of a velocity
double DenseIsland::sweep(const IslandRows& island, bool forward) {
  const std::size_t count = island.order.size();
  double maximum = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = forward ? k : count - 1 - k;
    const RowBlock& b = island.blocks[static_cast<std::size_t>(island.order[i])];
    double* const p = p_.data() + local_[i];
    double next[3], change[3] = {0, 0, 0};
    next_impulse(b, u_.data() + local_[i], p, b.kind == RowKind::roll ? normal_impulse(i) : 0, next);
    for (int r = 0; r < b.rows; ++r) {
      change[r] = next[r] - p[r];
      p[r] = next[r];
    }
    maximum = std::max(maximum, velocity_change(b, change) * b.lever);
    if (change[0] == 0 && change[1] == 0 && change[2] == 0) continue;
    const double* const B = column(local_[i]);
    if (b.rows == 3)
      for (int e = 0; e < n_; ++e)
        u_[static_cast<std::size_t>(e)] += B[e] * change[0] + B[e + stride_] * change[1] + B[e + 2 * stride_] * change[2];
    else
      for (int e = 0; e < n_; ++e) u_[static_cast<std::size_t>(e)] += B[e] * change[0];
  }
  return maximum;
}

/// Clamps each impulse to the bounds of its law, except rolling resistance, which the next sweep clamps.
void DenseIsland::project(const IslandRows& island) {
  for (std::size_t i = 0; i < island.order.size(); ++i) {
    const RowBlock& b = island.blocks[static_cast<std::size_t>(island.order[i])];
    double* const p = p_.data() + local_[i];
    switch (b.kind) {
      case RowKind::contact:
        p[0] = std::max(0.0, p[0]);
        clamp_to_disk(p[1], p[2], b.mu * (p[0] + b.impact_impulse));
        break;
      case RowKind::limit: p[0] = std::max(0.0, p[0]); break;
      case RowKind::friction: p[0] = std::clamp(p[0], -b.bound, b.bound); break;
      case RowKind::roll:
      case RowKind::grip: break;
    }
  }
}

/// Newton steps until the residual is below the tolerance or stops falling. Keeps the impulses in best_p_ if they are the best so far.
void DenseIsland::solve_by_newton(const IslandRows& island, double augmentation, double later, double tolerance, DenseResult& result) {
  augmentation_ = augmentation;
  double norm = residual(island), lowest = norm;
  int idle = 0;  // steps since the last progress
  for (int k = 1; k <= max_newton_steps && !result.converged && newton_step(island, norm); ++k) {
    ++result.newton_steps;
    if (max_residual_ < result.change) {
      result.change = max_residual_;
      best_p_ = p_;
      result.converged = max_residual_ < tolerance;
    }
    idle = norm < progress * lowest ? 0 : idle + 1;
    lowest = std::min(lowest, norm);
    if (idle < patience) continue;
    if (augmentation_ == later) break;
    augmentation_ = later;
    norm = lowest = residual(island);
    idle = 0;
  }
  std::swap(p_, best_p_);
  project(island);
  std::swap(p_, best_p_);
}

DenseResult DenseIsland::solve(const IslandRows& island, double tolerance) {
  DenseResult result;
  number_rows(island);
  make_matrix(island);
  for (std::vector<double>* x : {&target_, &p_, &u_, &fixed_, &fixed_u_, &made_u_, &step_u_}) x->resize(static_cast<std::size_t>(n_));
  for (std::size_t i = 0; i < island.order.size(); ++i) {
    const RowBlock& b = island.blocks[static_cast<std::size_t>(island.order[i])];
    std::copy_n(island.target + b.row, b.rows, target_.begin() + local_[i]);
    std::copy_n(island.p + b.row, b.rows, p_.begin() + local_[i]);
  }
  update_velocities();
  best_p_ = p_;
  result.change = HUGE_VAL;
  const auto sweep_and_compare = [&](bool forward) {
    const double change = sweep(island, forward);
    ++result.sweeps;
    if (change < result.change) {
      result.change = change;
      best_p_ = p_;
    }
    result.converged = change < tolerance;
  };
  augmentation_ = attempts[0].augmentation;
  residual(island);
  result.change = max_residual_;
  result.converged = max_residual_ < tolerance;
  for (int k = 0; k < classifying_sweeps && !result.converged; ++k) sweep_and_compare(k % 2 == 0);
  for (const Attempt& attempt : attempts) {
    if (result.converged) break;
    if (attempt.start != Attempt::Start::present) {
      p_ = best_p_;
      if (attempt.start == Attempt::Start::zero) std::ranges::fill(p_, 0.0);
      update_velocities();
    }
    for (int k = 0; attempt.start == Attempt::Start::swept && k < restart_sweeps && !result.converged; ++k) sweep_and_compare(k % 2 == 0);
    if (!result.converged) solve_by_newton(island, attempt.augmentation, attempt.later, tolerance, result);
  }
  result.converged = result.converged || result.change < accepted_residual;
  for (std::size_t i = 0; i < island.order.size(); ++i) {
    const RowBlock& b = island.blocks[static_cast<std::size_t>(island.order[i])];
    std::copy_n(best_p_.begin() + local_[i], b.rows, island.p + b.row);
  }
  return result;
}

}  // namespace ugoki::contact
