#pragma once
// Laws of the row blocks: the impulse p of one block at a given velocity, all other impulses fixed.
//
// u: velocity of the block, including the effect of p; s: compliance of a contact; mu: friction coefficient; n, t1, t2: normal, tangents.
//   contact (n, t1, t2):  u_n + s p_n >= 0,  p_n >= 0,  p_n (u_n + s p_n) = 0;  |p_t| <= mu (p_n + impact_impulse), opposed to u_t
//   limit:                u >= 0,  p >= 0,  p u = 0
//   friction:             |p| <= bound, opposed to u
//   grip (3 rows):        u = 0, any p
//   roll (3 rows):        |p| <= mu (p_n + impact_impulse) of its contact, opposed to u; mu is the lever of rolling resistance [m]
// The functions are local to each source file, because the inner loops are compiled for several instruction sets (solver_kernels.h).
// Sources: Moreau (1988), Unilateral contact and dry friction in finite DOF dynamics; Hwangbo, Lee, Hutter (2018), Per-contact
// iteration method for solving contact dynamics.

#include "ugoki/contact/row_block.h"

namespace ugoki::contact {

/// Projects (x, y) onto the disk of the given radius about the origin.
static inline void clamp_to_disk(double& x, double& y, double radius) {
  const double size = __builtin_sqrt(x * x + y * y);
  if (size <= radius) return;
  const double scale = radius / size;
  x *= scale;
  y *= scale;
}

/// out = S x for a symmetric 3 x 3 matrix with entries 00 11 22 01 02 12.
static inline void multiply_symmetric(const double* S, const double* x, double* out) {
  out[0] = S[0] * x[0] + S[3] * x[1] + S[4] * x[2];
  out[1] = S[3] * x[0] + S[1] * x[1] + S[5] * x[2];
  out[2] = S[4] * x[0] + S[5] * x[1] + S[2] * x[2];
}

static inline double larger(double a, double b) { return a < b ? b : a; }

/// Solves a sliding contact whose friction acts on the normal velocity about as strongly as the normal impulse does. The alternating
/// iteration of solve_contact() may then oscillate and end at p = 0 with the contact still closing. Here friction is at its bound and
/// opposed to c_t, so that the normal impulse p_n is the only unknown (c: velocity without the contact's impulse; B: inverse inertia):
///   0 = c_n + (B_nn - mu B_nt . c_t / |c_t|) p_n
static inline void slide_contact(const RowBlock& b, const double* c, double* p) {
  const double speed = __builtin_sqrt(c[1] * c[1] + c[2] * c[2]);
  if (!(speed > 0)) return;
  const double along[2] = {-b.mu * c[1] / speed, -b.mu * c[2] / speed};
  const double lift = b.B[0] + b.B[3] * along[0] + b.B[4] * along[1];
  if (!(lift > 1e-3 * b.B[0])) return;  // friction cancels the normal impulse (jamming): no solution
  p[0] = -c[0] / lift;
  p[1] = p[0] * along[0];
  p[2] = p[0] * along[1];
}

/// Solves one contact with all other impulses fixed.
/// @param c [3] velocity without the contact's own impulse
/// @param p [3, in out] impulse (n, t1, t2); in: the previous one
static inline void solve_contact(const RowBlock& b, const double* c, double* p) {
  if (b.impact_impulse == 0 && c[0] >= 0) {
    p[0] = p[1] = p[2] = 0;
    return;
  }
  double stick[3];
  multiply_symmetric(b.inverse, c, stick);
  const double cone = b.mu * (b.impact_impulse - stick[0]);
  if (stick[0] <= 0 && stick[1] * stick[1] + stick[2] * stick[2] <= cone * cone) {
    for (int r = 0; r < 3; ++r) p[r] = -stick[r];
    return;
  }
  for (int k = 0; k < 2; ++k) {
    p[0] = larger(0.0, -(c[0] + b.B[3] * p[1] + b.B[4] * p[2]) * b.inverse_normal);
    const double u1 = c[1] + b.B[3] * p[0] + b.B[1] * p[1] + b.B[5] * p[2];
    const double u2 = c[2] + b.B[4] * p[0] + b.B[5] * p[1] + b.B[2] * p[2];
    p[1] -= b.friction_step * u1;
    p[2] -= b.friction_step * u2;
    clamp_to_disk(p[1], p[2], b.mu * (p[0] + b.impact_impulse));
  }
  if (p[0] == 0 && b.impact_impulse == 0) slide_contact(b, c, p);
}

/// Returns the maximum change of the block's velocity [m/s | rad/s] that a change of its impulses causes: the largest entry of |B change|.
/// The rows of a contact within one mechanism may depend on each other; large changes of their impulses can then cancel out.
/// @param change [rows] N s | N m s
static inline double velocity_change(const RowBlock& b, const double* change) {
  if (b.rows == 1) return __builtin_fabs(b.B[0] * change[0]);
  double u[3];
  multiply_symmetric(b.B, change, u);
  return larger(larger(__builtin_fabs(u[0]), __builtin_fabs(u[1])), __builtin_fabs(u[2]));
}

/// Calculates the impulse of a block that satisfies its law while all other impulses stay fixed. The impulse of a sliding contact is
/// approximate (two rounds of a projected iteration).
/// @param u      [rows] m/s | rad/s: velocity with the present impulse
/// @param p      [rows] N s | N m s: present impulse
/// @param normal N s: p_n + impact_impulse of the contact of a roll block; unused by the other kinds
/// @param next   [rows, out] N s | N m s: the new impulse
static inline void next_impulse(const RowBlock& b, const double* u, const double* p, double normal, double* next) {
  switch (b.kind) {
    case RowKind::contact: {
      double own[3], c[3];
      multiply_symmetric(b.B, p, own);
      own[0] -= b.compliance * b.B[0] * p[0];  // the diagonal B[0] includes the compliance, the velocity u does not
      for (int r = 0; r < 3; ++r) {
        c[r] = u[r] - own[r];
        next[r] = p[r];
      }
      solve_contact(b, c, next);
      return;
    }
    case RowKind::grip:
      multiply_symmetric(b.inverse, u, next);
      for (int r = 0; r < 3; ++r) next[r] = p[r] - next[r];
      return;
    case RowKind::limit: next[0] = larger(0.0, p[0] - u[0] * b.inverse_normal); return;
    case RowKind::friction: {
      const double x = p[0] - u[0] * b.inverse_normal;
      next[0] = x < -b.bound ? -b.bound : b.bound < x ? b.bound : x;
      return;
    }
    case RowKind::roll: {
      const double maximum = b.mu * normal;
      double square = 0;
      for (int r = 0; r < 3; ++r) {
        next[r] = p[r] - u[r] * b.friction_step;
        square += next[r] * next[r];
      }
      if (square > maximum * maximum) {
        const double scale = maximum / __builtin_sqrt(square);
        for (int r = 0; r < 3; ++r) next[r] *= scale;
      }
      return;
    }
  }
}

}  // namespace ugoki::contact
