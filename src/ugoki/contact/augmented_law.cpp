#include "ugoki/contact/augmented_law.h"

#include <algorithm>
#include <cmath>

namespace ugoki::contact {
namespace {

/// The law |p| <= radius, isotropic, for `count` rows from `first` on.
void project_to_ball(const double* hat, const double* u, int first, int count, double R, double radius, double* p, double* G) {
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
}

void contact_impulse(const RowBlock& b, const AugmentedLaw& law, const double* u, double* p, double* G) {
  const double *const hat = law.hat, R = law.regularization * b.B[0], Rn = R + b.compliance * b.B[0];
  const double Rt = law.regularization * std::max(b.B[1], b.B[2]), xn = R * hat[0] - u[0] - law.shift;
  std::fill_n(G, 9, 0.0);
  // After an impact the friction cone includes the impact's impulse, so that its tip is not at p = 0: use a disk of the last radius.
  if (b.impact_impulse > 0) {
    p[0] = std::max(0.0, xn / Rn);
    G[0] = p[0] > 0 ? 1 / Rn : 0;
    return project_to_ball(hat, u, 1, 2, Rt, b.mu * (hat[0] + b.impact_impulse), p, G);
  }
  // Projection onto the cone |y_t| <= m y_n, where y = sqrt(R) p and m is mu in these coordinates.
  const double root_n = std::sqrt(Rn), root_t = std::sqrt(Rt), m = b.mu * root_t / root_n;
  const double yn = xn / root_n, y1 = (Rt * hat[1] - u[1]) / root_t, y2 = (Rt * hat[2] - u[2]) / root_t;
  const double yt = std::sqrt(y1 * y1 + y2 * y2);
  if (yn >= 0 && yt <= m * yn) {  // without friction m is 0, and yt may be 0 although the contact separates
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
}

}  // namespace

void augmented_impulse(const RowBlock& b, const AugmentedLaw& law, const double* u, double* p, double* G) {
  switch (b.kind) {
    case RowKind::contact: return contact_impulse(b, law, u, p, G);
    case RowKind::limit: {
      const double R = law.regularization * b.B[0];
      p[0] = std::max(0.0, law.hat[0] - u[0] / R);
      G[0] = p[0] > 0 ? 1 / R : 0;
      return;
    }
    case RowKind::grip: return project_to_ball(law.hat, u, 0, 3, law.regularization * std::max({b.B[0], b.B[1], b.B[2]}), HUGE_VAL, p, G);
    case RowKind::friction: return project_to_ball(law.hat, u, 0, 1, law.regularization * b.B[0], b.bound, p, G);
    case RowKind::roll:
      return project_to_ball(law.hat, u, 0, 3, law.regularization * std::max({b.B[0], b.B[1], b.B[2]}), b.mu * law.normal, p, G);
  }
}

double sliding_shift(const RowBlock& b, const double* p, const double* u) {
  const double cone = 0.999 * b.mu * p[0];  // below 1 for rounding: a contact on the edge of its cone slides
  if (b.impact_impulse > 0 || p[1] * p[1] + p[2] * p[2] < cone * cone) return 0;
  return b.mu * std::sqrt(u[1] * u[1] + u[2] * u[2]);
}

}  // namespace ugoki::contact
