#include "ugoki/contact/tree_island.h"

#include <algorithm>
#include <cmath>

#include "ugoki/contact/augmented_law.h"
#include "ugoki/contact/contact_law.h"
#include "ugoki/contact/natural_map.h"

namespace ugoki::contact {
namespace {

// Of Newton's method, as in velocity_newton.cpp: first and minimum value of R relative to a block's inverse inertia, updates of p^, and the
// line search, which ends when the slope of the merit has fallen to a fraction. With a minimum of 1e-6, the rounding of the velocities
// divided by R leaves residuals of 1e-6 m/s.
constexpr double first_regularization = 1e-3, min_regularization = 1e-5;
constexpr int max_updates = 20, max_steps = 12, max_trials = 8;
constexpr double slope_ratio = 0.1;
// Slope of the merit, as a fraction of that of the first step, below which a step is rounding.
constexpr double rounding_slope = 1e-24;
// Newton's method is repeated from the best impulses. The number of repetitions bounds the work of a step.
constexpr int max_rounds = 3;
// Loops may keep a DOF or a link from moving. Its inverse inertia is then rounding: below this fraction of that without loops.
constexpr double held = 1e-12;
// Pivot threshold of dependent loop rows, that of stepper_loops.cpp.
constexpr double dependent = dynamics::dependent_correction * 1e-4;

}  // namespace

TreeIsland::TreeIsland(const Mechanism& m) : solver_(m) {
  const auto n = static_cast<std::size_t>(m.nv()), links = static_cast<std::size_t>(m.link_count());
  for (std::vector<double>* x : {&extra_, &change_, &step_, &r_, &stiff_extra_, &best_change_}) x->resize(n);
  closing_.resize(static_cast<std::size_t>(solver_.rows().count()));
  for (std::vector<Vec6>* x : {&change_V_, &step_V_, &wrenches_}) x->resize(links);
  K_.resize(links);
  const std::size_t blocks = 64 + 4 * links + n;
  blocks_.reserve(blocks);
  places_.reserve(blocks);
  shift_.reserve(blocks);
  next_shift_.reserve(blocks);
  G_.reserve(9 * blocks);
  for (std::vector<double>* x : {&target_, &p_, &hat_, &old_p_, &u_, &du_, &best_p_}) x->reserve(3 * blocks);
}

bool TreeIsland::can_treat(const Mechanism& m) {
  return std::ranges::none_of(m.links(), [](const Link& link) {
    return link.joint.type == JointType::spherical && std::ranges::any_of(std::span(link.joint.dofs).first(3), [](const Dof& f) {
             return std::isfinite(f.lower) || std::isfinite(f.upper);
           });
  });
}

int TreeIsland::begin(const Mechanism& m, dynamics::Workspace& ws, std::span<const double> q, std::span<const double> v,
                      const dynamics::ArticulatedFactor& open, std::span<const double> extra, double closing_speed, double dt) {
  blocks_.clear();
  places_.clear();
  for (std::vector<double>* x : {&target_, &p_, &u_}) x->clear();
  finished_ = 0;
  open_ = &open;
  std::ranges::fill(change_, 0.0);
  std::ranges::copy(extra, extra_.begin());
  solver_.update_rows(m, ws, q, v);
  // Bounded: a mechanism whose loops are open at the start must not close them at a high speed. Positions are closed after the step.
  for (std::size_t k = 0; k < closing_.size(); ++k) closing_[k] = std::clamp(solver_.rows().gap[k] / dt, -closing_speed, closing_speed);
  base_factor_ = true;
  return solver_.factor(m, ws, dependent, extra_, {});
}

void TreeIsland::move(const Mechanism& m, dynamics::Workspace& ws, std::span<const double> v, std::span<double> r) {
  solver_.solve(m, ws, r, {}, v, closing_, step_);
  for (std::size_t i = 0; i < r.size(); ++i) r[i] = v[i] + step_[i];
}

RowBlock& TreeIsland::add_block(RowKind kind, std::uint64_t key, const Place& place, std::span<const double> target,
                                std::span<const double> warm) {
  RowBlock& b = blocks_.emplace_back();
  b = {};
  b.kind = kind;
  b.rows = static_cast<int>(target.size());
  b.row = static_cast<int>(target_.size());
  b.contact = -1;
  b.lever = 1;
  b.key = key;
  places_.push_back(place);
  for (std::size_t r = 0; r < target.size(); ++r) {
    target_.push_back(target[r]);
    p_.push_back(warm.empty() ? 0 : warm[r]);
  }
  return b;
}

RowBlock& TreeIsland::add_contact(std::uint64_t key, int link, std::span<const Vec6, 3> wrenches, std::span<const double, 3> target,
                                  std::span<const double> warm) {
  return add_block(RowKind::contact, key, {link, -1, false, {wrenches[0], wrenches[1], wrenches[2]}}, target, warm);
}

RowBlock& TreeIsland::add_joint_row(RowKind kind, std::uint64_t key, int dof, double sign, double target, std::span<const double> warm) {
  return add_block(kind, key, {-1, dof, false, {{{sign, 0, 0}, {}}, {}, {}}}, {&target, 1}, warm);
}

/// Calculates the inverse inertia of the new blocks.
void TreeIsland::finish_blocks(const Mechanism& m, dynamics::Workspace& ws, double softness) {
  if (!base_factor_) (void)solver_.factor(m, ws, dependent, extra_, {});
  base_factor_ = true;
  const dynamics::LinkResponses& responses = solver_.calc_responses(m, ws);
  for (; finished_ < blocks_.size(); ++finished_) {
    RowBlock& b = blocks_[finished_];
    Place& at = places_[finished_];
    if (at.link < 0) {
      const auto f = static_cast<std::size_t>(at.dof);
      b.B[0] = responses.dof[f];
      at.held = !(b.B[0] > held * open_->inverse_pivot(f));
    } else {
      Vec6 V[3];
      for (int r = 0; r < 3; ++r) V[r] = dynamics::product(responses.link[static_cast<std::size_t>(at.link)], at.W[r]);
      for (int r = 0; r < 3; ++r) b.B[r] = dot(at.W[r], V[r]);
      b.B[3] = dot(at.W[0], V[1]);
      b.B[4] = dot(at.W[0], V[2]);
      b.B[5] = dot(at.W[1], V[2]);
      at.held = !(b.B[0] > held / m.mass());
      for (int r = 1; r < 3; ++r) b.B[r] = std::max(b.B[r], held * b.B[0]);
    }
    finish_block(b, softness);
    if (at.held) std::fill_n(p_.begin() + b.row, b.rows, 0.0);
  }
}

/// Calculates the velocity change of the present impulses, and the velocities of all rows.
void TreeIsland::find_change(const Mechanism& m, dynamics::Workspace& ws) {
  if (!base_factor_) (void)solver_.factor(m, ws, dependent, extra_, {});  // begin() has checked the pivots
  base_factor_ = true;
  std::ranges::fill(wrenches_, Vec6{});
  std::ranges::fill(r_, 0.0);
  std::ranges::fill(change_, 0.0);
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const double* const p = p_.data() + blocks_[i].row;
    const Place& at = places_[i];
    if (at.link < 0)
      r_[static_cast<std::size_t>(at.dof)] += at.W[0].w.x * p[0];
    else
      wrenches_[static_cast<std::size_t>(at.link)] -= at.W[0] * p[0] + at.W[1] * p[1] + at.W[2] * p[2];
  }
  solver_.solve(m, ws, r_, wrenches_, change_, {}, step_);
  std::swap(change_, step_);
  std::ranges::copy(ws.A, change_V_.begin());
  find_velocities(change_V_, change_, u_);
  for (std::size_t k = 0; k < u_.size(); ++k) u_[k] += target_[k];
}

