// Newton's method on the whitened velocities w of an island (velocity_solver.h). For fixed p^ it solves
//   F(w) = w - sum Y^T p(u(w)) = 0,   p = the law's projection of p^ - u / R   (augmented Lagrangian, p^ = the last impulses)
// Y are the whitened rows of a block, u its velocity. R is a small fraction of the block's own inverse inertia. It only sets how fast p^
// converges; at the solution p = p^ it cancels.
// If only a subset of an island's systems is solved, the contribution of the blocks outside the subset is subtracted from w in F; their
// impulses are constant.
// H = dF/dw = 1 + sum Y^T G Y with G = -dp/du. The coupling of a sliding contact's friction to its normal impulse is left out, so that H is
// symmetric and positive definite. F is then the gradient of a convex function of w, the merit, and a line search along the Newton step
// looks for the zero of its slope.

#include <algorithm>
#include <cmath>
#include <limits>

#include "ugoki/contact/velocity_solver.h"

namespace ugoki::contact {
namespace {
// First and minimum value of R, relative to a block's inverse inertia. Each update of p^ divides R by ten.
constexpr double first_regularization = 1e-3, min_regularization = 1e-6;
constexpr int max_updates = 8;
constexpr double slope_ratio = 0.1;  // the line search ends when the slope of the merit has fallen to this fraction
constexpr int max_trials = 8;        // of the line search
}  // namespace

/// Row of the Newton matrix for entry e of a segment. The DOFs deepest in a system's tree have the lowest rows, so that branches do not
/// fill in entries between each other.
int VelocitySolver::matrix_row(const RowSegment& x, int e) const {
  const auto s = static_cast<std::size_t>(x.system);
  return local_[s] + first_[s + 1] - first_[s] - 1 - (x.index ? x.index[e] : e);
}

/// Orders the island's systems breadth-first, from the system that a first search reaches last (Cuthill-McKee), and sizes the envelope of
/// the Newton matrix.
/// @return false if `steps` Newton steps would cost more than budget_
bool VelocitySolver::order_systems(const Island& island, int steps) {
  const auto segment = [&](const RowBlock& b, int k) -> const RowSegment& {
    return segments_[static_cast<std::size_t>(b.first_segment + k)];
  };
  const auto block = [&](int i) -> const RowBlock& {
    return blocks_[static_cast<std::size_t>(order_[static_cast<std::size_t>(island.first_block + i)])];
  };
  const std::span<const int> members =
      std::span(members_).subspan(static_cast<std::size_t>(island.first_system), static_cast<std::size_t>(island.systems));
  for (const int s : members) neighbour_first_[static_cast<std::size_t>(s)] = 0;
  for (int i = 0; i < island.blocks; ++i) {
    const RowBlock& b = block(i);
    if (b.segments < 2) continue;
    ++neighbour_first_[static_cast<std::size_t>(segment(b, 0).system)];
    ++neighbour_first_[static_cast<std::size_t>(segment(b, 1).system)];
  }
  int total = 0;
  for (const int s : members) {
    total += neighbour_first_[static_cast<std::size_t>(s)];
    neighbour_first_[static_cast<std::size_t>(s)] = total;  // end of the system's neighbours; the next loop fills them backwards
    cursor_[static_cast<std::size_t>(s)] = total;
  }
  neighbours_.resize(static_cast<std::size_t>(total));
  for (int i = island.blocks - 1; i >= 0; --i) {
    const RowBlock& b = block(i);
    if (b.segments < 2) continue;
    const int x = segment(b, 0).system, y = segment(b, 1).system;
    neighbours_[static_cast<std::size_t>(--neighbour_first_[static_cast<std::size_t>(x)])] = y;
    neighbours_[static_cast<std::size_t>(--neighbour_first_[static_cast<std::size_t>(y)])] = x;
  }
  for (const int s : members) local_[static_cast<std::size_t>(s)] = -1;
  // Appends all systems connected with `from` to queue_. @return the end of the queue
  const auto search = [&](int from, std::size_t head) {
    std::size_t tail = head;
    queue_[tail++] = from;
    local_[static_cast<std::size_t>(from)] = 0;
    while (head < tail) {
      const auto s = static_cast<std::size_t>(queue_[head++]);
      for (int k = neighbour_first_[s]; k < cursor_[s]; ++k) {
        const int next = neighbours_[static_cast<std::size_t>(k)];
        if (local_[static_cast<std::size_t>(next)] >= 0) continue;
        local_[static_cast<std::size_t>(next)] = 0;
        queue_[tail++] = next;
      }
    }
    return tail;
  };
  std::size_t ordered = 0;
  for (const int s : members) {  // one iteration for a complete island; a subset may be disconnected
    if (local_[static_cast<std::size_t>(s)] >= 0) continue;
    const std::size_t end = search(s, ordered);
    for (std::size_t k = ordered; k < end; ++k) local_[static_cast<std::size_t>(queue_[k])] = -1;
    ordered = search(queue_[end - 1], ordered);
  }
  int n = 0;
  for (std::size_t k = 0; k < members.size(); ++k) {
    const auto s = static_cast<std::size_t>(queue_[k]);
    local_[s] = n;
    n += first_[s + 1] - first_[s];
  }
  lowest_.resize(static_cast<std::size_t>(n));
  start_.resize(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) lowest_[static_cast<std::size_t>(i)] = i;
  for (int i = 0; i < island.blocks; ++i) {
    const RowBlock& b = block(i);
    int low = n;
    for (int k = 0; k < b.segments; ++k)  // a chain's deepest DOF has its lowest row
      low = std::min(low, matrix_row(segment(b, k), segment(b, k).length - 1));
    for (int k = 0; k < b.segments; ++k)
      for (int e = 0; e < segment(b, k).length; ++e) {
        int& lowest = lowest_[static_cast<std::size_t>(matrix_row(segment(b, k), e))];
        lowest = std::min(lowest, low);
      }
  }
  std::size_t size = 0;
  double operations = 0;
  for (std::size_t row = 0; row < lowest_.size(); ++row) {
    const std::size_t width = row - static_cast<std::size_t>(lowest_[row]) + 1;
    start_[row] = size;
    size += width;
    operations += static_cast<double>(width) * static_cast<double>(width);
  }
  cost_ = operations + 300.0 * island.blocks;
  for (int i = 0; i < island.blocks; ++i) {  // H from the blocks' rows
    double length = 0;
    for (int k = 0; k < block(i).segments; ++k) length += segment(block(i), k).length;
    cost_ += 0.5 * block(i).rows * length * length;
  }
  if (steps * cost_ > budget_) return false;
  H_.resize(size);
  F_.resize(static_cast<std::size_t>(n));
  step_.resize(F_.size());
  G_.resize(9 * static_cast<std::size_t>(island.blocks));
  x_.resize(F_.size());
  u_.resize(3 * static_cast<std::size_t>(island.blocks));
  du_.resize(u_.size());
  sort_rows(island);
  return true;
}

/// Copies the rows of each block to z_, ordered by matrix row, so that the loops over H run along consecutive entries. The entries of both
/// segments of a block on one system are added.
void VelocitySolver::sort_rows(const Island& island) {
  sorted_.clear();
  z_.clear();
  z_row_.clear();
  for (int i = 0; i < island.blocks; ++i) {
    const RowBlock& b = blocks_[static_cast<std::size_t>(order_[static_cast<std::size_t>(island.first_block + i)])];
    const RowSegment& x = segments_[static_cast<std::size_t>(b.first_segment)];
    const RowSegment& y = segments_[static_cast<std::size_t>(b.first_segment + b.segments - 1)];
    const std::size_t first = z_row_.size(), values = z_.size();
    constexpr int none = std::numeric_limits<int>::max();
    // A chain's deepest DOF is its last entry and has its lowest matrix row.
    int e = x.length - 1, f = b.segments == 2 ? y.length - 1 : -1;
    while (e >= 0 || f >= 0) {
      const int at = e >= 0 ? matrix_row(x, e) : none, other = f >= 0 ? matrix_row(y, f) : none;
      RowLanes sum = {};
      if (at <= other) sum += row_lanes(rows_.data() + x.offset, e--);
      if (other <= at) sum += row_lanes(rows_.data() + y.offset, f--);
      z_row_.push_back(std::min(at, other));
      for (int r = 0; r < b.rows; ++r) z_.push_back(sum[r]);
    }
    const std::size_t length = z_row_.size() - first;
    if (b.rows == 3) {  // from entry by entry to row by row
      swap_.assign(z_.begin() + static_cast<std::ptrdiff_t>(values), z_.end());
      for (std::size_t k = 0; k < length; ++k)
        for (std::size_t r = 0; r < 3; ++r) z_[values + r * length + k] = swap_[3 * k + r];
    }
    sorted_.push_back({static_cast<int>(first), static_cast<int>(length), static_cast<int>(values)});
  }
  z_run_.resize(z_row_.size());
  for (const SortedRows& s : sorted_)
    for (int k = s.length - 1; k >= 0; --k) {
      const auto at = static_cast<std::size_t>(s.first + k);
      z_run_[at] = k + 1 < s.length && z_row_[at + 1] == z_row_[at] + 1 ? z_run_[at + 1] : k + 1;
    }
}

/// Calculates the impulse p of the block's law at velocity u, and G = -dp/du [9, row by row].
void VelocitySolver::impulse_of(const RowBlock& b, const double* u, double* p, double* G) const {
  const double* hat = hat_.data() + b.row;
  // The law |p| <= radius, isotropic, for `count` rows from `first` on.
  const auto ball = [&](int first, int count, double R, double radius) {
    double x[3], square = 0;
    for (int r = 0; r < count; ++r) {
      x[r] = hat[first + r] - u[first + r] / R;
      square += x[r] * x[r];
    }
    const double size = std::sqrt(square);
    const bool slides = size > radius;
    const double scale = slides ? radius / size : 1;
    for (int r = 0; r < count; ++r) {
      p[first + r] = x[r] * scale;
      for (int c = 0; c < count; ++c)  // a faster slip does not change the impulse along it
        G[3 * (first + r) + first + c] = scale / R * ((r == c ? 1.0 : 0.0) - (slides ? x[r] * x[c] / square : 0));
    }
  };
  switch (b.kind) {
    case RowKind::contact: {
      const double soft = b.compliance * b.B[0], R = regularization_ * b.B[0], Rn = R + soft,
                   Rt = regularization_ * std::max(b.B[1], b.B[2]);
      const double xn = R * hat[0] - u[0] - saxce_[static_cast<std::size_t>(b.row)];
      std::fill_n(G, 9, 0.0);
      // After an impact the friction cone includes the impact's impulse, so that its tip is not at p = 0: use a disk of the last radius.
      if (b.impact_impulse > 0) {
        p[0] = std::max(0.0, xn / Rn);
        G[0] = p[0] > 0 ? 1 / Rn : 0;
        return ball(1, 2, Rt, b.mu * (hat[0] + b.impact_impulse));
      }
      // Projection onto the cone |y_t| <= m y_n, where y = sqrt(R) p and m is mu in these coordinates.
      const double root_n = std::sqrt(Rn), root_t = std::sqrt(Rt), m = b.mu * root_t / root_n;
      const double yn = xn / root_n, y1 = (Rt * hat[1] - u[1]) / root_t, y2 = (Rt * hat[2] - u[2]) / root_t;
      const double yt = std::sqrt(y1 * y1 + y2 * y2);
      if (yt <= m * yn) {
        p[0] = yn / root_n;
        p[1] = y1 / root_t;
        p[2] = y2 / root_t;
        G[0] = 1 / Rn;
        G[4] = G[8] = 1 / Rt;
        return;
      }
      if (m * yt <= -yn) {
        p[0] = p[1] = p[2] = 0;
        return;
      }
      const double share = 1 / (1 + m * m), qn = (yn + m * yt) * share, d1 = y1 / yt, d2 = y2 / yt;
      p[0] = qn / root_n;
      p[1] = m * qn * d1 / root_t;
      p[2] = m * qn * d2 / root_t;
      const double across = m * qn / yt, along = share * m * m, nt = share * m / (root_n * root_t);
      G[0] = share / Rn;
      G[1] = G[3] = nt * d1;
      G[2] = G[6] = nt * d2;
      G[4] = (along * d1 * d1 + across * d2 * d2) / Rt;
      G[8] = (along * d2 * d2 + across * d1 * d1) / Rt;
      G[5] = G[7] = (along - across) * d1 * d2 / Rt;
      return;
    }
    case RowKind::limit: {
      const double R = regularization_ * b.B[0];
      p[0] = std::max(0.0, hat[0] - u[0] / R);
      G[0] = p[0] > 0 ? 1 / R : 0;
      return;
    }
    case RowKind::friction: return ball(0, 1, regularization_ * b.B[0], b.bound);
    case RowKind::roll: {
      const RowBlock& contact_block = blocks_[static_cast<std::size_t>(b.contact_block)];
      const double normal = hat_[static_cast<std::size_t>(contact_block.row)];
      return ball(0, 3, regularization_ * std::max({b.B[0], b.B[1], b.B[2]}), b.mu * (normal + contact_block.impact_impulse));
    }
  }
}

/// Sets the quantities that stay fixed during minimise(): p^, and for sliding contacts the shift mu |u_t| of the normal velocity (de
/// Saxce). With this shift the symmetric cone law equals Coulomb's law; without it sliding contacts would separate.
void VelocitySolver::fix_law(const Island& island) {
  hat_ = p_;
  saxce_.resize(p_.size());
  for (int i = 0; i < island.blocks; ++i) {
    const RowBlock& b = blocks_[static_cast<std::size_t>(order_[static_cast<std::size_t>(island.first_block + i)])];
    if (b.kind != RowKind::contact) continue;
    const double* p = p_.data() + b.row;
    double& saxce = saxce_[static_cast<std::size_t>(b.row)];
    saxce = 0;
    const double cone = 0.999 * b.mu * p[0];
    if (b.impact_impulse > 0 || p[1] * p[1] + p[2] * p[2] < cone * cone) continue;
    const double* u = u_.data() + 3 * static_cast<std::size_t>(i);
    saxce = b.mu * std::sqrt(u[1] * u[1] + u[2] * u[2]);
  }
}

/// Adds Y^T G Y of one block to the lower triangle of H (symbols: top of this file).
void VelocitySolver::add_to_matrix(const SortedRows& s, int rows, const double* G) {
  const int* const row = z_row_.data() + s.first;
  const int* const run = z_run_.data() + s.first;
  const double *const Z0 = z_.data() + s.values, *const Z1 = Z0 + s.length, *const Z2 = Z1 + s.length;
  for (int e = 0; e < s.length; ++e) {
    double* const H = H_.data() + start_[static_cast<std::size_t>(row[e])] - lowest_[static_cast<std::size_t>(row[e])];
    const double z0 = Z0[e], z1 = rows == 3 ? Z1[e] : 0, z2 = rows == 3 ? Z2[e] : 0;
    const double g0 = z0 * G[0] + z1 * G[3] + z2 * G[6], g1 = z0 * G[1] + z1 * G[4] + z2 * G[7], g2 = z0 * G[2] + z1 * G[5] + z2 * G[8];
    for (int f = 0; f <= e;) {
      const int end = std::min(run[f], e + 1);
      double* const to = H + row[f] - f;
      if (rows == 3)
        for (; f < end; ++f) to[f] += g0 * Z0[f] + g1 * Z1[f] + g2 * Z2[f];
      else
        for (; f < end; ++f) to[f] += g0 * Z0[f];
    }
  }
}

/// Calculates the law's impulses p and the matrices G of all blocks at the velocities u_ - length du_. @return the slope and curvature of
/// the merit along the step, without the part of |w|^2 / 2
std::pair<double, double> VelocitySolver::apply_laws(const Island& island, double length) {
  double slope = 0, curvature = 0;
  double* G = G_.data();
  const double *u = u_.data(), *du = du_.data();
  for (int i = 0; i < island.blocks; ++i, G += 9, u += 3, du += 3) {
    const RowBlock& b = blocks_[static_cast<std::size_t>(order_[static_cast<std::size_t>(island.first_block + i)])];
    double* p = p_.data() + b.row;
    const double next[3] = {u[0] - length * du[0], u[1] - length * du[1], u[2] - length * du[2]};
    impulse_of(b, next, p, G);
    for (int r = 0; r < b.rows; ++r) {
      slope += p[r] * du[r];
      for (int c = 0; c < b.rows; ++c) curvature += du[r] * G[3 * r + c] * du[c];
    }
  }
  return {slope, curvature};
}

/// Calculates F from x_ (w without the contribution of other blocks) and the impulses p.
void VelocitySolver::calc_residual(const Island& island) {
  F_ = x_;
  for (int i = 0; i < island.blocks; ++i) {
    const RowBlock& b = blocks_[static_cast<std::size_t>(order_[static_cast<std::size_t>(island.first_block + i)])];
    const SortedRows& s = sorted_[static_cast<std::size_t>(i)];
    const double* Z = z_.data() + s.values;
    for (int r = 0; r < b.rows; ++r, Z += s.length) {
      const double p = p_[static_cast<std::size_t>(b.row + r)];
      if (p == 0) continue;
      for (int e = 0; e < s.length; ++e) F_[static_cast<std::size_t>(z_row_[static_cast<std::size_t>(s.first + e)])] -= Z[e] * p;
    }
  }
}

/// Calculates the Newton matrix H = 1 + sum Y^T G Y, with G from apply_laws().
void VelocitySolver::assemble_matrix(const Island& island) {
  std::ranges::fill(H_, 0.0);
  for (std::size_t i = 0; i < F_.size(); ++i) H_[start_[i] + i - static_cast<std::size_t>(lowest_[i])] = 1;
  const double* G = G_.data();
  for (int i = 0; i < island.blocks; ++i, G += 9) {
    const int rows = blocks_[static_cast<std::size_t>(order_[static_cast<std::size_t>(island.first_block + i)])].rows;
    if (G[0] + (rows == 3 ? G[4] + G[8] : 0) > 0) add_to_matrix(sorted_[static_cast<std::size_t>(i)], rows, G);
  }
}

/// Recalculates w from the impulses and marks all blocks of the island, so that the next sweep solves each of them.
void VelocitySolver::recompute_w(const Island& island) {
  const auto each_system = [&](auto&& visit) {
    for (int k = 0; k < island.systems; ++k) {
      const auto s = static_cast<std::size_t>(members_[static_cast<std::size_t>(island.first_system + k)]);
      visit(s, static_cast<std::size_t>(first_[s]), static_cast<std::size_t>(first_[s + 1]));
    }
  };
  each_system([&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t e = begin; e < end; ++e) {
      scratch_w_[e] = w_[e];
      w_[e] = base_[e];
    }
  });
  for (int i = 0; i < island.blocks; ++i) {
    RowBlock& b = blocks_[static_cast<std::size_t>(order_[static_cast<std::size_t>(island.first_block + i)])];
    apply(b, p_.data() + b.row);
    b.solved_motion = -HUGE_VAL;
  }
  each_system([&](std::size_t s, std::size_t begin, std::size_t end) {
    double square = 0;
    for (std::size_t e = begin; e < end; ++e) square += (w_[e] - scratch_w_[e]) * (w_[e] - scratch_w_[e]);
    motion_[s] += std::sqrt(square);
  });
}

