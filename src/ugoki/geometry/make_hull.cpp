#include "ugoki/geometry/make_hull.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "ugoki/geometry/planar_hull.h"
#include "ugoki/geometry/point_frame.h"
#include "ugoki/geometry/quickhull.h"

namespace ugoki::geometry {
namespace {

constexpr const char* location = "hull";

/// The points without duplicates: `points` in the caller's frame, `in_frame` in the coordinates of PointFrame.
struct CleanPoints {
  std::vector<Vec3> in_frame, points;
};

CleanPoints clean(std::span<const Vec3> points, const PointFrame& frame) {
  CleanPoints out;
  out.points.assign(points.begin(), points.end());
  std::sort(out.points.begin(), out.points.end(), [](const Vec3& a, const Vec3& b) {
    return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
  });
  out.points.erase(std::unique(out.points.begin(), out.points.end()), out.points.end());
  out.in_frame.reserve(out.points.size());
  for (const Vec3& p : out.points) out.in_frame.push_back(frame.to_frame(p));
  return out;
}

/// Morton code (position on a space-filling Z-order curve) of a point with coordinates in about [-1, 1], 16 bits per coordinate.
std::uint64_t morton(const Vec3& u) {
  std::uint64_t code = 0;
  std::uint32_t cell[3];
  for (int k = 0; k < 3; ++k) cell[k] = static_cast<std::uint32_t>(std::clamp((u[k] + 1.5) / 3, 0.0, 1.0) * 65535);
  for (int bit = 15; bit >= 0; --bit)
    for (int k = 0; k < 3; ++k) code = code << 1 | (cell[k] >> bit & 1);
  return code;
}

/// Makes the hull from its faces: keeps only the vertices used, sorts them by Morton code so that neighbours in space are close in
/// memory, and orients all faces outward.
Result<collision::Hull> assemble(const CleanPoints& clean_points, PolygonHull faces) {
  std::vector<std::int32_t> used(faces.corners);
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  std::vector<std::pair<std::uint64_t, std::int32_t>> order;
  order.reserve(used.size());
  for (const std::int32_t i : used) order.emplace_back(morton(clean_points.in_frame[static_cast<std::size_t>(i)]), i);
  std::sort(order.begin(), order.end());

  std::vector<std::int32_t> new_index(clean_points.points.size(), -1);
  std::vector<Vec3> vertices;
  vertices.reserve(order.size());
  Vec3 inside;
  for (const auto& [code, i] : order) {
    new_index[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(vertices.size());
    vertices.push_back(clean_points.points[static_cast<std::size_t>(i)]);
    inside += clean_points.in_frame[static_cast<std::size_t>(i)];
  }
  inside = inside / static_cast<double>(order.size());
  for (std::size_t f = 0; f + 1 < faces.first_corner.size(); ++f) {
    const auto first = faces.corners.begin() + faces.first_corner[f], last = faces.corners.begin() + faces.first_corner[f + 1];
    const auto at = [&](auto corner) { return clean_points.in_frame[static_cast<std::size_t>(*corner)]; };
    Vec3 area;
    for (auto c = first + 1; c + 1 < last; ++c) area += cross(at(c) - at(first), at(c + 1) - at(first));
    if (dot(area, at(first) - inside) < 0) std::reverse(first, last);
    for (auto c = first; c != last; ++c) *c = new_index[static_cast<std::size_t>(*c)];
  }
  return collision::assemble_hull(std::move(vertices), std::move(faces.first_corner), std::move(faces.corners));
}

Result<collision::Hull> line_hull(const CleanPoints& clean_points) {
  const auto along = [](const Vec3& a, const Vec3& b) { return a.x < b.x; };
  const auto [low, high] = std::minmax_element(clean_points.in_frame.begin(), clean_points.in_frame.end(), along);
  const auto point = [&](auto at) { return clean_points.points[static_cast<std::size_t>(at - clean_points.in_frame.begin())]; };
  return collision::assemble_hull({point(low), point(high)}, {}, {});
}

Result<collision::Hull> flat_hull(const CleanPoints& clean_points) {
  std::vector<PlanarPoint> planar;
  planar.reserve(clean_points.in_frame.size());
  for (std::size_t i = 0; i < clean_points.in_frame.size(); ++i)
    planar.push_back({clean_points.in_frame[i].x, clean_points.in_frame[i].y, static_cast<std::int32_t>(i)});
  const std::vector<std::int32_t> ring = planar_hull(std::move(planar));
  std::vector<Vec3> vertices;
  std::vector<std::int32_t> corners;
  for (const std::int32_t i : ring) vertices.push_back(clean_points.points[static_cast<std::size_t>(i)]);
  const auto n = static_cast<std::int32_t>(ring.size());
  for (std::int32_t i = 0; i < n; ++i) corners.push_back(i);
  for (std::int32_t i = n; i-- > 0;) corners.push_back(i);
  return collision::assemble_hull(std::move(vertices), {0, n, 2 * n}, std::move(corners));
}

Result<collision::Hull> solid_hull(const CleanPoints& clean_points, const HullOptions& options) {
  for (const bool triangles : {false, true}) {
    std::optional<PolygonHull> faces = quickhull(clean_points.in_frame, options.max_vertices, triangles);
    if (!faces) continue;
    if (faces->too_many)
      return fail(ErrorCode::range, location, "The convex hull has more than " + std::to_string(options.max_vertices) + " vertices.",
                  "Simplify the mesh.");
    if (Result<collision::Hull> hull = assemble(clean_points, std::move(*faces)); hull) return hull;
  }
  return fail(ErrorCode::structure, location, "No convex hull was found: its facets cannot be distinguished from rounding errors.",
              "Merge points that are closer together than 1e-12 of the shape's size.");
}

}  // namespace

Result<collision::Hull> make_hull(std::span<const Vec3> points, const HullOptions& options) {
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!is_finite(points[i]) || dot(points[i], points[i]) > 1e200)
      return fail(ErrorCode::range, "point " + std::to_string(i), "A coordinate is not finite or is beyond 1e100 m.", "Correct the point.");
  if (points.size() < 4)
    return fail(ErrorCode::structure, location, "A convex hull needs at least 4 points; " + std::to_string(points.size()) + " were given.",
                "Add points, or use a sphere or a capsule.");
  if (points.size() > 500'000'000)
    return fail(ErrorCode::range, location, "The mesh has " + std::to_string(points.size()) + " points; at most 500 million are allowed.",
                "Simplify the mesh.");
  const PointFrame frame = find_frame(points);
  if (frame.dimension == 0)
    return fail(ErrorCode::structure, location, "All points are equal, so they have no convex hull.",
                "Use a sphere, or give different points.");
  const CleanPoints clean_points = clean(points, frame);
  if (frame.dimension == 1) return line_hull(clean_points);
  if (frame.dimension == 2) return flat_hull(clean_points);
  return solid_hull(clean_points, options);
}

}  // namespace ugoki::geometry