/// Calculates the velocities of all rows from those of links and DOFs.
void TreeIsland::find_velocities(std::span<const Vec6> links, std::span<const double> dofs, std::span<double> u) const {
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const Place& at = places_[i];
    double* const to = u.data() + blocks_[i].row;
    if (at.link < 0) {
      to[0] = at.W[0].w.x * dofs[static_cast<std::size_t>(at.dof)];
      continue;
    }
    const Vec6& V = links[static_cast<std::size_t>(at.link)];
    for (int r = 0; r < 3; ++r) to[r] = dot(at.W[r], V);
  }
}

/// Residual of the natural map of the laws. @return m/s: maximum velocity error; infinite if an impulse is not finite
double TreeIsland::measure() const {
  NaturalMap map{.augmentation = 0.1};
  for (std::size_t i = 0; i < blocks_.size(); ++i)
    if (!places_[i].held) map.add(blocks_[i], 0, p_.data() + blocks_[i].row, u_.data() + blocks_[i].row);
  return std::isfinite(map.square) ? map.maximum : HUGE_VAL;
}

/// Calculates the law's impulses p and the matrices G of all blocks at the velocities u_ + length du_.
TreeIsland::Slope TreeIsland::apply_laws(double length) {
  Slope sum{};
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const RowBlock& b = blocks_[i];
    const double *u = u_.data() + b.row, *du = du_.data() + b.row;
    double *p = p_.data() + b.row, *G = G_.data() + 9 * i, next[3] = {};
    if (places_[i].held) continue;
    for (int r = 0; r < b.rows; ++r) next[r] = u[r] + length * du[r];
    augmented_impulse(b, {regularization_, hat_.data() + b.row, shift_[i], 0}, next, p, G);
    for (int r = 0; r < b.rows; ++r) {
      sum.laws += (p[r] - old_p_[static_cast<std::size_t>(b.row + r)]) * du[r];
      for (int c = 0; c < b.rows; ++c) sum.curvature += du[r] * G[3 * r + c] * du[c];
    }
  }
  return sum;
}

