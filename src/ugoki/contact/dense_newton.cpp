// The Newton step of DenseIsland: the natural map of the laws, the unknowns of its classes, and their linear equations (dense_island.h).

#include <algorithm>
#include <cmath>

#include "ugoki/contact/contact_law.h"
#include "ugoki/contact/dense_island.h"
#include "ugoki/contact/natural_map.h"
#include "ugoki/contact/solver_kernels.h"

namespace ugoki::contact {
namespace {

/// Maximum number of halvings of a Newton step that does not reduce the residual.
constexpr int max_halvings = 5;
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

}  // namespace

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
    for (int r = 1; r < 3; ++r)
      unknowns_.push_back({row + r, false, 0, 0, NaturalMap::regularization * B_t, NaturalMap::regularization * B_t * p[r]});
    return;
  }
  const double d1 = x1 / size, d2 = x2 / size;
  fixed[1] = b.mu * b.impact_impulse * d1;
  fixed[2] = b.mu * b.impact_impulse * d2;
  if (x_n > 0) sliding_.push_back({row, true, b.mu * d1, b.mu * d2, soft, 0});
  unknowns_.push_back({row, true, -d2, d1, std::max(metric * (size / radius - 1), NaturalMap::regularization * B_t), 0});
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
        if (p[0] - u[0] / (augmentation_ * b.B[0]) > 0) add_plain(local_[i], NaturalMap::limit_regularization * b.B[0]);
        break;
      case RowKind::grip:
        for (int r = 0; r < 3; ++r) add_plain(local_[i] + r, NaturalMap::limit_regularization * b.size * b.size);
        break;
      case RowKind::friction: {
        const double x = p[0] - u[0] / (augmentation_ * b.B[0]);
        fixed[0] = std::clamp(x, -b.bound, b.bound);
        if (std::fabs(x) < b.bound) add_plain(local_[i], NaturalMap::regularization * b.B[0]);
        break;
      }
      case RowKind::roll: {
        double x[3];
        const double radius = roll_projection(b, p, u, augmentation_ * b.size * b.size, normal_impulse(i), x);
        std::copy_n(x, 3, fixed);
        if (radius < 1)
          for (int r = 0; r < 3; ++r) add_plain(local_[i] + r, NaturalMap::regularization * b.B[r]);
        break;
      }
    }
  }
}

/// Computes the natural map at p and u. @return its squared norm; sets max_residual_
double DenseIsland::residual(const IslandRows& island) {
  NaturalMap map{augmentation_};
  for (std::size_t i = 0; i < island.order.size(); ++i) {
    const RowBlock& b = island.blocks[static_cast<std::size_t>(island.order[i])];
    map.add(b, b.kind == RowKind::roll ? normal_impulse(i) : 0, p_.data() + local_[i], u_.data() + local_[i]);
  }
  max_residual_ = map.maximum;
  return map.square;
}

/// Writes the linear equations of the unknowns to A_ and S_. With X the rows of an unknown, E those of its equation and B the inverse
/// inertia, an entry is E B X. E = X except for the normal impulses of sliding contacts, whose equation reads only the normal row.
void DenseIsland::make_equations() {
  const std::size_t n = unknowns_.size(), m = sliding_.size(), width = n + 2 * m + 1;
  std::ranges::copy(target_, fixed_u_.begin());
  solver_kernels().add_product(B_.data(), stride_, n_, fixed_.data(), fixed_u_.data());
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
  const std::size_t n = unknowns_.size(), m = sliding_.size(), width = n + 2 * m + 1;
  z_.resize(n + m);
  inverse_.resize(n);
  solver_kernels().eliminate(A_.data(), static_cast<int>(n), static_cast<int>(width), inverse_.data());
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
  for (std::size_t r = 0; r < step_.size(); ++r) step_[r] -= p_[r];
  solver_kernels().add_product(B_.data(), stride_, n_, step_.data(), step_u_.data());
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

}  // namespace ugoki::contact
