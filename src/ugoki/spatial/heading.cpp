#include "ugoki/spatial/heading.h"

namespace ugoki {

Vec3 heading_of(const Mat3& R) {
  const Quat q = to_quat(R);
  const double square = q.w * q.w + q.z * q.z;
  if (square < 1e-12) return {1, 0, 0};
  return {(q.w * q.w - q.z * q.z) / square, 2 * q.w * q.z / square, 0};
}

Vec3 perpendicular_along(const Vec3& n, const Vec3& direction) {
  const Vec3 t = direction - n * dot(n, direction);
  const double length = norm(t);
  return length > 1e-6 * norm(direction) ? t / length : any_perpendicular(n);
}

}  // namespace ugoki