/// Sets r_ and wrenches_ to -F, K_ and stiff_extra_ to the stiffness of the blocks.
void TreeIsland::assemble(const dynamics::Workspace& ws) {
  std::ranges::fill(K_, dynamics::ArticulatedInertia{});
  for (std::size_t i = 0; i < wrenches_.size(); ++i) wrenches_[i] = ws.I[i] * change_V_[i];
  for (std::size_t f = 0; f < r_.size(); ++f) {
    r_[f] = -(ws.armature[f] + extra_[f]) * change_[f];
    stiff_extra_[f] = extra_[f];
  }
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const double* const p = p_.data() + blocks_[i].row;
    const double* const G = G_.data() + 9 * i;
    const Place& at = places_[i];
    if (at.held) continue;
    if (at.link < 0) {
      const auto f = static_cast<std::size_t>(at.dof);
      r_[f] += at.W[0].w.x * p[0];
      stiff_extra_[f] += G[0];
      continue;
    }
    const auto l = static_cast<std::size_t>(at.link);
    wrenches_[l] -= at.W[0] * p[0] + at.W[1] * p[1] + at.W[2] * p[2];
    if (!(G[0] + G[4] + G[8] > 0)) continue;
    for (int r = 0; r < 3; ++r) dynamics::add_product(K_[l], at.W[r], at.W[0] * G[3 * r] + at.W[1] * G[3 * r + 1] + at.W[2] * G[3 * r + 2]);
  }
}

/// Minimises the merit with p^ and the shifts of sliding contacts fixed; sets p to the law's impulses. @return number of Newton steps
int TreeIsland::minimise(const Mechanism& m, dynamics::Workspace& ws, double tolerance) {
  double first_slope = 0;
  std::ranges::fill(du_, 0.0);
  old_p_ = p_;
  apply_laws(0);
  for (int steps = 1; steps <= max_steps; ++steps) {
    assemble(ws);
    base_factor_ = false;
    if (solver_.factor(m, ws, dependent, stiff_extra_, K_) >= 0) return steps;
    solver_.solve(m, ws, r_, wrenches_, change_, {}, step_);
    std::ranges::copy(ws.A, step_V_.begin());
    find_velocities(step_V_, step_, du_);
    // The slope of the merit at the beginning of the step is -step . H step. This sum of positive terms keeps its digits at convergence;
    // the difference of the parts of F does not.
    double square = 0;  // step . M' step
    for (std::size_t i = 0; i < step_V_.size(); ++i) square += dot(step_V_[i], ws.I[i] * step_V_[i]);
    for (std::size_t f = 0; f < step_.size(); ++f) square += (ws.armature[f] + extra_[f]) * step_[f] * step_[f];
    old_p_ = p_;
    const double slope = square + apply_laws(0).curvature;
    if (steps == 1) first_slope = slope;
    if (!(slope > rounding_slope * first_slope)) return steps;
    // The slope of the merit grows along the step and has one zero: Newton's method, kept between `low` and `high`.
    double length = 1, low = 0, high = HUGE_VAL;
    for (int trial = 1;; ++trial) {
      const Slope blocks = apply_laws(length);
      const double now = length * square - slope - blocks.laws;
      if (std::fabs(now) <= slope_ratio * slope || trial == max_trials) break;
      (now > 0 ? high : low) = length;
      const double next = length - now / (square + blocks.curvature);
      length = next > low && next < high ? next : high < HUGE_VAL ? 0.5 * (low + high) : 2 * length;
    }
    for (std::size_t f = 0; f < step_.size(); ++f) change_[f] += length * step_[f];
    for (std::size_t i = 0; i < step_V_.size(); ++i) change_V_[i] += step_V_[i] * length;
    for (std::size_t k = 0; k < u_.size(); ++k) u_[k] += length * du_[k];
    double largest = 0;  // m/s
    for (const double x : du_) largest = std::max(largest, std::fabs(length * x));
    if (largest < 0.1 * tolerance * regularization_) return steps;  // the impulses change by largest / R
  }
  return max_steps;
}

