#pragma once
// Rotation vectors r [rad] as coordinates of a rotation R = exp(r). The rate of r follows from the angular velocity w [rad/s, body axes]
// by the inverse of the right Jacobian of the exponential map:
//   r' = Jr^-1(r) w = w + (r x w) / 2 + c r x (r x w),   c = (1 - (t/2) cot(t/2)) / t^2,   t = |r| < 2 pi.
// Source: Iserles, Munthe-Kaas, Norsett, Zanna, Lie-group methods (2000), section B.

#include "ugoki/spatial/elementary.h"
#include "ugoki/spatial/vec3.h"

namespace ugoki::dynamics {

/// The coefficient c of the formula above, as a function of t^2. Below t = 0.5 rad it uses a power series (Bernoulli numbers), because
/// there the closed form loses digits by cancellation.
inline double rotation_chart_coefficient(double t2) {
  if (t2 < 0.25) {
    constexpr double b[] = {1.0 / 12, 1.0 / 720, 1.0 / 30240, 1.0 / 1209600, 1.0 / 47900160, 691.0 / 1307674368000, 1.0 / 74724249600};
    double sum = 0;
    for (int i = 6; i >= 0; --i) sum = sum * t2 + b[i];
    return sum;
  }
  const double half = 0.5 * std::sqrt(t2);
  const SinCos sc = sin_cos(half);
  return (1 - half * sc.cos / sc.sin) / t2;
}

/// Rate r' of the rotation vector of a body that rotates with angular velocity w in body axes.
inline Vec3 rotation_vector_rate(const Vec3& r, const Vec3& w) {
  const Vec3 rw = cross(r, w);
  return w + rw * 0.5 + cross(r, rw) * rotation_chart_coefficient(dot(r, r));
}

/// Torque in body axes that is equivalent to a generalised force f on the components of r: Jr^-T f, so that f . r' = torque . w.
inline Vec3 rotation_vector_torque(const Vec3& r, const Vec3& f) {
  const Vec3 rf = cross(r, f);
  return f - rf * 0.5 + cross(r, rf) * rotation_chart_coefficient(dot(r, r));
}

}  // namespace ugoki::dynamics
