#include "ugoki/contact/dense_island.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "ugoki/contact/contact_law.h"

namespace ugoki::contact {
namespace {

/// Number of sweeps that classify the blocks. More sweeps save no Newton steps: with 2, 3, 4, 6 or 8 sweeps a step of a falling humanoid
/// needs 1.2 to 1.5.
constexpr int classifying_sweeps = 2;
/// An attempt to solve the island by the Newton method.
struct Attempt {
  enum class Start : unsigned char { present, swept, zero };
  Start start;                 // impulses to start from: present ones, present ones after a few sweeps, or zero
  double augmentation, later;  // a of the natural map (dense_island.h) in the first half of the steps, and in the second half
};
/// The first attempt solves 99.8 % of the islands of falling and lying characters (10,700 islands, ./bench step), in 1.3 steps each; all
/// three leave 8 islands. With a = 1 instead of 0.1 the first attempt fails three times as often.
constexpr Attempt attempts[] = {
    {Attempt::Start::present, 0.1, 0.02}, {Attempt::Start::swept, 0.003, 0.003}, {Attempt::Start::zero, 0.01, 0.01}};
/// Maximum number of Newton steps of an attempt.
constexpr int max_newton_steps = 24;
/// Number of sweeps of Start::swept.
constexpr int restart_sweeps = 20;
/// Maximum number of halvings of a Newton step that does not reduce the residual.
constexpr int max_halvings = 5;
/// Regularization of rows that may depend on each other (friction of redundant contacts), as a fraction of their inverse inertia. It is
/// in Newton's matrix only, not in the law. With 1e-7 or 1e-2 a falling humanoid needs 1.5 times as many Newton steps.
constexpr double regularization = 1e-4;
/// Regularization of limit rows, as a fraction of their inverse inertia. They depend on other rows only when a chain is jammed.
constexpr double limit_regularization = 1e-7;
/// Solves A x = b by Gaussian elimination with partial pivoting. @param A [n][n + 1], last column b; destroyed
/// @return false if A is singular
bool solve_dense(double* A, std::size_t n, double* x) {
  const std::size_t width = n + 1;
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t best = k;
    for (std::size_t i = k + 1; i < n; ++i)
      if (std::fabs(A[i * width + k]) > std::fabs(A[best * width + k])) best = i;
    const double pivot = A[best * width + k];
    if (!(std::fabs(pivot) > 1e-300)) return false;
    if (best != k) std::swap_ranges(A + k * width, A + (k + 1) * width, A + best * width);
    const double* const row = A + k * width;
    for (std::size_t i = k + 1; i < n; ++i) {
      double* const other = A + i * width;
      const double factor = other[k] / pivot;
      if (factor == 0) continue;
      for (std::size_t j = k + 1; j <= n; ++j) other[j] -= factor * row[j];
    }
  }
  for (std::size_t k = n; k-- > 0;) {
    double sum = A[k * width + n];
    for (std::size_t j = k + 1; j < n; ++j) sum -= A[k * width + j] * x[j];
    x[k] = sum / A[k * width + k];
  }
  return true;
}

bool is_finite(double x) { return x - x == 0; }

/// Projects p - u / metric of a roll block onto the ball of its law.
/// @param x [3, out] @return the size before the projection as a fraction of the ball's radius; infinite for a radius of zero
double roll_projection(const RowBlock& b, const double* p, const double* u, double metric, double normal, double* x) {
  const double radius = b.mu * std::max(0.0, normal);
  double square = 0;
  for (int r = 0; r < 3; ++r) {
    x[r] = p[r] - u[r] / metric;
    square += x[r] * x[r];
  }
  const double size = std::sqrt(square);
  if (size > radius)
    for (int r = 0; r < 3; ++r) x[r] *= radius / size;
  return radius > 0 ? size / radius : HUGE_VAL;
}

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

/// Calculates B = Y Y^T (Y: whitened rows). Two chains of one system share their DOFs from the root up to the first difference.
void DenseIsland::make_matrix(const IslandRows& island) {
  const auto stride = static_cast<std::size_t>(stride_);
  B_.assign(static_cast<std::size_t>(n_) * stride, 0.0);
  const std::size_t count = island.order.size();
  for (std::size_t i = 0; i < count; ++i) {
    const RowBlock& a = island.blocks[static_cast<std::size_t>(island.order[i])];
    for (std::size_t j = 0; j <= i; ++j) {
      const RowBlock& b = island.blocks[static_cast<std::size_t>(island.order[j])];
      RowLanes sum[3] = {};
      for (int sa = 0; sa < a.segments; ++sa) {
        const RowSegment& x = island.segments[static_cast<std::size_t>(a.first_segment + sa)];
        for (int sb = 0; sb < b.segments; ++sb) {
          const RowSegment& y = island.segments[static_cast<std::size_t>(b.first_segment + sb)];
          if (x.system != y.system) continue;
          int shared = std::min(x.length, y.length);
          if (x.index != y.index) {
            const auto dof = [](const RowSegment& chain, int e) { return chain.index ? chain.index[e] : e; };
            while (shared > 0 && dof(x, shared - 1) != dof(y, shared - 1)) --shared;
          }
          const double* const X = island.rows + x.offset;
          const double* const Y = island.rows + y.offset;
          for (int e = 0; e < shared; ++e) {
            const RowLanes lanes = row_lanes(Y, e);
            for (int r = 0; r < a.rows; ++r) sum[r] += X[4 * e + r] * lanes;
          }
        }
      }
      for (int r = 0; r < a.rows; ++r)
        for (int c = 0; c < b.rows; ++c) {
          const auto row = static_cast<std::size_t>(local_[i] + r), col = static_cast<std::size_t>(local_[j] + c);
          B_[row * stride + col] = sum[r][c];
          B_[col * stride + row] = sum[r][c];
        }
    }
  }
}

/// Calculates the velocities u = target + B p from the impulses p.
void DenseIsland::update_velocities() {
  std::ranges::copy(target_, u_.begin());
  for (int r = 0; r < n_; ++r)
    if (const double p = p_[static_cast<std::size_t>(r)]; p != 0)
      for (int k = 0; k < n_; ++k) u_[static_cast<std::size_t>(k)] += column(r)[k] * p;
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

/// Adds the unknowns of a contact at the present p and u.
void DenseIsland::add_contact(const RowBlock& b, int row) {
  const double* const p = p_.data() + row;
  const double* const u = u_.data() + row;
  double* const fixed = fixed_.data() + row;
  const double soft = b.compliance * b.B[0], B_t = std::max(b.B[1], b.B[2]), metric = augmentation_ * B_t;
  const double x_n = std::max(0.0, p[0] - (u[0] + soft * p[0]) / (augmentation_ * b.B[0]));
  const double radius = b.mu * (x_n + b.impact_impulse);
  fixed[0] = fixed[1] = fixed[2] = 0;
  const double x1 = p[1] - u[1] / metric, x2 = p[2] - u[2] / metric, size = std::sqrt(x1 * x1 + x2 * x2);
  const bool sticks = size <= radius;
  if (x_n > 0 && (sticks || !(radius > 0))) unknowns_.push_back({row, false, 0, 0, soft, 0});
  if (!(radius > 0)) return;
  if (sticks) {
    for (int r = 1; r < 3; ++r) unknowns_.push_back({row + r, false, 0, 0, regularization * B_t, regularization * B_t * p[r]});
    return;
  }
  const double d1 = x1 / size, d2 = x2 / size;
  fixed[1] = b.mu * b.impact_impulse * d1;
  fixed[2] = b.mu * b.impact_impulse * d2;
  if (x_n > 0) sliding_.push_back({row, true, b.mu * d1, b.mu * d2, soft, 0});
  unknowns_.push_back({row, true, -d2, d1, std::max(metric * (size / radius - 1), regularization * B_t), 0});
}

/// Collects the unknowns of a Newton step, and in fixed_ the impulses of all other rows.
void DenseIsland::collect_unknowns(const IslandRows& island) {
  unknowns_.clear();
  sliding_.clear();
  const auto add_plain = [&](int row, double diagonal) {
    const auto at = static_cast<std::size_t>(row);
    unknowns_.push_back({row, false, 0, 0, diagonal, diagonal * p_[at]});
    fixed_[at] = 0;
  };
  for (std::size_t i = 0; i < island.order.size(); ++i) {
    const RowBlock& b = island.blocks[static_cast<std::size_t>(island.order[i])];
    const double* const p = p_.data() + local_[i];
    const double* const u = u_.data() + local_[i];
    double* const fixed = fixed_.data() + local_[i];
    switch (b.kind) {
      case RowKind::contact: add_contact(b, local_[i]); break;
      case RowKind::limit:
        fixed[0] = 0;
        if (p[0] - u[0] / (augmentation_ * b.B[0]) > 0) add_plain(local_[i], limit_regularization * b.B[0]);
        break;
      case RowKind::friction: {
        const double x = p[0] - u[0] / (augmentation_ * b.B[0]);
        fixed[0] = std::clamp(x, -b.bound, b.bound);
        if (std::fabs(x) < b.bound) add_plain(local_[i], regularization * b.B[0]);
        break;
      }
      case RowKind::roll: {
        double x[3];
        const double radius = roll_projection(b, p, u, augmentation_ * b.size * b.size, normal_impulse(i), x);
        std::copy_n(x, 3, fixed);
        if (radius < 1)
          for (int r = 0; r < 3; ++r) add_plain(local_[i] + r, regularization * b.B[r]);
        break;
      }
    }
  }
}

/// Computes the natural map at p and u. @return its squared norm; sets max_residual_
double DenseIsland::residual(const IslandRows& island) {
  double sum = 0;
  max_residual_ = 0;
  // An entry of the natural map is a velocity for a row that obeys an equation, and an impulse times `metric` for a row at its bound.
  const auto add = [&](double metric, double change, bool at_bound) {
    const double f = metric * change;
    sum += f * f;
    max_residual_ = std::max(max_residual_, at_bound ? std::fabs(f) / augmentation_ : std::fabs(f));
  };
  for (std::size_t i = 0; i < island.order.size(); ++i) {
    const RowBlock& b = island.blocks[static_cast<std::size_t>(island.order[i])];
    const double* const p = p_.data() + local_[i];
    const double* const u = u_.data() + local_[i];
    const double metric = augmentation_ * b.B[0];
    switch (b.kind) {
      case RowKind::contact: {
        const double metric_t = augmentation_ * std::max(b.B[1], b.B[2]);
        const double x_n = std::max(0.0, p[0] - (u[0] + b.compliance * b.B[0] * p[0]) / metric), radius = b.mu * (x_n + b.impact_impulse);
        double x1 = p[1] - u[1] / metric_t, x2 = p[2] - u[2] / metric_t;
        const bool slides = x1 * x1 + x2 * x2 > radius * radius;
        clamp_to_disk(x1, x2, radius);
        add(metric, p[0] - x_n, x_n <= 0);
        add(metric_t, p[1] - x1, slides);
        add(metric_t, p[2] - x2, slides);
        break;
      }
      case RowKind::limit: {
        const double x = p[0] - u[0] / metric;
        add(metric, p[0] - std::max(0.0, x), x <= 0);
        break;
      }
      case RowKind::friction: {
        const double x = p[0] - u[0] / metric;
        add(metric, p[0] - std::clamp(x, -b.bound, b.bound), std::fabs(x) > b.bound);
        break;
      }
      case RowKind::roll: {
        double x[3];
        const bool slides = roll_projection(b, p, u, augmentation_ * b.size * b.size, normal_impulse(i), x) > 1;
        for (int r = 0; r < 3; ++r) add(augmentation_ * b.size * b.size * b.lever, p[r] - x[r], slides);
        break;
      }
    }
  }
  return sum;
}

/// Writes the linear equations of the unknowns to A_ and S_. With X the rows of an unknown, E those of its equation and B the inverse
/// inertia, an entry is E B X. E = X except for the normal impulses of sliding contacts, whose equation reads only the normal row.
void DenseIsland::make_equations() {
  const std::size_t n = unknowns_.size(), m = sliding_.size(), width = n + 2 * m + 1;
  std::ranges::copy(target_, fixed_u_.begin());
  for (int r = 0; r < n_; ++r)
    if (const double p = fixed_[static_cast<std::size_t>(r)]; p != 0)
      for (int k = 0; k < n_; ++k) fixed_u_[static_cast<std::size_t>(k)] += column(r)[k] * p;
  const auto read = [](const Unknown& x, const double* u) { return x.tangent ? x.t1 * u[x.row + 1] + x.t2 * u[x.row + 2] : u[x.row]; };
  A_.resize(n * width);
  S_.resize(m * (m + 1));
  for (std::size_t i = 0; i < n; ++i) {
    const Unknown& x = unknowns_[i];
    const double* u = column(x.row);
    if (x.tangent) {
      const double *t1 = column(x.row + 1), *t2 = column(x.row + 2);
      for (int k = 0; k < n_; ++k) made_u_[static_cast<std::size_t>(k)] = x.t1 * t1[k] + x.t2 * t2[k];
      u = made_u_.data();
    }
    double* const row = A_.data() + i * width;
    for (std::size_t j = i; j < n; ++j) row[j] = read(unknowns_[j], u);
    row[i] += x.diagonal;
    for (std::size_t j = 0; j < m; ++j) {
      row[n + j] = u[sliding_[j].row] + read(sliding_[j], u);
      row[n + m + j] = u[sliding_[j].row];
    }
    row[width - 1] = x.rest - read(x, fixed_u_.data());
  }
  for (std::size_t i = 0; i < m; ++i) {
    double* const row = S_.data() + i * (m + 1);
    const double* const u = column(sliding_[i].row);
    for (std::size_t j = 0; j < m; ++j) row[j] = u[sliding_[j].row] + read(sliding_[j], u);
    row[i] += sliding_[i].diagonal;
    row[m] = -fixed_u_[static_cast<std::size_t>(sliding_[i].row)];
  }
}

/// Solves the equations for z_: first the impulses of unknowns_, then those of sliding_. The matrix of the first part is symmetric: it is
/// factored without row exchanges. The rest, its Schur complement, has one row for each sliding contact. Dependent rows get the impulse 0.
/// @return false if the Schur complement is singular
bool DenseIsland::solve_equations() {
  constexpr double dependent = 1e-13;  // fraction of a diagonal entry that is rounding
  const std::size_t n = unknowns_.size(), m = sliding_.size(), width = n + 2 * m + 1;
  z_.resize(n + m);
  inverse_.resize(n);
  for (std::size_t i = 0; i < n; ++i) inverse_[i] = A_[i * width + i];
  for (std::size_t k = 0; k < n; ++k) {
    const double* const row = A_.data() + k * width;
    const double inverse = row[k] > dependent * inverse_[k] ? 1 / row[k] : 0;
    inverse_[k] = inverse;
    for (std::size_t i = k + 1; i < n; ++i) {
      const double factor = row[i] * inverse;
      if (factor == 0) continue;
      double* const other = A_.data() + i * width;
      for (std::size_t j = i; j < width; ++j) other[j] -= factor * row[j];
    }
  }
  for (std::size_t k = 0; k < n && m > 0; ++k) {
    const double* const row = A_.data() + k * width;
    for (std::size_t i = 0; i < m; ++i) {
      const double factor = row[n + m + i] * inverse_[k];
      for (std::size_t j = 0; j < m; ++j) S_[i * (m + 1) + j] -= factor * row[n + j];
      S_[i * (m + 1) + m] -= factor * row[width - 1];
    }
  }
  if (!solve_dense(S_.data(), m, z_.data() + n)) return false;
  for (std::size_t k = n; k-- > 0;) {
    const double* const row = A_.data() + k * width;
    double sum = row[width - 1];
    for (std::size_t j = 0; j < m; ++j) sum -= row[n + j] * z_[n + j];
    for (std::size_t j = k + 1; j < n; ++j) sum -= row[j] * z_[j];
    z_[k] = sum * inverse_[k];
  }
  return true;
}

/// Computes the full Newton step and its velocity change. @return false if the matrix is singular or the step is not finite
bool DenseIsland::find_step(const IslandRows& island) {
  collect_unknowns(island);
  make_equations();
  if (!solve_equations()) return false;
  step_ = fixed_;
  for (std::size_t j = 0; j < z_.size(); ++j) {
    const bool slides = j >= unknowns_.size();
    const Unknown& x = slides ? sliding_[j - unknowns_.size()] : unknowns_[j];
    double* const p = step_.data() + x.row;
    if (slides || !x.tangent) p[0] += z_[j];
    if (x.tangent) {
      p[1] += x.t1 * z_[j];
      p[2] += x.t2 * z_[j];
    }
  }
  std::ranges::fill(step_u_, 0.0);
  for (int r = 0; r < n_; ++r) {
    double& step = step_[static_cast<std::size_t>(r)];
    step -= p_[static_cast<std::size_t>(r)];
    if (step != 0)
      for (int k = 0; k < n_; ++k) step_u_[static_cast<std::size_t>(k)] += column(r)[k] * step;
  }
  return std::ranges::all_of(step_, is_finite);
}

/// Makes one Newton step, shortened until it reduces the residual. @param norm squared norm of the residual before and after the step
/// @return false if there is no finite step
bool DenseIsland::newton_step(const IslandRows& island, double& norm) {
  if (!find_step(island)) return false;
  old_p_ = p_;
  old_u_ = u_;
  double length = 1, next = 0;
  for (int halvings = 0;; ++halvings, length *= 0.5) {
    for (std::size_t r = 0; r < p_.size(); ++r) {
      p_[r] = old_p_[r] + length * step_[r];
      u_[r] = old_u_[r] + length * step_u_[r];
    }
    next = residual(island);
    if (next < norm * (1 - 0.2 * length) || halvings == max_halvings) break;
  }
  norm = next;
  return true;
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
      case RowKind::roll: break;
    }
  }
}

/// Newton steps until the residual is below the tolerance. Keeps the impulses in best_p_ if they are the best so far.
void DenseIsland::solve_by_newton(const IslandRows& island, double augmentation, double later, double tolerance, DenseResult& result) {
  augmentation_ = augmentation;
  double norm = residual(island);
  for (int k = 1; k <= max_newton_steps && !result.converged && newton_step(island, norm); ++k) {
    ++result.newton_steps;
    if (max_residual_ < result.change) {
      result.change = max_residual_;
      best_p_ = p_;
      result.converged = max_residual_ < tolerance;
    }
    if (2 * k == max_newton_steps && later != augmentation) {
      augmentation_ = later;
      norm = residual(island);
    }
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
