#include "ugoki/collision/mesh_point.h"

#include <algorithm>

namespace ugoki::collision {
namespace {

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

TriangleCorners corners_of(const SphereTree& tree, std::int32_t t) { return {tree.corner(t, 0), tree.corner(t, 1), tree.corner(t, 2)}; }

Vec3 face_normal(const SphereTree& tree, std::int32_t t) {
  const TriangleCorners c = corners_of(tree, t);
  return normalized(cross(c[1] - c[0], c[2] - c[0]), {});
}

/// Outward angle-weighted pseudonormal of a closed mesh at a feature of triangle t, unit. Source: Baerentzen, Aanaes (2005).
Vec3 pseudo_normal(const SphereTree& tree, std::int32_t t, TriangleFeature feature) {
  const auto f = static_cast<std::size_t>(feature);
  if (feature >= TriangleFeature::corner_0) return tree.vertex_normals[at(tree.triangles[at(t)][f - 4])];
  const Vec3 n = face_normal(tree, t);
  return feature == TriangleFeature::face ? n : normalized(n + face_normal(tree, tree.across[at(t)][f - 1]), n);
}

/// Squared lower bounds [m^2] of the distances from point p to the boxes of a block. Lanes that are not in use are computed too.
void point_gaps(const BoundBlock& b, const float (&p)[3], float (&gap2)[block_lanes]) {
  for (int i = 0; i < block_lanes; ++i) {
    const float x = p[0] - b.box[0][i], y = p[1] - b.box[1][i], z = p[2] - b.box[2][i];
    const float ax = b.axis[0][0][i], ay = b.axis[0][1][i], az = b.axis[0][2][i];
    const float bx = b.axis[1][0][i], by = b.axis[1][1][i], bz = b.axis[1][2][i];
    const float u = std::fabs(x * ax + y * ay + z * az) - b.half[0][i];
    const float v = std::fabs(x * bx + y * by + z * bz) - b.half[1][i];
    const float w = std::fabs(x * (ay * bz - az * by) + y * (az * bx - ax * bz) + z * (ax * by - ay * bx)) - b.half[2][i];
    const float gu = u > 0 ? u : 0, gv = v > 0 ? v : 0, gw = w > 0 ? w : 0;
    gap2[i] = gu * gu + gv * gv + gw * gw;
  }
}

/// Depth-first search (nearest bounds first) for the triangle nearest to a point p; p is relative to the tree's centre.
class PointSearch {
 public:
  PointSearch(const SphereTree& tree, const Vec3& p, double farthest, std::vector<KernelEntry>& stack)
      : tree_(tree), p_(p), slack_(static_cast<float>(4e-6 * (norm(p) + tree.radius))), best_(farthest), stack_(stack) {
    for (int k = 0; k < 3; ++k) pf_[k] = static_cast<float>(p[k]);
  }
  void try_triangle(std::int32_t t) {
    const TrianglePoint x = nearest_on_triangle(corners_of(tree_, t), p_);
    const double d = norm(p_ - x.p);
    if (!(d < best_)) return;
    best_ = d;
    nearest = x;
    triangle = t;
  }
  void run() {
    stack_.clear();
    stack_.push_back({0, 0, 0});
    while (!stack_.empty()) {
      const KernelEntry e = stack_.back();
      stack_.pop_back();
      if (e.gap2 >= limit2()) continue;
      const std::int32_t child = tree_.blocks[at(e.a / block_lanes)].child[e.a % block_lanes];
      if (child < 0)
        try_triangle(-1 - child);
      else
        expand(child);
    }
  }
  TrianglePoint nearest;
  std::int32_t triangle = -1;

 private:
  [[nodiscard]] float limit2() const {
    const float limit = static_cast<float>(best_) * 1.000001F + slack_;
    return limit * limit;
  }
  void expand(std::int32_t index) {
    const BoundBlock& block = tree_.blocks[at(index)];
    float gap2[block_lanes];
    point_gaps(block, pf_, gap2);
    const float limit = limit2();
    const std::size_t first = stack_.size();
    for (std::int32_t i = 0; i < block.count; ++i) {
      if (!(gap2[i] < limit)) continue;
      stack_.push_back({index * block_lanes + i, 0, gap2[i]});
      for (std::size_t k = stack_.size() - 1; k > first && stack_[k - 1].gap2 < stack_[k].gap2; --k) std::swap(stack_[k - 1], stack_[k]);
    }
  }

  const SphereTree& tree_;
  Vec3 p_;
  float pf_[3];
  float slack_;
  double best_;
  std::vector<KernelEntry>& stack_;
};

/// Search for the vertex of mesh `tree` that is deepest inside mesh `other`. Points are in the frame of `other`, relative to the centre
/// of its tree; X maps points of `tree` (relative to its centre) to that frame.
class DeepestVertex {
 public:
  DeepestVertex(const SphereTree& tree, const SphereTree& other, const Pose& X, double above, BubbleWorkspace& workspace)
      : tree_(tree), other_(other), X_(X), depth(above), workspace_(workspace) {}

