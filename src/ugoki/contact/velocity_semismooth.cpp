// Semi-smooth Newton method on the whitened velocities w of an island of any size (velocity_solver.h).
//
// The method is that of DenseIsland, with another linear system. A block with fixed class has the linear law p = c - G u (natural_map.h),
// and its velocity is u = target + Y w. With w = sum Y^T p over all blocks, a Newton step is the solution of
//   (1 + sum Y^T G Y) w = sum Y^T (c - G target)
// The matrix couples only systems that touch, so that it is an envelope matrix. Sliding contacts make it unsymmetric; it is then factored
// by LU without row exchanges, otherwise by Cholesky. A step that does not reduce the natural map is halved.
// Source: Alart, Curnier (1991), section 4; Qi, Sun (1993), A nonsmooth version of Newton's method.

#include <algorithm>
#include <cmath>

#include "ugoki/contact/contact_law.h"
#include "ugoki/contact/natural_map.h"
#include "ugoki/contact/solver_kernels.h"
#include "ugoki/contact/velocity_solver.h"

namespace ugoki::contact {
namespace {
// As for DenseIsland (dense_island.cpp): a of the natural map at first, and after `patience` steps without progress.
constexpr double augmentations[] = {0.1, 0.02};
constexpr int max_steps = 24, patience = 4, max_halvings = 5;
constexpr double progress = 0.9;
}  // namespace

/// N s: p_n + impact_impulse of the contact of a roll block; 0 for other blocks.
double VelocitySolver::leader_impulse(const RowBlock& b) const {
  if (b.kind != RowKind::roll) return 0;
  const RowBlock& contact = blocks_[static_cast<std::size_t>(b.contact_block)];
  return p_[static_cast<std::size_t>(contact.row)] + contact.impact_impulse;
}

/// Sets x_ to sum Y^T p of the island's blocks, and u_ to their velocities. All other blocks have no effect on the island's systems.
void VelocitySolver::update_motion(const Island& island) {
  std::ranges::fill(x_, 0.0);
  for (int i = 0; i < island.blocks; ++i) {
    const RowBlock& b = block(island, i);
    const SortedRows& s = sorted_[static_cast<std::size_t>(i)];
    const int* const row = z_row_.data() + s.first;
    const double* Z = z_.data() + s.values;
    for (int r = 0; r < b.rows; ++r, Z += s.length) {
      const double p = p_[static_cast<std::size_t>(b.row + r)];
      if (p == 0) continue;
      for (int e = 0; e < s.length; ++e) x_[static_cast<std::size_t>(row[e])] += Z[e] * p;
    }
  }
  for (int i = 0; i < island.blocks; ++i) velocities_at(island, i, x_, u_.data() + 3 * static_cast<std::size_t>(i));
}

/// Calculates the velocity u = target + Y x of block i of the island. @param x [n] whitened velocities in the order of the matrix
void VelocitySolver::velocities_at(const Island& island, int i, const std::vector<double>& x, double* u) {
  const RowBlock& b = block(island, i);
  const SortedRows& s = sorted_[static_cast<std::size_t>(i)];
  const int* const row = z_row_.data() + s.first;
  const double* Z = z_.data() + s.values;
  for (int r = 0; r < b.rows; ++r, Z += s.length) {
    double sum = 0;
    for (int e = 0; e < s.length; ++e) sum += Z[e] * x[static_cast<std::size_t>(row[e])];
    u[r] = target_[static_cast<std::size_t>(b.row + r)] + sum;
  }
}

/// Computes the natural map at p_ and u_. @return its squared norm @param maximum m/s, out: its maximum entry
double VelocitySolver::natural_map(const Island& island, double augmentation, double& maximum) {
  NaturalMap map{augmentation};
  for (int i = 0; i < island.blocks; ++i) {
    const RowBlock& b = block(island, i);
    map.add(b, leader_impulse(b), p_.data() + b.row, u_.data() + 3 * static_cast<std::size_t>(i));
  }
  maximum = map.maximum;
  return map.square;
}

/// Replaces p_ by the impulses after a full Newton step. @return false if the step is not finite
bool VelocitySolver::step_to_linear_laws(const Island& island, double augmentation) {
  laws_.resize(static_cast<std::size_t>(island.blocks));
  bool symmetric = true;
  std::ranges::fill(F_, 0.0);
  for (int i = 0; i < island.blocks; ++i) {
    const RowBlock& b = block(island, i);
    LinearLaw& law = laws_[static_cast<std::size_t>(i)];
    find_linear_law(b, augmentation, leader_impulse(b), p_.data() + b.row, u_.data() + 3 * static_cast<std::size_t>(i), law);
    symmetric = symmetric && law.symmetric;
    const SortedRows& s = sorted_[static_cast<std::size_t>(i)];
    const double* Z = z_.data() + s.values;
    const double* const target = target_.data() + b.row;
    for (int r = 0; r < b.rows; ++r, Z += s.length) {
      double p = law.c[r];
      for (int c = 0; c < b.rows; ++c) p -= law.G[3 * r + c] * target[c];
      for (int e = 0; e < s.length && p != 0; ++e) F_[static_cast<std::size_t>(z_row_[static_cast<std::size_t>(s.first + e)])] += Z[e] * p;
    }
  }
  H_.set_identity();
  if (!symmetric) H_.set_upper_identity();
  const EnvelopeArguments H = H_.arguments();
  for (int i = 0; i < island.blocks; ++i) {
    const SortedRows& s = sorted_[static_cast<std::size_t>(i)];
    const SortedBlock rows{block(island, i).rows, s.length, z_.data() + s.values, z_row_.data() + s.first, z_run_.data() + s.first};
    const double* const G = laws_[static_cast<std::size_t>(i)].G;
    if (std::all_of(G, G + 9, [](double x) { return x == 0; })) continue;
    solver_kernels().add_to_envelope(rows, G, H);
    if (!symmetric) solver_kernels().add_to_upper_envelope(rows, G, H);
  }
  budget_ -= symmetric ? cost_ : 2 * cost_;
  if (symmetric)
    H_.solve(F_, step_);
  else
    H_.solve_unsymmetric(F_, step_);
  for (int i = 0; i < island.blocks; ++i) {
    const RowBlock& b = block(island, i);
    const LinearLaw& law = laws_[static_cast<std::size_t>(i)];
    double u[3];
    velocities_at(island, i, step_, u);
    for (int r = 0; r < b.rows; ++r) {
      double p = law.c[r];
      for (int c = 0; c < b.rows; ++c) p -= law.G[3 * r + c] * u[c];
      if (!(p - p == 0)) return false;
      p_[static_cast<std::size_t>(b.row + r)] = p;
    }
  }
  return true;
}

/// Clamps the impulses to the bounds of their laws, except friction of joints and rolling resistance, which the next sweep clamps.
void VelocitySolver::project(const Island& island) {
  for (int i = 0; i < island.blocks; ++i) {
    const RowBlock& b = block(island, i);
    double* const p = p_.data() + b.row;
    if (b.kind == RowKind::limit || b.kind == RowKind::contact) p[0] = std::max(0.0, p[0]);
    if (b.kind == RowKind::contact) clamp_to_disk(p[1], p[2], b.mu * (p[0] + b.impact_impulse));
  }
}

/// Improves p and w by the semi-smooth Newton method. order_systems() must have succeeded. If the method does not converge and the next
/// sweep changes velocities by `change` or more, p and w are restored.
/// @param change m/s: maximum change of a velocity in the last sweep
/// @return number of Newton steps
int VelocitySolver::semi_smooth_newton(const Island& island, double change, double tolerance) {
  old_p_ = p_;
  update_motion(island);
  double maximum = 0;
  std::size_t a = 0;
  double norm = natural_map(island, augmentations[a], maximum), lowest = norm;
  int steps = 0;
  for (int idle = 0; maximum >= tolerance && steps < max_steps && budget_ > 2 * cost_;) {
    ++steps;
    hat_ = p_;
    du_ = u_;
    if (!step_to_linear_laws(island, augmentations[a])) break;
    update_motion(island);
    double length = 1, next = natural_map(island, augmentations[a], maximum);
    if (!(next < norm * (1 - 0.2 * length))) {  // from here on p^ and du_ are the beginning, shift_ and G_ the change of the full step
      shift_.resize(p_.size());
      for (int i = 0; i < island.blocks; ++i) {
        const auto at = static_cast<std::size_t>(block(island, i).row), local = 3 * static_cast<std::size_t>(i);
        for (std::size_t r = 0; r < static_cast<std::size_t>(block(island, i).rows); ++r) {
          shift_[at + r] = p_[at + r] - hat_[at + r];
          G_[local + r] = u_[local + r] - du_[local + r];
        }
      }
      for (int halvings = 0; halvings < max_halvings && !(next < norm * (1 - 0.2 * length)); ++halvings) {
        length *= 0.5;
        for (int i = 0; i < island.blocks; ++i) {
          const auto at = static_cast<std::size_t>(block(island, i).row), local = 3 * static_cast<std::size_t>(i);
          for (std::size_t r = 0; r < static_cast<std::size_t>(block(island, i).rows); ++r) {
            p_[at + r] = hat_[at + r] + length * shift_[at + r];
            u_[local + r] = du_[local + r] + length * G_[local + r];
          }
        }
        next = natural_map(island, augmentations[a], maximum);
      }
    }
    norm = next;
    idle = norm < progress * lowest ? 0 : idle + 1;
    lowest = std::min(lowest, norm);
    if (idle < patience) continue;
    if (a + 1 == std::size(augmentations)) break;
    norm = lowest = natural_map(island, augmentations[++a], maximum);
    idle = 0;
  }
  for (int k = 0; k < island.systems; ++k) {
    const auto s = static_cast<std::size_t>(members_[static_cast<std::size_t>(island.first_system + k)]);
    std::fill(base_.begin() + first_[s], base_.begin() + first_[s + 1], 0.0);
  }
  project(island);
  recompute_w(island);
  if (maximum < tolerance || sweep(island, true, 0) < change) return steps;
  p_ = old_p_;
  recompute_w(island);
  return steps;
}

}  // namespace ugoki::contact