/// Calculates the Newton step step_ = H^-1 F. Replaces H by its Cholesky factor with inverted diagonal.
void VelocitySolver::solve_newton() {
  const std::size_t n = F_.size();
  for (std::size_t i = 0; i < n; ++i) {
    double* const row = H_.data() + start_[i];
    const int low = lowest_[i], last = static_cast<int>(i);
    for (int j = low; j <= last; ++j) {
      const double* const other = H_.data() + start_[static_cast<std::size_t>(j)];
      const int other_low = lowest_[static_cast<std::size_t>(j)];
      double even = row[j - low], odd = 0;
      int k = std::max(low, other_low);
      for (; k + 1 < j; k += 2) {
        even -= row[k - low] * other[k - other_low];
        odd -= row[k + 1 - low] * other[k + 1 - other_low];
      }
      if (k < j) even -= row[k - low] * other[k - other_low];
      row[j - low] = j < last ? (even + odd) * other[j - other_low] : 1 / std::sqrt(even + odd);
    }
    double x = F_[i];
    for (int k = low; k < last; ++k) x -= row[k - low] * step_[static_cast<std::size_t>(k)];
    step_[i] = x * row[last - low];
  }
  for (std::size_t i = n; i-- > 0;) {
    const double* const row = H_.data() + start_[i];
    const int low = lowest_[i], last = static_cast<int>(i);
    step_[i] *= row[last - low];
    for (int k = low; k < last; ++k) step_[static_cast<std::size_t>(k)] -= row[k - low] * step_[i];
  }
}

