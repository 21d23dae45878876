#include "ugoki/control/quadratic_program.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/check.h"

namespace ugoki::control {
namespace {

constexpr int max_iterations = 60;

/// Grows `v` to at least `size` elements. Existing memory is kept, so that a later begin() of the same size allocates nothing.
void ensure(std::vector<double>& v, std::size_t size) {
  if (v.size() < size) v.resize(size);
}

/// Replaces the upper triangle of the symmetric positive definite matrix A [n * stride] by U with A = U^T U. If rounding made a pivot
/// non-positive, it is replaced by a large number, which removes this row from the solution.
void factor(double* A, std::size_t n, std::size_t stride) {
  for (std::size_t k = 0; k < n; ++k) {
    double* row = A + k * stride;
    const double pivot = row[k];
    const double d = pivot > 1e-300 ? std::sqrt(pivot) : 1e150;
    row[k] = d;
    const double inverse = 1 / d;
    for (std::size_t j = k + 1; j < n; ++j) row[j] *= inverse;
    for (std::size_t i = k + 1; i < n; ++i) {
      const double f = row[i];
      if (f == 0) continue;
      double* to = A + i * stride;
      for (std::size_t j = i; j < n; ++j) to[j] -= f * row[j];
    }
  }
}
/// Solves U^T x = b; b is replaced by x.
void solve_lower(const double* U, std::size_t n, std::size_t stride, double* b) {
  for (std::size_t k = 0; k < n; ++k) {
    const double* row = U + k * stride;
    const double x = b[k] / row[k];
    b[k] = x;
    if (x == 0) continue;
    for (std::size_t j = k + 1; j < n; ++j) b[j] -= row[j] * x;
  }
}
/// Solves U x = b; b is replaced by x.
void solve_upper(const double* U, std::size_t n, std::size_t stride, double* b) {
  for (std::size_t k = n; k-- > 0;) {
    const double* row = U + k * stride;
    double sum = b[k];
    for (std::size_t j = k + 1; j < n; ++j) sum -= row[j] * b[j];
    b[k] = sum / row[k];
  }
}

}  // namespace

void QuadraticProgram::begin(int unknowns, int loads, double load_cost) {
  UGOKI_CHECK(unknowns > 0 && loads >= 0 && load_cost > 0);
  n_ = static_cast<std::size_t>(unknowns);
  m_ = static_cast<std::size_t>(loads);
  eps_ = load_cost;
  rows_ = balances_ = eliminated_ = 0;
  factored_ = false;
  iterations_ = 0;
  ensure(weights_, n_);
  ensure(centre_, n_);
  ensure(x_, n_);
  ensure(beta_, m_);
  ensure(edge_, m_);
  ensure(trial_edge_, m_);
  std::fill_n(weights_.begin(), n_, 1.0);
  std::fill_n(centre_.begin(), n_, 0.0);
}

void QuadraticProgram::reserve(int unknowns, int loads, int equations, int balances) {
  begin(unknowns, loads, 1);
  for (int r = 0; r < equations; ++r) add_equation(0, 1)[0] = 1;
  for (int r = 0; r < balances; ++r) add_balance(0, 0, 1).c[0] = 1;
  (void)solve();
}

std::span<double> QuadraticProgram::add_equation(double target, double softness) {
  UGOKI_CHECK(!factored_ && softness >= 0);
  ensure(c_, (rows_ + 1) * n_);
  ensure(t_, rows_ + 1);
  ensure(sigma_, rows_ + 1);
  t_[rows_] = target;
  sigma_[rows_] = softness;
  const std::span<double> row(c_.data() + rows_ * n_, n_);
  std::ranges::fill(row, 0.0);
  ++rows_;
  return row;
}

QuadraticProgram::Balance QuadraticProgram::add_balance(double lower, double upper, double softness) {
  UGOKI_CHECK(softness >= 0 && lower <= upper);
  const std::size_t r = balances_++;
  ensure(bc_, balances_ * n_);
  ensure(bg_, balances_ * m_);
  for (std::vector<double>* v : {&lower_, &upper_, &bs_, &z_, &base_, &value_, &step_, &trial_}) ensure(*v, balances_);
  if (sign_.size() < balances_) sign_.resize(balances_);
  if (free_.size() < balances_) free_.resize(balances_);
  lower_[r] = lower;
  upper_[r] = upper;
  bs_[r] = softness;
  z_[r] = 0;
  const Balance b{{bc_.data() + r * n_, n_}, {bg_.data() + r * m_, m_}};
  std::ranges::fill(b.c, 0.0);
  std::ranges::fill(b.g, 0.0);
  return b;
}

void QuadraticProgram::factor_equations() {
  ensure(ct_, n_ * rows_);
  ensure(u_, rows_ * rows_);
  ensure(y_, rows_);
  std::fill_n(u_.begin(), rows_ * rows_, 0.0);
  for (std::size_t r = 0; r < rows_; ++r) {
    double sum = t_[r];
    for (std::size_t i = 0; i < n_; ++i) sum -= c_[r * n_ + i] * centre_[i];
    y_[r] = sum;
  }
  for (std::size_t i = 0; i < n_; ++i) {
    const double scale = 1 / std::sqrt(weights_[i]);
    double* column = ct_.data() + i * rows_;
    for (std::size_t r = 0; r < rows_; ++r) column[r] = c_[r * n_ + i] * scale;
    for (std::size_t r = 0; r < rows_; ++r) {
      const double f = column[r];
      if (f == 0) continue;
      double* to = u_.data() + r * rows_;
      for (std::size_t j = r; j < rows_; ++j) to[j] += f * column[j];
    }
  }
  for (std::size_t r = 0; r < rows_; ++r) {
    double& d = u_[r * rows_ + r];
    d += sigma_[r] + 1e-13 * d;  // small addition, because rows may be linearly dependent up to rounding
  }
  factor(u_.data(), rows_, rows_);
  solve_lower(u_.data(), rows_, rows_, y_.data());
  factored_ = true;
}

void QuadraticProgram::eliminate(std::size_t r) {
  if (stride_ < balances_) {  // enlarge the core's matrix, keeping its values
    const std::size_t stride = std::max(balances_, 2 * stride_);
    std::vector<double> k(stride * stride, 0.0);
    for (std::size_t i = 0; i < r; ++i)
      for (std::size_t j = 0; j < r; ++j) k[i * stride + j] = k_[i * stride_ + j];
    k_ = std::move(k);
    stride_ = stride;
    ensure(h_, stride * stride);
  }
  ensure(v_, balances_ * rows_);
  const double* c = bc_.data() + r * n_;
  double* v = v_.data() + r * rows_;
  std::fill_n(v, rows_, 0.0);
  double base = 0;
  for (std::size_t i = 0; i < n_; ++i) {
    if (c[i] == 0) continue;
    base += c[i] * centre_[i];
    const double f = c[i] / std::sqrt(weights_[i]);
    const double* column = ct_.data() + i * rows_;
    for (std::size_t j = 0; j < rows_; ++j) v[j] += f * column[j];
  }
  solve_lower(u_.data(), rows_, rows_, v);
  for (std::size_t j = 0; j < rows_; ++j) base += v[j] * y_[j];
  base_[r] = base;
  for (std::size_t q = 0; q <= r; ++q) {
    const double *d = bc_.data() + q * n_, *w = v_.data() + q * rows_;
    double sum = 0;
    for (std::size_t i = 0; i < n_; ++i) sum += c[i] * d[i] / weights_[i];
    for (std::size_t j = 0; j < rows_; ++j) sum -= v[j] * w[j];
    k_[q * stride_ + r] = k_[r * stride_ + q] = q == r ? sum + bs_[r] + 1e-13 * std::fabs(sum) : sum;
  }
}

/// Value of the objective of the core (the problem of the balances, see quadratic_program.h). @param edge [m, out] G^T z
double QuadraticProgram::objective(std::span<const double> z, std::span<double> edge) const {
  double value = 0;
  std::ranges::fill(edge, 0.0);
  for (std::size_t r = 0; r < balances_; ++r) {
    if (z[r] == 0) continue;
    double sum = base_[r];
    for (std::size_t q = 0; q < balances_; ++q) sum += 0.5 * k_[r * stride_ + q] * z[q];
    value += z[r] * (sum - (z[r] > 0 ? lower_[r] : upper_[r]));
    const double* g = bg_.data() + r * m_;
    for (std::size_t k = 0; k < m_; ++k) edge[k] += g[k] * z[r];
  }
  for (std::size_t k = 0; k < m_; ++k)
    if (edge[k] > 0) value += 0.5 * edge[k] * edge[k] / eps_;
  return value;
}

/// Newton step for the first `count` balances of free_.
void QuadraticProgram::find_step(std::size_t count) {
  for (std::size_t a = 0; a < count; ++a) {
    const auto r = static_cast<std::size_t>(free_[a]);
    step_[a] = -value_[r];
    for (std::size_t b = a; b < count; ++b) h_[a * stride_ + b] = k_[r * stride_ + static_cast<std::size_t>(free_[b])];
  }
  for (std::size_t k = 0; k < m_; ++k) {
    if (!(edge_[k] > 0)) continue;
    for (std::size_t a = 0; a < count; ++a) {
      const double f = bg_[static_cast<std::size_t>(free_[a]) * m_ + k] / eps_;
      if (f == 0) continue;
      for (std::size_t b = a; b < count; ++b) h_[a * stride_ + b] += f * bg_[static_cast<std::size_t>(free_[b]) * m_ + k];
    }
  }
  factor(h_.data(), count, stride_);
  solve_lower(h_.data(), count, stride_, step_.data());
  solve_upper(h_.data(), count, stride_, step_.data());
}

/// Sets trial_ to the minimum of the objective on the line from z_ along step_, up to the point where the first multiplier becomes zero.
void QuadraticProgram::search_line(std::size_t count) {
  double end = 1, slope = 0, curvature = 0;  // of the objective without its loads, at z_ and along the step
  std::size_t first = count;
  std::fill_n(trial_edge_.begin(), m_, 0.0);  // change of the edges along the step
  for (std::size_t a = 0; a < count; ++a) {
    const auto r = static_cast<std::size_t>(free_[a]);
    if (lower_[r] < upper_[r] && (z_[r] + end * step_[a]) * sign_[r] < 0) {
      end = -z_[r] / step_[a];
      first = a;
    }
    slope += value_[r] * step_[a];
    for (std::size_t b = 0; b < count; ++b) curvature += step_[a] * k_[r * stride_ + static_cast<std::size_t>(free_[b])] * step_[b];
    for (std::size_t k = 0; k < m_; ++k) trial_edge_[k] += bg_[r * m_ + k] * step_[a];
  }
  for (std::size_t k = 0; k < m_; ++k)
    if (edge_[k] > 0) slope -= edge_[k] * trial_edge_[k] / eps_;
  const auto slope_at = [&](double t) {
    double sum = slope + curvature * t;
    for (std::size_t k = 0; k < m_; ++k) sum += std::max(0.0, edge_[k] + t * trial_edge_[k]) * trial_edge_[k] / eps_;
    return sum;
  };
  double low = 0, high = end;
  if (slope_at(end) > 0) {
    first = count;
    for (int k = 0; k < 50; ++k) (slope_at(0.5 * (low + high)) > 0 ? high : low) = 0.5 * (low + high);
  }
  std::copy_n(z_.begin(), balances_, trial_.begin());
  for (std::size_t a = 0; a < count; ++a) {
    const auto r = static_cast<std::size_t>(free_[a]);
    trial_[r] = a == first ? 0 : z_[r] + high * step_[a];
  }
}

bool QuadraticProgram::solve(std::span<const double> start) {
  if (!factored_) factor_equations();
  for (; eliminated_ < balances_; ++eliminated_) {
    eliminate(eliminated_);
    if (eliminated_ < start.size()) z_[eliminated_] = start[eliminated_];
  }
  const std::size_t nb = balances_;
  const std::span<double> z(z_.data(), nb), trial(trial_.data(), nb), edge(edge_.data(), m_), trial_edge(trial_edge_.data(), m_);
  double scale = 1e-12;
  for (std::size_t r = 0; r < nb; ++r) {
    if (lower_[r] < upper_[r]) z[r] = std::isinf(z[r] > 0 ? lower_[r] : upper_[r]) ? 0 : z[r];
    scale = std::max(scale, std::fabs(base_[r]));
    if (lower_[r] == upper_[r]) scale = std::max(scale, std::fabs(lower_[r]));
  }
  double value = objective(z, edge);
  bool converged = false;
  for (iterations_ = 0; iterations_ < max_iterations; ++iterations_) {
    // Compute c x + g beta + s minus its bound for each balance, and find the balances whose multipliers are free to change.
    std::size_t count = 0;
    residual_ = 0;
    for (std::size_t r = 0; r < nb; ++r) {
      double sum = base_[r];
      for (std::size_t q = 0; q < nb; ++q) sum += k_[r * stride_ + q] * z[q];
      const double* g = bg_.data() + r * m_;
      for (std::size_t k = 0; k < m_; ++k)
        if (edge[k] > 0) sum += g[k] * edge[k] / eps_;
      int sign = z[r] > 0 ? 1 : z[r] < 0 ? -1 : sum < lower_[r] ? 1 : sum > upper_[r] ? -1 : 0;
      if (lower_[r] == upper_[r] && sign == 0) sign = 1;
      sign_[r] = sign;
      value_[r] = sign == 0 ? 0 : sum - (sign > 0 ? lower_[r] : upper_[r]);
      residual_ = std::max(residual_, std::fabs(value_[r]));
      if (sign != 0) free_[count++] = static_cast<int>(r);
    }
    if (residual_ <= 1e-9 * scale) {
      converged = true;
      break;
    }
    // An inequality whose multiplier is zero and would get the wrong sign is not free: the others would move as if it moved with them.
    for (std::size_t before = count + 1; count < before;) {
      before = count;
      find_step(count);
      std::size_t kept = 0;
      for (std::size_t a = 0; a < count; ++a) {
        const auto r = static_cast<std::size_t>(free_[a]);
        if (lower_[r] < upper_[r] && z[r] == 0 && step_[a] * sign_[r] < 0) continue;
        step_[kept] = step_[a];
        free_[kept++] = free_[a];
      }
      count = kept;
    }
    // The full step with the multipliers projected to their sign comes first. If it does not decrease the objective enough, the minimum
    // along the straight step does, up to the point where the first multiplier becomes zero.
    double decrease = 0;  // predicted by the linear model
    std::ranges::copy(z, trial.begin());
    for (std::size_t a = 0; a < count; ++a) {
      const auto r = static_cast<std::size_t>(free_[a]);
      trial[r] = z[r] + step_[a];
      if (lower_[r] < upper_[r] && trial[r] * sign_[r] < 0) trial[r] = 0;
      decrease += value_[r] * (trial[r] - z[r]);
    }
    double next_value = objective(trial, trial_edge);
    if (next_value > value + 1e-4 * decrease) {
      search_line(count);
      next_value = objective(trial, trial_edge);
    }
    const bool moved = next_value < value;
    if (moved) {
      value = next_value;
      std::ranges::copy(trial, z.begin());
      std::ranges::copy(trial_edge, edge.begin());
    }
    if (!moved) {  // rounding errors prevent a further decrease
      converged = residual_ <= 1e-6 * scale;
      break;
    }
  }
  recover();
  return converged;
}

void QuadraticProgram::recover() {
  // Multipliers z1 of the equations: U^T U z1 = (t - C x0) - C W^-1 c2^T z2
  ensure(all_z_, rows_);
  for (std::size_t j = 0; j < rows_; ++j) all_z_[j] = y_[j];
  for (std::size_t r = 0; r < balances_; ++r)
    for (std::size_t j = 0; j < rows_; ++j) all_z_[j] -= v_[r * rows_ + j] * z_[r];
  solve_upper(u_.data(), rows_, rows_, all_z_.data());
  for (std::size_t i = 0; i < n_; ++i) {
    double sum = 0;
    const double* column = ct_.data() + i * rows_;
    for (std::size_t j = 0; j < rows_; ++j) sum += column[j] * all_z_[j];
    sum *= std::sqrt(weights_[i]);
    for (std::size_t r = 0; r < balances_; ++r) sum += bc_[r * n_ + i] * z_[r];
    x_[i] = centre_[i] + sum / weights_[i];
  }
  for (std::size_t k = 0; k < m_; ++k) beta_[k] = edge_[k] > 0 ? edge_[k] / eps_ : 0;
}

double QuadraticProgram::slack(int balance) const {
  const auto r = static_cast<std::size_t>(balance);
  return bs_[r] * z_[r];
}

}  // namespace ugoki::control
