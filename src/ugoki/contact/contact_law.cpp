#include "ugoki/contact/contact_law.h"

#include <algorithm>
#include <cmath>

namespace ugoki::contact {

/// Projects (x, y) onto the disk of the given radius about the origin.
void clamp_to_disk(double& x, double& y, double radius) {
  const double size = std::sqrt(x * x + y * y);
  if (size <= radius) return;
  const double scale = radius / size;
  x *= scale;
  y *= scale;
}

namespace {

/// out = S x for a symmetric 3 x 3 matrix with entries 00 11 22 01 02 12.
inline void multiply(const double* S, const double* x, double* out) {
  out[0] = S[0] * x[0] + S[3] * x[1] + S[4] * x[2];
  out[1] = S[3] * x[0] + S[1] * x[1] + S[5] * x[2];
  out[2] = S[4] * x[0] + S[5] * x[1] + S[2] * x[2];
}

/// Solves a sliding contact whose friction acts on the normal velocity about as strongly as the normal impulse does. The alternating
/// iteration of solve_contact() may then oscillate and end at p = 0 with the contact still closing. Here friction is at its bound and
/// opposed to c_t, so that the normal impulse p_n is the only unknown (c: velocity without the contact's impulse; B: inverse inertia):
///   0 = c_n + (B_nn - mu B_nt . c_t / |c_t|) p_n
void slide(const RowBlock& b, const double* c, double* p) {
  const double speed = std::sqrt(c[1] * c[1] + c[2] * c[2]);
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
void solve_contact(const RowBlock& b, const double* c, double* p) {
  if (b.impact_impulse == 0 && c[0] >= 0) {
    p[0] = p[1] = p[2] = 0;
    return;
  }
  double stick[3];
  multiply(b.inverse, c, stick);
  const double cone = b.mu * (b.impact_impulse - stick[0]);
  if (stick[0] <= 0 && stick[1] * stick[1] + stick[2] * stick[2] <= cone * cone) {
    for (int r = 0; r < 3; ++r) p[r] = -stick[r];
    return;
  }
  const double mean = 0.5 * (b.B[1] + b.B[2]), half = 0.5 * (b.B[1] - b.B[2]);
  const double step = 1 / (mean + std::sqrt(half * half + b.B[5] * b.B[5]));
  for (int k = 0; k < 2; ++k) {
    p[0] = std::max(0.0, -(c[0] + b.B[3] * p[1] + b.B[4] * p[2]) / b.B[0]);
    const double u1 = c[1] + b.B[3] * p[0] + b.B[1] * p[1] + b.B[5] * p[2];
    const double u2 = c[2] + b.B[4] * p[0] + b.B[5] * p[1] + b.B[2] * p[2];
    p[1] -= step * u1;
    p[2] -= step * u2;
    clamp_to_disk(p[1], p[2], b.mu * (p[0] + b.impact_impulse));
  }
  if (p[0] == 0 && b.impact_impulse == 0) slide(b, c, p);
}

}  // namespace

double velocity_change(const RowBlock& b, const double* change) {
  if (b.rows == 1) return std::fabs(b.B[0] * change[0]);
  double u[3];
  multiply(b.B, change, u);
  return std::max({std::fabs(u[0]), std::fabs(u[1]), std::fabs(u[2])});
}

void next_impulse(const RowBlock& b, const double* u, const double* p, double normal, double* next) {
  switch (b.kind) {
    case RowKind::contact: {
      double own[3], c[3];
      multiply(b.B, p, own);
      own[0] -= b.compliance * b.B[0] * p[0];  // the diagonal B[0] includes the compliance, the velocity u does not
      for (int r = 0; r < 3; ++r) {
        c[r] = u[r] - own[r];
        next[r] = p[r];
      }
      solve_contact(b, c, next);
      break;
    }
    case RowKind::grip:
      multiply(b.inverse, u, next);
      for (int r = 0; r < 3; ++r) next[r] = p[r] - next[r];
      break;
    case RowKind::limit: next[0] = std::max(0.0, p[0] - u[0] / b.B[0]); break;
    case RowKind::friction: next[0] = std::clamp(p[0] - u[0] / b.B[0], -b.bound, b.bound); break;
    case RowKind::roll: {
      const double maximum = b.mu * normal;
      const double stiff = std::max({b.B[0], b.B[1], b.B[2]});
      double square = 0;
      for (int r = 0; r < 3; ++r) {
        next[r] = p[r] - u[r] / stiff;
        square += next[r] * next[r];
      }
      if (square > maximum * maximum) {
        const double scale = maximum / std::sqrt(square);
        for (int r = 0; r < 3; ++r) next[r] *= scale;
      }
      break;
    }
  }
}

}  // namespace ugoki::contact