/// Minimises the merit, starting from x_ and u_, with p^ and the de Saxce shifts fixed; sets p to the law's impulses.
/// @return number of Newton steps
int VelocitySolver::minimise(const Island& island) {
  const int limit = static_cast<int>(std::min(12.0, budget_ / cost_));
  std::ranges::fill(du_, 0.0);
  apply_laws(island, 0);
  for (int steps = 1; steps <= limit; ++steps) {
    budget_ -= cost_;
    calc_residual(island);
    assemble_matrix(island);
    solve_newton();
    double slope = 0, square = 0, along = 0;  // slope: minus the slope of the merit along the step
    for (std::size_t i = 0; i < F_.size(); ++i) {
      slope += F_[i] * step_[i];
      square += step_[i] * step_[i];
      along += x_[i] * step_[i];
    }
    if (!(slope > 1e-26)) return steps;
    for (int i = 0; i < island.blocks; ++i) {
      const RowBlock& b = blocks_[static_cast<std::size_t>(order_[static_cast<std::size_t>(island.first_block + i)])];
      const SortedRows& s = sorted_[static_cast<std::size_t>(i)];
      const double* Z = z_.data() + s.values;
      for (int r = 0; r < b.rows; ++r, Z += s.length) {
        double sum = 0;
        for (int e = 0; e < s.length; ++e) sum += Z[e] * step_[static_cast<std::size_t>(z_row_[static_cast<std::size_t>(s.first + e)])];
        du_[static_cast<std::size_t>(3 * i + r)] = sum;
      }
    }
    // Along w - length step the slope of the merit grows from -slope and has one zero: Newton's method, kept between `low` and `high`.
    double length = 1, low = 0, high = HUGE_VAL;
    for (int trial = 1;; ++trial) {
      const auto [laws, curvature] = apply_laws(island, length);
      const double now = length * square - along + laws;
      if (std::fabs(now) <= slope_ratio * slope || trial == max_trials) break;
      (now > 0 ? high : low) = length;
      const double next = length - now / (square + curvature);
      length = next > low && next < high ? next : high < HUGE_VAL ? 0.5 * (low + high) : 2 * length;
    }
    for (std::size_t i = 0; i < x_.size(); ++i) x_[i] -= length * step_[i];
    for (std::size_t i = 0; i < u_.size(); ++i) u_[i] -= length * du_[i];
    if (slope < 1e-20) return steps;
  }
  return limit;
}

