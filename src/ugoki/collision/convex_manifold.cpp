#include "ugoki/collision/convex_manifold.h"

#include <algorithm>
#include <array>

#include "ugoki/collision/clipping.h"
#include "ugoki/collision/four_points.h"

namespace ugoki::collision {
namespace {

constexpr double parallel_sin2 = 0.03;  // squared sine of 10 degrees: edges at a smaller angle touch along a line, others at a point

/// Adds up to four of the candidates below the margin to `out`, by choose_four() in the projection along n.
void add_four(const Candidates& c, const Vec3& n, double margin, const Vec3& contact_normal, Manifold& out) {
  const Vec3 u = any_perpendicular(n), v = cross(n, u);
  std::array<FlatPoint, 2 * Patch::max_corners> points;
  std::array<int, 2 * Patch::max_corners> index;  // index of each point in c
  std::size_t count = 0;
  for (int i = 0; i < c.count; ++i) {
    if (!(c.at(i).h < margin)) continue;
    index[count] = i;
    points[count++] = {dot(u, c.at(i).p), dot(v, c.at(i).p), c.at(i).h};
  }
  int chosen[4];
  choose_four({points.data(), count}, chosen);
  for (const int i : chosen) {
    if (i < 0) continue;
    const Candidate& point = c.at(index[static_cast<std::size_t>(i)]);
    out.add(point.p - n * (0.5 * point.h), contact_normal, point.h, point.feature);
  }
}

/// True if the separation along one direction proves that the shapes overlap by at most -`margin` [m] (margin < 0). The direction is the
/// last separating direction, or the line of their centres. The test avoids the exact penetration depth when only deep overlaps are
/// requested.
bool is_depth_below(const Support& a, const Pose& X_a, const Support& b, const Pose& X_b, double margin, const GilbertCache& cache) {
  const bool known = dot(cache.n, cache.n) > 0.5;
  const Vec3 n = known ? X_a.R * cache.n : normalized(X_a * centre_of(a) - X_b * centre_of(b));
  const bool hint = known && cache.count > 0;
  const Vec3 low = X_a * find_support(a, transpose_times(X_a.R, -n), hint ? cache.a[0] : 0).p;
  const Vec3 high = X_b * find_support(b, transpose_times(X_b.R, n), hint ? cache.b[0] : 0).p;
  return dot(n, low - high) - a.radius - b.radius >= margin;
}

bool has_face(const Patch& p) { return p.count > 2; }
/// True if both patches are edges, and these are parallel to within 10 degrees.
bool are_parallel_edges(const Patch& a, const Patch& b) {
  if (a.count != 2 || b.count != 2) return false;
  const Vec3 u = normalized(a.at(1).p - a.at(0).p), v = normalized(b.at(1).p - b.at(0).p), s = cross(u, v);
  return dot(s, s) < parallel_sin2;
}

}  // namespace

void add_convex_convex(const Collider& a, const Pose& X_a, const Collider& b, const Pose& X_b, double margin, GilbertCache& cache,
                       PenetrationWorkspace& workspace, Manifold& out) {
  if (margin < 0 && is_depth_below(a.support, X_a, b.support, X_b, margin, cache)) return;
  GilbertOptions options;
  options.farthest = margin;
  const SignedDistance d = signed_distance(a.support, X_a, b.support, X_b, cache, workspace, options);
  const bool known =
      d.status == DistanceStatus::separated || d.status == DistanceStatus::penetrating || d.status == DistanceStatus::not_converged;
  if (!known || !(d.distance < margin)) return;

  const double bias = 1e-4 * std::min(a.thickness, b.thickness);
  Patch on_a, on_b;
  find_patch(a, X_a, -d.n, cache.count > 0 ? cache.a[0] : 0, on_a);
  find_patch(b, X_b, d.n, cache.count > 0 ? cache.b[0] : 0, on_b);
  Candidates points;
  // The reference is the face whose normal is closer to d.n. The face of b is used only if the sine of its angle to
  // d.n is smaller by 1e-4, so that rounding does not make the contacts alternate between the two faces.
  const auto lean = [&](const Patch& p) { return norm(cross(p.normal, d.n)); };
  const bool b_first = has_face(on_b) && has_face(on_a) && lean(on_b) < lean(on_a) - 1e-4;
  for (const bool of_b : {b_first, !b_first}) {
    const Patch &reference = of_b ? on_b : on_a, &incident = of_b ? on_a : on_b;
    if (!has_face(reference) || incident.count < 2) continue;
    cut(reference, incident, reference.normal, of_b ? 2 : 1, points);
    if (std::fabs(min_height(points) - d.distance) <= bias)
      return add_four(points, reference.normal, margin, of_b ? reference.normal : -reference.normal, out);
  }
  if (are_parallel_edges(on_a, on_b)) {
    cut(on_b, on_a, d.n, 3, points);
    if (points.count == 2 && std::fabs(min_height(points) - d.distance) <= bias) return add_four(points, d.n, margin, d.n, out);
  }
  out.add((d.pa + d.pb) * 0.5, d.n, d.distance, 0);
}

void add_convex_ground(const Collider& a, const Pose& X, double height, double margin, std::int32_t& hint,
                       std::vector<ManifoldPoint>& scratch, Manifold& out) {
  constexpr Vec3 up{0, 0, 1};
  const auto add = [&](const Vec3& p, std::uint32_t feature) {
    const double distance = p.z - height;
    if (distance < margin) scratch.push_back({{p.x, p.y, height + 0.5 * distance}, up, distance, feature});
  };
  scratch.clear();
  const Vec3 down = transpose_times(X.R, -up);
  const Support& s = a.support;
  const SupportPoint lowest = find_support(s, down, hint);
  hint = lowest.vertex;
  const Vec3 low = X * lowest.p - up * s.radius;
  if (!(low.z - height < margin)) return;
  if (s.kind == SupportKind::hull) {
    for (std::size_t i = 0; i < s.hull->vertices.size(); ++i) add(X * s.hull->vertices[i], static_cast<std::uint32_t>(i) & 0xffffffU);
    return add_spanning(scratch, 1e-4 * a.thickness, out);
  }
  if (s.kind == SupportKind::cylinder) {
    const double r = s.size.x, z = down.z < 0 ? -s.size.z : s.size.z, horizontal = std::sqrt(down.x * down.x + down.y * down.y);
    const std::uint32_t end = down.z < 0 ? 0 : 8;
    add(X * Vec3{r, 0, z}, end);
    add(X * Vec3{0, r, z}, end + 1);
    add(X * Vec3{-r, 0, z}, end + 2);
    add(X * Vec3{0, -r, z}, end + 3);
    if (horizontal > 1e-6) {  // tilted (sine of the angle above 1e-6): also both ends of the lowest line on the side
      add(X * Vec3{r * down.x / horizontal, r * down.y / horizontal, z}, end + 4);
      add(X * Vec3{r * down.x / horizontal, r * down.y / horizontal, -z}, end + 5);
    }
    for (const ManifoldPoint& p : scratch) out.add(p.p, p.n, p.distance, p.feature);
    return;
  }
  add(low, 0);
  for (const ManifoldPoint& p : scratch) out.add(p.p, p.n, p.distance, p.feature);
}

}  // namespace ugoki::collision
