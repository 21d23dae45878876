#include "ugoki/formats/mesh_end.h"

#include <algorithm>
#include <cmath>

namespace ugoki::formats {

std::optional<Vec3> far_end(std::span<const Vec3> points) {
  constexpr double far = 0.85;  // share of the largest distance
  double reach = 0;
  for (const Vec3& p : points) reach = std::max(reach, norm(p));
  if (!(reach > 0) || !std::isfinite(reach)) return std::nullopt;
  Vec3 sum;
  double count = 0;
  for (const Vec3& p : points)
    if (norm(p) > far * reach) {
      sum += p;
      count += 1;
    }
  return sum / count;
}

}  // namespace ugoki::formats