/// Improves p and w by Newton's method. If the following sweep changes velocities by `change` or more, p and w are restored.
/// @param subset true: blocks outside `island` act on its systems
/// @param change m/s: maximum change of a velocity in the last sweep
/// @return number of Newton steps
int VelocitySolver::newton(const Island& island, bool subset, double change, double tolerance) {
  for (int k = 0; k < island.systems; ++k) {
    const auto s = static_cast<std::size_t>(members_[static_cast<std::size_t>(island.first_system + k)]);
    for (auto e = static_cast<std::size_t>(first_[s]); e < static_cast<std::size_t>(first_[s + 1]); ++e) base_[e] = subset ? w_[e] : 0;
  }
  for (int i = 0; subset && i < island.blocks; ++i) {
    const RowBlock& b = blocks_[static_cast<std::size_t>(order_[static_cast<std::size_t>(island.first_block + i)])];
    const double* p = p_.data() + b.row;
    for (int k = 0; k < b.segments; ++k) {
      const RowSegment& x = segments_[static_cast<std::size_t>(b.first_segment + k)];
      const double* y = rows_.data() + x.offset;
      for (int r = 0; r < b.rows; ++r)
        for (int e = 0; e < x.length; ++e) base_[static_cast<std::size_t>(x.first + (x.index ? x.index[e] : e))] -= y[4 * e + r] * p[r];
    }
  }
  old_p_ = p_;
  for (int k = 0; k < island.systems; ++k) {
    const auto s = static_cast<std::size_t>(members_[static_cast<std::size_t>(island.first_system + k)]);
    for (int e = first_[s]; e < first_[s + 1]; ++e)
      x_[static_cast<std::size_t>(local_[s] + first_[s + 1] - 1 - e)] =
          w_[static_cast<std::size_t>(e)] - base_[static_cast<std::size_t>(e)];
  }
  for (int i = 0; i < island.blocks; ++i)
    velocities(blocks_[static_cast<std::size_t>(order_[static_cast<std::size_t>(island.first_block + i)])],
               u_.data() + 3 * static_cast<std::size_t>(i));
  int steps = 0;
  regularization_ = first_regularization;
  for (int outer = 0; outer < max_updates && budget_ > cost_;
       ++outer, regularization_ = std::max(0.1 * regularization_, min_regularization)) {
    fix_law(island);
    steps += minimise(island);
    double moved = 0;  // m/s: velocity error that corresponds to the last change of p^
    for (int i = 0; i < island.blocks; ++i) {
      const RowBlock& b = blocks_[static_cast<std::size_t>(order_[static_cast<std::size_t>(island.first_block + i)])];
      for (int r = 0; r < b.rows; ++r) {
        const auto at = static_cast<std::size_t>(b.row + r);
        moved = std::max(moved, regularization_ * b.B[r] * std::fabs(p_[at] - hat_[at]));
      }
    }
    if (moved < 0.1 * tolerance) break;
  }
  recompute_w(island);
  if (sweep(island, true, 0) < change) return steps;
  p_ = old_p_;
  recompute_w(island);
  return steps;
}