/// Improves p by updates of p^. @return number of Newton steps
int TreeIsland::newton(const Mechanism& m, dynamics::Workspace& ws, double tolerance, int limit) {
  int steps = 0;
  double moved = 0;
  regularization_ = first_regularization;
  const auto find_shifts = [&](std::span<double> shifts) {
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      const RowBlock& b = blocks_[i];
      shifts[i] = b.kind == RowKind::contact ? sliding_shift(b, p_.data() + b.row, u_.data() + b.row) : 0;
    }
  };
  find_shifts(shift_);
  mixing_.begin(blocks_.size());
  for (int update = 0; update < max_updates && steps < limit; ++update) {
    hat_ = p_;
    steps += minimise(m, ws, std::max(tolerance, 0.01 * moved));
    moved = 0;  // m/s: velocity error that corresponds to the last change of p^, and of the shifts
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      const RowBlock& b = blocks_[i];
      if (places_[i].held) continue;
      for (int r = 0; r < b.rows; ++r) {
        const auto at = static_cast<std::size_t>(b.row + r);
        moved = std::max(moved, regularization_ * b.B[r] * std::fabs(p_[at] - hat_[at]));
      }
      if (b.kind == RowKind::contact)
        moved = std::max(moved, std::fabs(sliding_shift(b, p_.data() + b.row, u_.data() + b.row) - shift_[i]));
    }
    if (moved < 0.5 * tolerance) break;
    find_shifts(next_shift_);
    mixing_.next(shift_, next_shift_);
    for (double& s : shift_) s = std::max(0.0, s);
    regularization_ = std::max(0.1 * regularization_, min_regularization);
  }
  return steps;
}

void TreeIsland::solve(const Mechanism& m, dynamics::Workspace& ws, const SolverOptions& options, int max_newton_steps,
                       SolverReport& report) {
  if (blocks_.empty()) return;
  ++report.islands;
  if (finished_ < blocks_.size()) finish_blocks(m, ws, options.softness);
  u_.resize(p_.size());
  du_.resize(p_.size());
  shift_.resize(blocks_.size());
  next_shift_.resize(blocks_.size());
  G_.resize(9 * blocks_.size());
  find_change(m, ws);
  double residual = measure();
  best_p_ = p_;
  best_change_ = change_;
  int left = max_newton_steps;
  for (int round = 0; round < max_rounds && left > 0 && !(residual < options.tolerance); ++round) {
    const int steps = newton(m, ws, options.tolerance, left);
    report.newton_steps += steps;
    left -= steps;
    find_change(m, ws);
    const double now = measure();
    if (now < residual) {
      residual = now;
      best_p_ = p_;
      best_change_ = change_;
    } else if (round + 1 < max_rounds) {
      p_ = best_p_;
      find_change(m, ws);
    }
  }
  std::swap(p_, best_p_);
  std::swap(change_, best_change_);
  report.sweeps = std::max(report.sweeps, 1);
  report.residual = std::max(report.residual, residual);
  if (!(residual < std::max(options.tolerance, DenseIsland::accepted_residual))) ++report.not_converged;
}

}  // namespace ugoki::contact