  void run() {
    auto& stack = workspace_.penetration;
    stack.clear();
    push(0, 0);
    while (!stack.empty()) {
      const KernelEntry e = stack.back();
      stack.pop_back();
      if (!(static_cast<double>(e.gap2) > depth)) continue;
      const std::int32_t child = tree_.blocks[at(e.a / block_lanes)].child[e.a % block_lanes];
      if (child < 0) {
        for (const std::int32_t v : tree_.triangles[at(-1 - child)]) try_vertex(v);
        continue;
      }
      const std::size_t first = stack.size();
      for (std::int32_t i = 0; i < tree_.blocks[at(child)].count; ++i) push(child, i);
      std::sort(stack.begin() + static_cast<std::ptrdiff_t>(first), stack.end(),
                [](const KernelEntry& x, const KernelEntry& y) { return x.gap2 != y.gap2 ? x.gap2 < y.gap2 : x.a < y.a; });
    }
  }

 private:
  /// Depth [m] of a point inside the other mesh; negative outside.
  double depth_of(const Vec3& p, SurfacePoint& found) {
    ++points;
    found = find_nearest_point(other_, p + other_.centre, warm_, workspace_);
    return found.inside ? found.distance : -found.distance;
  }
  /// Pushes a bound on the stack, unless no point of it can be deeper than `depth`. KernelEntry::gap2 stores the upper bound [m] of the
  /// depth.
  void push(std::int32_t block, std::int32_t lane) {
    const BoundBlock& b = tree_.blocks[at(block)];
    const Vec3 c =
        X_ * Vec3{static_cast<double>(b.sphere[0][lane]), static_cast<double>(b.sphere[1][lane]), static_cast<double>(b.sphere[2][lane])};
    const double r = static_cast<double>(b.radius[lane]) * (1 + 1e-6);
    if (norm(c) - r > other_.radius) return;
    SurfacePoint found;
    const auto max_depth = static_cast<float>((depth_of(c, found) + r) * (1 + 1e-6));
    if (static_cast<double>(max_depth) > depth) workspace_.penetration.push_back({block * block_lanes + lane, 0, max_depth});
  }
  void try_vertex(std::int32_t v) {
    const Vec3 p = X_ * tree_.vertices[at(v)];
    if (norm(p) > other_.radius) return;
    SurfacePoint found;
    const double d = depth_of(p, found);
    if (!(d > depth)) return;
    depth = d;
    vertex = p;
    surface = found.q - other_.centre;
    any = true;
  }

  const SphereTree &tree_, &other_;
  Pose X_;
  std::int32_t warm_ = -1;

 public:
  double depth;  // m: the maximum depth found so far; only deeper vertices are recorded
  Vec3 vertex, surface;
  bool any = false;
  int points = 0;

 private:
  BubbleWorkspace& workspace_;
};

}  // namespace

SurfacePoint find_nearest_point(const SphereTree& mesh, const Vec3& p, std::int32_t& warm, BubbleWorkspace& workspace, double farthest) {
  SurfacePoint out;
  const Vec3 local = p - mesh.centre;
  if (mesh.empty() || !(norm(local) < 1e9) || std::isnan(farthest)) return out;
  PointSearch search(mesh, local, std::min(farthest, 1e10), workspace.stack_of_points);
  if (warm >= 0 && at(warm) < mesh.triangles.size()) search.try_triangle(warm);
  search.run();
  if (search.triangle < 0) return out;
  warm = out.triangle = search.triangle;
  out.feature = search.nearest.feature;
  out.q = search.nearest.p + mesh.centre;
  out.distance = norm(local - search.nearest.p);
  if (mesh.closed) {
    out.n = pseudo_normal(mesh, out.triangle, out.feature);
    out.inside = dot(local - search.nearest.p, out.n) < 0;
  }
  return out;
}

MeshPenetration find_penetration(const SphereTree& a, const Pose& X_WA, const SphereTree& b, const Pose& X_WB, BubbleWorkspace& workspace) {
  MeshPenetration out;
  if (a.empty() || b.empty() || !can_be_placed(X_WA) || !can_be_placed(X_WB)) return out;
  out.status = PenetrationStatus::not_closed;
  if (!a.closed || !b.closed) return out;
  out.status = PenetrationStatus::apart;
  const Pose X_WC{X_WA.R, X_WA * a.centre}, X_WD{X_WB.R, X_WB * b.centre};
  const Pose X_AB{X_WA.R.transposed() * X_WB.R, transpose_times(X_WA.R, X_WD.p - X_WC.p)};
  if (norm(X_AB.p) > a.radius + b.radius) return out;
  DeepestVertex of_a(a, b, X_AB.inverse(), 0, workspace);
  of_a.run();
  DeepestVertex of_b(b, a, X_AB, of_a.depth, workspace);
  of_b.run();
  out.points = of_a.points + of_b.points;
  if (of_b.any) {
    out.depth = of_b.depth;
    out.pb = X_WC * of_b.vertex;
    out.pa = X_WC * of_b.surface;
  } else if (of_a.any) {
    out.depth = of_a.depth;
    out.pa = X_WD * of_a.vertex;
    out.pb = X_WD * of_a.surface;
  } else {
    return out;
  }
  out.status = PenetrationStatus::penetrating;
  out.n = normalized(out.pb - out.pa);
  return out;
}

}  // namespace ugoki::collision
