#include "ugoki/collision/support.h"

#include <cmath>
#include <limits>

#include "ugoki/base/check.h"
#include "ugoki/collision/support_point.h"

namespace ugoki::collision {

SupportPoint find_support(const Support& s, const Vec3& d, std::int32_t hint) {
  UGOKI_ASSERT(s.kind != SupportKind::half_space);
  return support_point(s, d, hint);
}

Vec3 centre_of(const Support& s) { return s.kind == SupportKind::hull ? s.hull->centre : Vec3{}; }

double bounding_radius(const Support& s) {
  switch (s.kind) {
    case SupportKind::point: return s.radius;
    case SupportKind::segment: return s.size.z + s.radius;
    case SupportKind::box: return norm(s.size) + s.radius;
    case SupportKind::cylinder: return std::sqrt(s.size.x * s.size.x + s.size.z * s.size.z) + s.radius;
    case SupportKind::ellipsoid: {
      const double m = s.size.x > s.size.y ? s.size.x : s.size.y;
      return (m > s.size.z ? m : s.size.z) + s.radius;
    }
    case SupportKind::hull: return s.hull->radius + s.radius;
    case SupportKind::half_space: break;
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace ugoki::collision
