#include "ugoki/geometry/point_frame.h"

#include <algorithm>
#include <cmath>

#include "ugoki/spatial/rotation.h"

namespace ugoki::geometry {
namespace {

/// Returns the point with the maximum value of `measure`.
template <class Measure>
Vec3 farthest(std::span<const Vec3> points, Measure measure) {
  Vec3 best = points.front();
  double maximum = -1;
  for (const Vec3& p : points)
    if (const double m = measure(p); m > maximum) maximum = m, best = p;
  return best;
}

}  // namespace

PointFrame find_frame(std::span<const Vec3> points) {
  PointFrame frame;
  double coordinate = 0;
  for (const Vec3& p : points) coordinate = std::max({coordinate, std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
  const double noise = 4e-16 * coordinate;

  const Vec3 first = farthest(points, [&](const Vec3& p) { return norm(p - points.front()); });
  const Vec3 far = farthest(points, [&](const Vec3& p) { return norm(p - first); });
  frame.origin = (first + far) * 0.5;
  const double length = norm(far - first);
  if (!(length > 0)) return frame;
  frame.dimension = 1;
  frame.axes[0] = (far - first) / length;
  frame.scale[0] = 2 / length;

  const auto from_line = [&](const Vec3& p) { return cross(frame.axes[0], p - first); };
  const Vec3 side = farthest(points, [&](const Vec3& p) { return norm(from_line(p)); });
  const double width = norm(from_line(side));
  frame.axes[2] = normalized(from_line(side), any_perpendicular(frame.axes[0]));
  frame.axes[1] = cross(frame.axes[2], frame.axes[0]);
  if (!(width > 4 * noise)) return frame;
  frame.dimension = 2;
  frame.scale[1] = 1 / width;

  const Vec3 normal = frame.axes[2];
  const Vec3 top = farthest(points, [&](const Vec3& p) { return std::fabs(dot(normal, p - first)); });
  const double height = std::fabs(dot(normal, top - first));
  if (!(height > 4 * noise * std::fmax(1, length / width))) return frame;
  frame.dimension = 3;
  frame.scale[2] = 1 / height;
  return frame;
}

}  // namespace ugoki::geometry
