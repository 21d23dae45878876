#include "ugoki/contact/dense_island.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "ugoki/contact/contact_law.h"

namespace ugoki::contact {
namespace {

/// The rows of a contact side by side: normal, two tangents, unused. Lanes do not interact, so narrower registers give the same bits.
typedef double Four __attribute__((vector_size(32)));

/// Sweeps that classify the blocks. With 2, 3, 4, 6 or 8 sweeps a step of a falling humanoid needs as many Newton steps (1.2 to 1.5).
constexpr int classifying_sweeps = 2;
/// Newton steps before the island is handed over. More steps alternate between the same classes.
constexpr int max_newton_steps = 5;
/// Regularization of rows that may depend on each other (friction of redundant contacts), as a fraction of their inverse inertia. It is
/// in Newton's matrix only, not in the law. With 1e-7 and 1e-2 a falling humanoid needs half as many steps again.
constexpr double regularization = 1e-4;
/// The same for limits, which depend on other rows only when a chain is jammed.
constexpr double limit_regularization = 1e-7;
/// A friction impulse nearer to its bound than this fraction slides.
constexpr double at_bound = 1 - 1e-9;

/// Solves A x = b by elimination with row exchanges. @param A [n][n + 1], the last column is b; destroyed @return false if A is singular
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

DenseIsland::DenseIsland() {
  constexpr std::size_t n = max_rows, depth = 64;
  local_.reserve(n);
  impact_impulse_.reserve(n);
  packed_at_.reserve(2 * n);
  packed_.reserve(4 * depth * n);
  B_.reserve(n * (n + 8));
  for (std::vector<double>* x : {&target_, &p_, &u_, &best_p_, &fixed_, &fixed_u_, &made_u_, &z_}) x->reserve(n);
  unknowns_.reserve(n);
  A_.reserve(n * (n + 1));
}

/// Copies the island's rows into lanes.
void DenseIsland::pack(const IslandRows& island) {
  const std::size_t count = island.order.size();
  local_.resize(count);
  impact_impulse_.assign(count, 0.0);
  packed_at_.resize(2 * count);
  packed_.clear();
  n_ = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const RowBlock& b = island.blocks[static_cast<std::size_t>(island.order[i])];
    if (b.kind == RowKind::roll) impact_impulse_[i] = island.blocks[static_cast<std::size_t>(b.contact_block)].impact_impulse;
    local_[i] = n_;
    n_ += b.rows;
    for (int s = 0; s < b.segments; ++s) {
      const RowSegment& x = island.segments[static_cast<std::size_t>(b.first_segment + s)];
      const std::size_t at = packed_.size();
      packed_at_[2 * i + static_cast<std::size_t>(s)] = static_cast<int>(at);
      packed_.resize(at + 4 * static_cast<std::size_t>(x.length), 0.0);
      for (int r = 0; r < b.rows; ++r) {
        const double* const y = island.rows + x.offset + r * x.length;
        for (int e = 0; e < x.length; ++e) packed_[at + 4 * static_cast<std::size_t>(e) + static_cast<std::size_t>(r)] = y[e];
      }
    }
  }
  stride_ = (n_ + 7) & ~3;
}

/// B = Y Y^T. Two chains of one system share their DOFs from the root up to the first difference.
void DenseIsland::make_matrix(const IslandRows& island) {
  const auto stride = static_cast<std::size_t>(stride_);
  B_.assign(static_cast<std::size_t>(n_) * stride, 0.0);
  const std::size_t count = island.order.size();
  for (std::size_t i = 0; i < count; ++i) {
    const RowBlock& a = island.blocks[static_cast<std::size_t>(island.order[i])];
    for (std::size_t j = 0; j <= i; ++j) {
      const RowBlock& b = island.blocks[static_cast<std::size_t>(island.order[j])];
      Four sum[3] = {};
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
          const double* const X = packed_.data() + packed_at_[2 * i + static_cast<std::size_t>(sa)];
          const double* const Y = packed_.data() + packed_at_[2 * j + static_cast<std::size_t>(sb)];
          for (int e = 0; e < shared; ++e) {
            Four side;
            std::memcpy(&side, Y + 4 * e, sizeof side);
            for (int r = 0; r < a.rows; ++r) sum[r] += X[4 * e + r] * side;
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

/// u = target + B p.
void DenseIsland::update_velocities() {
  std::ranges::copy(target_, u_.begin());
  for (int r = 0; r < n_; ++r)
    if (const double p = p_[static_cast<std::size_t>(r)]; p != 0)
      for (int k = 0; k < n_; ++k) u_[static_cast<std::size_t>(k)] += column(r)[k] * p;
}

/// Solves each block with the others fixed. @return m/s: maximum change of a velocity
double DenseIsland::sweep(const IslandRows& island, double compliance, bool forward) {
  const std::size_t count = island.order.size();
  double maximum = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = forward ? k : count - 1 - k;
    const RowBlock& b = island.blocks[static_cast<std::size_t>(island.order[i])];
    double* const p = p_.data() + local_[i];
    double next[3], change[3] = {0, 0, 0};
    next_impulse(b, u_.data() + local_[i], p, compliance, b.kind == RowKind::roll ? normal_impulse(i) : 0, next);
    for (int r = 0; r < b.rows; ++r) {
      change[r] = next[r] - p[r];
      p[r] = next[r];
      maximum = std::max(maximum, std::fabs(change[r]) * b.B[r] * b.lever);
    }
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

/// Unknowns of a contact whose class the last sweep has left in p and u.
void DenseIsland::add_contact(const RowBlock& b, int row, double compliance) {
  const double* const p = p_.data() + row;
  const double* const u = u_.data() + row;
  double* const fixed = fixed_.data() + row;
  if (p[0] <= 0 && b.impact_impulse == 0) return;  // open
  const bool pressed = p[0] > 0;
  const double soft = compliance * b.B[0], B_t = std::max(b.B[1], b.B[2]);
  const double radius = b.mu * (p[0] + b.impact_impulse);
  if (pressed) fixed[0] = 0;
  if (p[1] * p[1] + p[2] * p[2] < at_bound * radius * radius) {  // sticks
    if (pressed) unknowns_.push_back({row, Role::plain, 0, 0, soft, 0});
    for (int r = 1; r < 3; ++r) {
      fixed[r] = 0;
      unknowns_.push_back({row + r, Role::plain, 0, 0, regularization * B_t, regularization * B_t * p[r]});
    }
    return;
  }
  if (!(radius > 0)) {  // no friction
    if (pressed) unknowns_.push_back({row, Role::plain, 0, 0, soft, 0});
    return;
  }
  const double x1 = p[1] - u[1] / B_t, x2 = p[2] - u[2] / B_t, size = std::sqrt(x1 * x1 + x2 * x2);
  const double d1 = x1 / size, d2 = x2 / size, slip = std::max(0.0, (size - radius) * B_t);
  fixed[1] = b.mu * b.impact_impulse * d1;
  fixed[2] = b.mu * b.impact_impulse * d2;
  if (pressed) unknowns_.push_back({row, Role::sliding_normal, b.mu * d1, b.mu * d2, soft, 0});
  unknowns_.push_back({row, Role::sliding_side, -d2, d1, std::max(slip / radius, regularization * B_t), 0});
}

void DenseIsland::collect_unknowns(const IslandRows& island, double compliance) {
  unknowns_.clear();
  fixed_ = p_;
  const auto add_plain = [&](int row, double diagonal) {
    const auto at = static_cast<std::size_t>(row);
    unknowns_.push_back({row, Role::plain, 0, 0, diagonal, diagonal * p_[at]});
    fixed_[at] = 0;
  };
  for (std::size_t i = 0; i < island.order.size(); ++i) {
    const RowBlock& b = island.blocks[static_cast<std::size_t>(island.order[i])];
    const double* const p = p_.data() + local_[i];
    switch (b.kind) {
      case RowKind::contact: add_contact(b, local_[i], compliance); break;
      case RowKind::limit:
        if (p[0] > 0) add_plain(local_[i], limit_regularization * b.B[0]);
        break;
      case RowKind::friction:
        if (std::fabs(p[0]) < b.bound) add_plain(local_[i], regularization * b.B[0]);
        break;
      case RowKind::roll: {
        const double bound = b.mu * normal_impulse(i);
        if (p[0] * p[0] + p[1] * p[1] + p[2] * p[2] < at_bound * bound * bound)
          for (int r = 0; r < 3; ++r) add_plain(local_[i] + r, regularization * b.B[r]);
        break;
      }
    }
  }
}

/// The linear equations of the unknowns, in A_.
void DenseIsland::make_equations() {
  const std::size_t m = unknowns_.size(), width = m + 1;
  std::ranges::copy(target_, fixed_u_.begin());
  for (int r = 0; r < n_; ++r)
    if (const double p = fixed_[static_cast<std::size_t>(r)]; p != 0)
      for (int k = 0; k < n_; ++k) fixed_u_[static_cast<std::size_t>(k)] += column(r)[k] * p;
  const auto read = [](const Unknown& equation, const double* u) {
    return equation.role == Role::sliding_side ? equation.t1 * u[equation.row + 1] + equation.t2 * u[equation.row + 2] : u[equation.row];
  };
  A_.resize(m * width);
  z_.resize(m);
  for (std::size_t j = 0; j < m; ++j) {
    const Unknown& x = unknowns_[j];
    const double* u = column(x.row);
    if (x.role != Role::plain) {
      const double normal = x.role == Role::sliding_normal ? 1 : 0;
      const double *t1 = column(x.row + 1), *t2 = column(x.row + 2);
      for (int k = 0; k < n_; ++k) made_u_[static_cast<std::size_t>(k)] = normal * u[k] + x.t1 * t1[k] + x.t2 * t2[k];
      u = made_u_.data();
    }
    for (std::size_t i = 0; i < m; ++i) A_[i * width + j] = read(unknowns_[i], u);
    A_[j * width + j] += x.diagonal;
  }
  for (std::size_t i = 0; i < m; ++i) A_[i * width + m] = unknowns_[i].rest - read(unknowns_[i], fixed_u_.data());
}

/// One Newton step from p and u as the last sweep left them. @return false if its matrix is singular
bool DenseIsland::newton_step(const IslandRows& island, double compliance) {
  collect_unknowns(island, compliance);
  if (unknowns_.empty()) return false;
  make_equations();
  if (!solve_dense(A_.data(), unknowns_.size(), z_.data())) return false;
  p_ = fixed_;
  for (std::size_t j = 0; j < unknowns_.size(); ++j) {
    const Unknown& x = unknowns_[j];
    double* const p = p_.data() + x.row;
    if (x.role != Role::sliding_side) p[0] += z_[j];
    if (x.role != Role::plain) {
      p[1] += x.t1 * z_[j];
      p[2] += x.t2 * z_[j];
    }
  }
  return std::ranges::all_of(p_, is_finite);
}

/// Moves each impulse into the bounds of its law; rolling resistance is left to the next sweep.
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

DenseResult DenseIsland::solve(const IslandRows& island, double compliance, double tolerance) {
  DenseResult result;
  pack(island);
  make_matrix(island);
  for (std::vector<double>* x : {&target_, &p_, &u_, &fixed_u_, &made_u_}) x->resize(static_cast<std::size_t>(n_));
  for (std::size_t i = 0; i < island.order.size(); ++i) {
    const RowBlock& b = island.blocks[static_cast<std::size_t>(island.order[i])];
    std::copy_n(island.target + b.row, b.rows, target_.begin() + local_[i]);
    std::copy_n(island.p + b.row, b.rows, p_.begin() + local_[i]);
  }
  update_velocities();
  best_p_ = p_;
  result.change = HUGE_VAL;
  const auto sweep_and_compare = [&](bool forward) {
    const double change = sweep(island, compliance, forward);
    ++result.sweeps;
    if (change < result.change) {
      result.change = change;
      best_p_ = p_;
    }
    result.converged = change < tolerance;
  };
  for (int k = 0; k < classifying_sweeps && !result.converged; ++k) sweep_and_compare(k % 2 == 0);
  for (int k = 0; k < max_newton_steps && !result.converged && newton_step(island, compliance); ++k) {
    ++result.newton_steps;
    project(island);
    update_velocities();
    sweep_and_compare(k % 2 == 0);
  }
  for (std::size_t i = 0; i < island.order.size(); ++i) {
    const RowBlock& b = island.blocks[static_cast<std::size_t>(island.order[i])];
    std::copy_n(best_p_.begin() + local_[i], b.rows, island.p + b.row);
  }
  return result;
}

}  // namespace ugoki::contact