/// Newton's method for the systems of the blocks that had not converged in the last sweep (for example a wedged body), with all other
/// systems fixed. Used if Newton's method for the complete island would cost too much. @return number of Newton steps
int VelocitySolver::newton_on_subset(const Island& island, double tolerance) {
  const auto block = [&](int i) -> const RowBlock& {
    return blocks_[static_cast<std::size_t>(order_[static_cast<std::size_t>(island.first_block + i)])];
  };
  const auto inside = [&](const RowBlock& b, int k) -> char& {
    return in_subset_[static_cast<std::size_t>(segments_[static_cast<std::size_t>(b.first_segment + k)].system)];
  };
  double change = 0;
  for (int i = 0; i < island.blocks; ++i) {
    if (block(i).change < tolerance) continue;
    change = std::max(change, block(i).change);
    for (int k = 0; k < block(i).segments; ++k) inside(block(i), k) = 1;
  }
  Island subset{static_cast<int>(order_.size()), 0, static_cast<int>(members_.size()), 0};
  for (int i = 0; i < island.blocks; ++i) {
    const RowBlock& b = block(i);
    if (inside(b, 0) == 0 || inside(b, b.segments - 1) == 0) continue;
    order_.push_back(order_[static_cast<std::size_t>(island.first_block + i)]);
    ++subset.blocks;
  }
  for (int k = 0; k < island.systems; ++k) {
    const int s = members_[static_cast<std::size_t>(island.first_system + k)];
    if (in_subset_[static_cast<std::size_t>(s)] == 0) continue;
    in_subset_[static_cast<std::size_t>(s)] = 0;
    members_.push_back(s);
    ++subset.systems;
  }
  const int steps = subset.systems > 0 && order_systems(subset, 1) ? newton(subset, true, change, tolerance) : 0;
  order_.resize(static_cast<std::size_t>(subset.first_block));
  members_.resize(static_cast<std::size_t>(subset.first_system));
  return steps;
}

}  // namespace ugoki::contact
