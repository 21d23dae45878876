#include "ugoki/samples/curves.h"

#include <algorithm>

namespace ugoki::samples {

double quintic(const Jet& from, const Jet& to, double s) {
  // Polynomial of degree 5: x0 + v0 s + a0/2 s^2 + c3 s^3 + c4 s^4 + c5 s^5
  const double dx = to.x - from.x - from.v - 0.5 * from.a, dv = to.v - from.v - from.a, da = to.a - from.a;
  const double c3 = 10 * dx - 4 * dv + 0.5 * da, c4 = -15 * dx + 7 * dv - da, c5 = 6 * dx - 3 * dv + 0.5 * da;
  return from.x + s * (from.v + s * (0.5 * from.a + s * (c3 + s * (c4 + s * c5))));
}

double smooth_step(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * s * (10 + s * (-15 + 6 * s));
}

double bump(double s) {
  s = std::clamp(s, 0.0, 1.0);
  const double p = s * (1 - s);
  return 64 * p * p * p;
}

double fraction(double x) { return x - std::floor(x); }

LimbPosture reach(const Vec3& root, const Vec3& end, double upper, double lower, const Vec3& side, int bend) {
  const Vec3 line = end - root;
  const double distance = norm(line);
  const double d = std::clamp(distance, std::fabs(upper - lower) * 1.001, (upper + lower) * 0.99999);
  const Vec3 down = normalized(line, {0, 0, -1});
  const Vec3 y = normalized(side - down * dot(side, down));
  const Mat3 R = Mat3::columns(cross(y, -down), y, -down);
  const double inner = acos((upper * upper + lower * lower - d * d) / (2 * upper * lower));
  const double tilt = acos((upper * upper + d * d - lower * lower) / (2 * upper * d));
  LimbPosture out;
  out.R_upper = R * rotation_about({0, 1, 0}, -bend * tilt);
  out.flexion = bend * (pi - inner);
  out.reach = distance / (upper + lower);
  return out;
}

}  // namespace ugoki::samples
