// Newton's method on the whitened velocities w of an island (velocity_solver.h). For fixed p^ it solves
//   F(w) = w - sum Y^T p(u(w)) = 0,   p = the law's projection of p^ - u / R   (augmented Lagrangian, p^ = the last impulses)
// Y are the whitened rows of a block, u its velocity. R is a small fraction of the block's own inverse inertia. It only sets how fast p^
// converges; at the solution p = p^ it cancels.
// If only a subset of an island's systems is solved, the contribution of the blocks outside the subset is subtracted from w in F; their
// impulses are constant.
// H = dF/dw = 1 + sum Y^T G Y with G = -dp/du. The coupling of a sliding contact's friction to its normal impulse is left out, so that H is
// symmetric and positive definite.

#include <algorithm>
#include <cmath>

#include "ugoki/contact/velocity_solver.h"

namespace ugoki::contact {
namespace {
// First and minimum value of R, relative to a block's inverse inertia. Each update of p^ divides R by ten.
constexpr double first_regularization = 1e-2, min_regularization = 1e-6;
constexpr int max_updates = 8;
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
  if (steps * cost_ > budget_) return false;
  H_.resize(size);
  F_.resize(static_cast<std::size_t>(n));
  step_.resize(F_.size());
  G_.resize(9 * static_cast<std::size_t>(island.blocks));
  old_w_.resize(F_.size());
  return true;
}

/// Calculates the impulse p of the block's law at velocity u, and G = -dp/du [9, row by row]. @return the block's term of the merit
double VelocitySolver::impulse_of(const RowBlock& b, const double* u, double* p, double* G) const {
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
    return R * (slides ? radius * (size - 0.5 * radius) : 0.5 * square);
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
        return 0.5 * Rn * p[0] * p[0] + ball(1, 2, Rt, b.mu * (hat[0] + b.impact_impulse));
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
        return 0.5 * (yn * yn + yt * yt);
      }
      if (m * yt <= -yn) {
        p[0] = p[1] = p[2] = 0;
        return 0;
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
      return 0.5 * (1 + m * m) * qn * qn;
    }
    case RowKind::limit: {
      const double R = regularization_ * b.B[0];
      p[0] = std::max(0.0, hat[0] - u[0] / R);
      G[0] = p[0] > 0 ? 1 / R : 0;
      return 0.5 * R * p[0] * p[0];
    }
    case RowKind::friction: return ball(0, 1, regularization_ * b.B[0], b.bound);
    case RowKind::roll: {
      const RowBlock& contact_block = blocks_[static_cast<std::size_t>(b.contact_block)];
      const double normal = hat_[static_cast<std::size_t>(contact_block.row)];
      return ball(0, 3, regularization_ * std::max({b.B[0], b.B[1], b.B[2]}), b.mu * (normal + contact_block.impact_impulse));
    }
  }
  return 0;
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
    double u[3];
    velocities(b, u);
    saxce = b.mu * std::sqrt(u[1] * u[1] + u[2] * u[2]);
  }
}

/// Adds Y^T G Y of one block to the lower triangle of H (symbols: top of this file).
void VelocitySolver::add_to_matrix(const RowBlock& b, const double* G) {
  const int n = b.rows;
  for (int sa = 0; sa < b.segments; ++sa) {
    const RowSegment& x = segments_[static_cast<std::size_t>(b.first_segment + sa)];
    for (int sb = 0; sb < b.segments; ++sb) {
      const RowSegment& y = segments_[static_cast<std::size_t>(b.first_segment + sb)];
      if (local_[static_cast<std::size_t>(y.system)] > local_[static_cast<std::size_t>(x.system)]) continue;
      const double* const X = rows_.data() + x.offset;
      const double* const Y = rows_.data() + y.offset;
      for (int e = 0; e < x.length; ++e) {
        const int row = matrix_row(x, e);
        // H is symmetric: matrix_row() of the other DOF is its column. Only columns up to `row` are stored.
        double* const H = H_.data() + start_[static_cast<std::size_t>(row)] - lowest_[static_cast<std::size_t>(row)];
        RowLanes g = {};
        for (int r = 0; r < n; ++r)
          for (int c = 0; c < n; ++c) g[c] += X[4 * e + r] * G[3 * r + c];
        for (int f = 0; f < y.length; ++f) {
          const int column = matrix_row(y, f);
          if (column > row) continue;
          const RowLanes product = g * row_lanes(Y, f);
          H[column] += product[0] + product[1] + product[2];
        }
      }
    }
  }
}

