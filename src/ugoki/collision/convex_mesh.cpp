#include "ugoki/collision/convex_mesh.h"

#include <algorithm>

#include "ugoki/collision/mesh_point.h"

namespace ugoki::collision {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }
/// Vector in lane i of the block's array v.
Vec3 lane3(const float (*v)[block_lanes], int i) {
  return {static_cast<double>(v[0][i]), static_cast<double>(v[1][i]), static_cast<double>(v[2][i])};
}

/// Search of the tree for the triangle closest to the shape. Frame: that of the mesh, with the tree's centre as origin. Lengths in m.
class Search {
 public:
  Search(const Support& shape, const Pose& X, const SphereTree& tree, const BubbleOptions& options, double above, ConvexMeshWorkspace& work)
      : shape_(shape),
        X_(X),
        tree_(tree),
        centre_(X * centre_of(shape)),
        radius_(bounding_radius(shape)),
        slack_(4e-7 * tree.radius),
        shrink_(1 / (1 + std::max(0.0, options.relative_error))),
        work_(work) {
    best.distance = above;
  }

  /// Measures the distance between the shape and triangle t, and stores the result in `best` if it is the minimum so far.
  /// @param cache warm start, possibly from another triangle
  void try_triangle(std::int32_t t, const GilbertCache& cache) {
    Hull& h = work_.corners;
    for (int k = 0; k < 3; ++k) h.vertices[static_cast<std::size_t>(k)] = tree_.corner(t, k);
    h.centre = (h.vertices[0] + h.vertices[1] + h.vertices[2]) / 3;
    h.radius = std::max({norm(h.vertices[0] - h.centre), norm(h.vertices[1] - h.centre), norm(h.vertices[2] - h.centre)});
    GilbertCache warm = cache;
    const GilbertResult d = gilbert_distance(shape_, X_, Support::of(h), {}, warm, {.tolerance = 1e-12, .farthest = limit()});
    ++triangle_tests;
    const bool near = d.status == GilbertStatus::separated || d.status == GilbertStatus::not_converged;
    const double distance = d.status == GilbertStatus::touching || (near && d.distance <= 0) ? 0 : near ? d.distance : best.distance;
    if (!(distance < best.distance)) return;
    best = d;
    best.distance = distance;
    best.lower = distance > 0 ? std::max(d.lower, 0.0) : 0;
    triangle = t;
    gilbert = warm;
    if (distance > 0) reach_ = dot(-d.n, X_ * find_support(shape_, transpose_times(X_.R, -d.n)).p) + shape_.radius;
  }

  void run() {
    work_.stack.clear();
    work_.stack.push_back({0, 0});
    while (!work_.stack.empty() && best.distance > 0) {
      const ConvexMeshWorkspace::Entry e = work_.stack.back();
      work_.stack.pop_back();
      if (e.lower >= limit()) continue;
      const BoundBlock& block = tree_.blocks[at(e.lane / block_lanes)];
      const int lane = e.lane % block_lanes;
      const std::int32_t child = block.child[lane];
      if (child < 0) {
        try_triangle(-1 - child, gilbert);
      } else if (e.lane == 0 || box_distance(block, lane) < limit()) {
        expand(child);
      }
    }
  }

  GilbertResult best;  // best.distance: m, minimum distance so far; the search radius while triangle == -1
  GilbertCache gilbert;
  std::int32_t triangle = -1;
  int bound_tests = 0, triangle_tests = 0;
  [[nodiscard]] double shrink() const { return shrink_; }

 private:
  /// Search radius: bounds at this distance [m] or farther are skipped.
  [[nodiscard]] double limit() const { return triangle >= 0 ? best.distance * shrink_ : best.distance; }

  /// Lower bound [m] of the distance of the shape from a bound's box, by Gilbert's method with a coarse tolerance.
  double box_distance(const BoundBlock& block, int lane) {
    const Vec3 x = lane3(block.axis[0], lane), y = lane3(block.axis[1], lane);
    const Pose box{Mat3::columns(x, y, cross(x, y)), lane3(block.box, lane)};
    GilbertCache cold;
    const GilbertResult d =
        gilbert_distance(shape_, X_, Support::box(lane3(block.half, lane)), box, cold, {.tolerance = 1e-3, .farthest = limit()});
    ++bound_tests;
    return d.status == GilbertStatus::touching ? 0 : d.lower - slack_;
  }

