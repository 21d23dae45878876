#include "ugoki/robot_formats/mjcf_mesh.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ugoki::robot_formats {
namespace {

std::array<Vec3, 3> corners(std::span<const Vec3> points, const MeshTriangle& t) {
  return {points[static_cast<std::size_t>(t[0])], points[static_cast<std::size_t>(t[1])], points[static_cast<std::size_t>(t[2])]};
}

/// Convex hull, built by adding one point after the other (beneath-beyond method of Preparata and Hong, without its facet graph).
class Hull {
 public:
  explicit Hull(std::span<const Vec3> points) : points_(points), count_(static_cast<int>(points.size())) {}

  std::vector<MeshTriangle> run() {
    if (!begin()) return {};
    for (int i = 0; i < count_; ++i) add(i);
    std::vector<MeshTriangle> out;
    for (const Face& f : faces_) out.push_back(f.corners);
    return out;
  }

 private:
  struct Face {
    MeshTriangle corners;
    Vec3 normal;  // unit, outwards
    double height = 0;
  };

  [[nodiscard]] const Vec3& at(int i) const { return points_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] double above(const Face& f, int i) const { return dot(f.normal, at(i)) - f.height; }

  void put(int a, int b, int c) {
    const Vec3 n = normalized(cross(at(b) - at(a), at(c) - at(a)));
    faces_.push_back({{a, b, c}, n, dot(n, at(a))});
  }

  /// Returns the index of the point for which `measure` is largest.
  template <class Measure>
  [[nodiscard]] int farthest(const Measure& measure) const {
    int best = 0;
    for (int i = 1; i < count_; ++i)
      if (measure(at(i)) > measure(at(best))) best = i;
    return best;
  }

  /// Makes the initial tetrahedron. Returns false if all points are in one plane (to 1e-9 of the size of the point set).
  bool begin() {
    if (count_ < 4) return false;
    const int a = farthest([](const Vec3& p) { return -p.x; });
    const Vec3 A = at(a);
    const int b = farthest([&](const Vec3& p) { return norm(p - A); });
    const double size = norm(at(b) - A);
    tolerance_ = 1e-12 * size;
    const Vec3 u = normalized(at(b) - A);
    const int c = farthest([&](const Vec3& p) { return norm(cross(p - A, u)); });
    const Vec3 n = normalized(cross(u, at(c) - A));
    const int d = farthest([&](const Vec3& p) { return std::fabs(dot(p - A, n)); });
    if (!(size > 0) || !(norm(cross(at(c) - A, u)) > 1e-9 * size) || !(std::fabs(dot(at(d) - A, n)) > 1e-9 * size)) return false;
    if (dot(at(d) - A, n) < 0) {
      put(a, b, c), put(b, a, d), put(c, b, d), put(a, c, d);
    } else {
      put(a, c, b), put(a, b, d), put(b, c, d), put(c, a, d);
    }
    return true;
  }

  void add(int i) {
    std::vector<std::pair<int, int>> rim;  // directed edges of the faces that are visible from the point
    std::size_t kept = 0;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      if (above(faces_[f], i) > tolerance_) {
        const MeshTriangle& t = faces_[f].corners;
        for (std::size_t k = 0; k < 3; ++k) rim.emplace_back(t[k], t[(k + 1) % 3]);
      } else {
        faces_[kept++] = faces_[f];
      }
    }
    if (kept == faces_.size()) return;
    faces_.resize(kept);
    std::ranges::sort(rim);
    for (const auto& [from, to] : rim)
      if (!std::ranges::binary_search(rim, std::pair{to, from})) put(from, to, i);
  }

  std::span<const Vec3> points_;
  int count_;
  std::vector<Face> faces_;
  double tolerance_ = 0;
};

}  // namespace

std::vector<MeshTriangle> convex_hull(std::span<const Vec3> points) { return Hull(points).run(); }

Inertia mesh_inertia(std::span<const Vec3> points, std::span<const MeshTriangle> triangles, MeshInertia kind) {
  // The reference point is the centre of the surface: `legacy` is defined relative to it, and for the other kinds this choice reduces
  // rounding errors.
  Vec3 weighted, centre;  // weighted: integral of the position over the surface
  double area = 0;
  for (const MeshTriangle& t : triangles) {
    const auto [a, b, c] = corners(points, t);
    const double twice = norm(cross(b - a, c - a));
    weighted += (a + b + c) * (twice / 6);
    area += twice / 2;
  }
  if (area > 0) centre = weighted / area;

  double mass = 0;
  Vec3 first;
  Mat3 second = Mat3::diagonal(0, 0, 0);  // integral of r r^T, r: position relative to the reference point
  for (const MeshTriangle& t : triangles) {
    const auto [A, B, C] = corners(points, t);
    const Vec3 a = A - centre, b = B - centre, c = C - centre, sum = a + b + c;
    double m = 0;
    double of_first = 0, of_second = 0;
    if (kind == MeshInertia::shell) {
      m = norm(cross(b - a, c - a)) / 2;
      of_first = m / 3, of_second = m / 12;
    } else {
      m = dot(a, cross(b, c)) / 6;
      if (kind == MeshInertia::legacy) m = std::fabs(m);
      of_first = m / 4, of_second = m / 20;
    }
    mass += m;
    first += sum * of_first;
    second += (Mat3::outer(a, a) + Mat3::outer(b, b) + Mat3::outer(c, c) + Mat3::outer(sum, sum)) * of_second;
  }
  const double trace = second.trace();
  const Inertia about_centre{mass, first, symmetric_part(Mat3::diagonal(trace, trace, trace) - second)};
  return about_centre.in_parent({Mat3::identity(), centre});
}

}  // namespace ugoki::robot_formats