double VelocitySolver::assemble(const Island& island) {
  for (int k = 0; k < island.systems; ++k) {
    const auto s = static_cast<std::size_t>(members_[static_cast<std::size_t>(island.first_system + k)]);
    for (int e = first_[s]; e < first_[s + 1]; ++e)
      F_[static_cast<std::size_t>(local_[s] + first_[s + 1] - 1 - e)] =
          w_[static_cast<std::size_t>(e)] - base_[static_cast<std::size_t>(e)];
  }
  double merit = 0;
  for (const double w : F_) merit += 0.5 * w * w;
  double* G = G_.data();
  for (int i = 0; i < island.blocks; ++i, G += 9) {
    const RowBlock& b = blocks_[static_cast<std::size_t>(order_[static_cast<std::size_t>(island.first_block + i)])];
    double u[3];
    velocities(b, u);
    double* p = p_.data() + b.row;
    merit += impulse_of(b, u, p, G);
    for (int s = 0; s < b.segments; ++s) {
      const RowSegment& x = segments_[static_cast<std::size_t>(b.first_segment + s)];
      for (int r = 0; r < b.rows; ++r)
        for (int e = 0; e < x.length; ++e)
          F_[static_cast<std::size_t>(matrix_row(x, e))] -= rows_[static_cast<std::size_t>(x.offset + 4 * e + r)] * p[r];
    }
  }
  return merit;
}

/// Calculates the Newton matrix H = 1 + sum Y^T G Y, with G from assemble().
void VelocitySolver::assemble_matrix(const Island& island) {
  std::ranges::fill(H_, 0.0);
  for (std::size_t i = 0; i < F_.size(); ++i) H_[start_[i] + i - static_cast<std::size_t>(lowest_[i])] = 1;
  const double* G = G_.data();
  for (int i = 0; i < island.blocks; ++i, G += 9) {
    const RowBlock& b = blocks_[static_cast<std::size_t>(order_[static_cast<std::size_t>(island.first_block + i)])];
    if (G[0] + (b.rows == 3 ? G[4] + G[8] : 0) > 0) add_to_matrix(b, G);
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

/// Minimises the merit, starting from w, with p^ and the de Saxce shifts fixed; sets p to the law's impulses. @return number of Newton
/// steps
int VelocitySolver::minimise(const Island& island) {
  const int limit = static_cast<int>(std::min(12.0, budget_ / cost_));
  const auto each_w = [&](auto&& visit) {
    for (int k = 0; k < island.systems; ++k) {
      const auto s = static_cast<std::size_t>(members_[static_cast<std::size_t>(island.first_system + k)]);
      for (int e = first_[s]; e < first_[s + 1]; ++e)
        visit(w_[static_cast<std::size_t>(e)], static_cast<std::size_t>(local_[s] + first_[s + 1] - 1 - e));
    }
  };
  double merit = assemble(island);
  for (int steps = 1; steps <= limit; ++steps) {
    budget_ -= cost_;
    assemble_matrix(island);
    solve_newton();
    double slope = 0;  // negative slope of the merit along the step
    for (std::size_t i = 0; i < F_.size(); ++i) slope += F_[i] * step_[i];
    if (!(slope > 1e-26)) return steps;
    each_w([&](double& w, std::size_t at) { old_w_[at] = w; });
    double length = 1, next = 0;
    for (int half = 0; half < 8; ++half, length *= 0.5) {
      each_w([&](double& w, std::size_t at) { w = old_w_[at] - length * step_[at]; });
      next = assemble(island);
      if (next <= merit - 1e-4 * length * slope + 1e-14 * merit) break;
    }
    merit = next;
    if (slope < 1e-20 + 1e-24 * merit) return steps;
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
    if (moved < 0.01 * tolerance) break;
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