  /// Pushes the bounds of a block on the stack, the closest on top. The lower bound of each distance is the larger of two values: the
  /// distance between the bounding spheres, and the separation along the direction of the closest pair of points so far.
  void expand(std::int32_t index) {
    const BoundBlock& block = tree_.blocks[at(index)];
    const std::size_t first = work_.stack.size();
    for (int i = 0; i < block.count; ++i) {
      double lower = norm(lane3(block.sphere, i) - centre_) - radius_ - static_cast<double>(block.radius[i]) - slack_;
      if (triangle >= 0) {
        const Vec3 x = lane3(block.axis[0], i), y = lane3(block.axis[1], i), h = lane3(block.half, i), u = -best.n;
        const double extent = std::fabs(dot(u, x)) * h.x + std::fabs(dot(u, y)) * h.y + std::fabs(dot(u, cross(x, y))) * h.z;
        lower = std::max(lower, dot(u, lane3(block.box, i)) - extent - reach_ - slack_);
      }
      ++bound_tests;
      if (lower >= limit()) continue;
      work_.stack.push_back({index * block_lanes + i, std::max(lower, 0.0)});
      for (std::size_t k = work_.stack.size() - 1; k > first && work_.stack[k - 1].lower < work_.stack[k].lower; --k)
        std::swap(work_.stack[k - 1], work_.stack[k]);
    }
  }

  const Support& shape_;
  Pose X_;
  const SphereTree& tree_;
  Vec3 centre_;
  double radius_, slack_, shrink_;  // radius_: m, bounding radius; slack_: m, rounding of bounds; shrink_: 1 / (1 + relative_error)
  double reach_ = 0;                // m: maximum coordinate of the shape along -best.n
  ConvexMeshWorkspace& work_;
};

/// True for a bounded core with finite sizes below 1e9 m.
bool is_bounded(const Support& s) {
  const double sum = s.radius + s.size.x + s.size.y + s.size.z + (s.kind == SupportKind::hull && s.hull != nullptr ? s.hull->radius : 0);
  return s.kind != SupportKind::half_space && sum < 1e9;
}

/// Distance of a sphere from a mesh: the distance of the sphere's centre from the mesh, less the radius.
BubbleDistance point_distance(double radius, const Pose& X_WA, const SphereTree& b, const Pose& X_WB, ConvexMeshCache& cache,
                              ConvexMeshWorkspace& workspace, const BubbleOptions& options) {
  BubbleDistance out;
  const Vec3 p = transpose_times(X_WB.R, X_WA.p - X_WB.p);
  const SurfacePoint x = find_nearest_point(b, p, cache.triangle, workspace.of_point, options.farthest + radius);
  out.nearest.b = x.triangle;
  if (x.triangle < 0) {
    out.status = BubbleStatus::beyond;
    out.distance = out.lower = options.farthest;
    return out;
  }
  out.distance = out.lower = std::max(x.distance - radius, 0.0);
  out.status = out.distance > 0 ? BubbleStatus::separated : BubbleStatus::touching;
  const Vec3 n = x.distance > 0 ? X_WB.R * ((p - x.q) / x.distance) : Vec3{};
  if (out.distance > 0) out.n = n;
  out.pb = X_WB * x.q;
  out.pa = out.distance > 0 ? X_WA.p - n * radius : out.pb;
  return out;
}

}  // namespace

ConvexMeshWorkspace::ConvexMeshWorkspace() {
  corners.dimension = 2;
  corners.vertices.resize(3);
}

BubbleDistance find_distance(const Support& a, const Pose& X_WA, const SphereTree& b, const Pose& X_WB, ConvexMeshCache& cache,
                             ConvexMeshWorkspace& workspace, const BubbleOptions& options) {
  BubbleDistance out;
  if (b.empty() || !is_bounded(a) || !can_be_placed(X_WA) || !can_be_placed(X_WB) || std::isnan(options.farthest)) return out;
  if (a.kind == SupportKind::point) return point_distance(a.radius, X_WA, b, X_WB, cache, workspace, options);
  const Pose X_WC{X_WB.R, X_WB * b.centre};  // frame of the mesh with the tree's centre as origin
  const Pose X{X_WC.R.transposed() * X_WA.R, transpose_times(X_WC.R, X_WA.p - X_WC.p)};
  const double reach = norm(X * centre_of(a)) + bounding_radius(a) + b.radius;
  Search search(a, X, b, options, std::min(std::max(options.farthest, 0.0), 2 * reach), workspace);
  if (cache.triangle >= 0 && at(cache.triangle) < b.triangles.size()) search.try_triangle(cache.triangle, cache.gilbert);
  search.run();
  out.bound_tests = search.bound_tests;
  out.triangle_tests = search.triangle_tests;
  if (search.triangle < 0) {
    out.status = BubbleStatus::beyond;
    out.distance = out.lower = search.best.distance;
    return out;
  }
  cache = {search.triangle, search.gilbert};
  out.nearest.b = search.triangle;
  out.distance = search.best.distance;
  out.lower = std::min(search.best.lower, out.distance * search.shrink());
  out.pa = X_WC * search.best.pa;
  out.pb = X_WC * search.best.pb;
  out.status = out.distance > 0 ? BubbleStatus::separated : BubbleStatus::touching;
  if (out.distance > 0) out.n = X_WC.R * search.best.n;
  return out;
}

}  // namespace ugoki::collision
