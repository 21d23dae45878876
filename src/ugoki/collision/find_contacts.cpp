#include <algorithm>
#include <memory>
#include <tuple>

#include "ugoki/base/check.h"
#include "ugoki/collision/broad_phase.h"
#include "ugoki/collision/near_self_pairs.h"
#include "ugoki/collision/scene.h"

namespace ugoki::collision {
namespace {

constexpr std::uint64_t ground_index = (1U << 20) - 1;

/// ContactPoint::key: 20 bits for each shape, 24 bits for the feature.
std::uint64_t make_key(std::uint64_t a, std::uint64_t b, std::uint32_t feature) { return (a << 44) | (b << 24) | feature; }

/// Clears the warm starts if they belong to another scene.
void reset_if_other_scene(const Scene& scene, Workspace& work) {
  if (work.content == scene.content()) return;
  work.content = scene.content();
  work.pairs.clear();
  work.near_self.assign(scene.systems().size(), {});
  work.lowest.assign(scene.shapes().size(), 0);
}

/// Row z of a rotation matrix: the world's up direction in the link's frame.
Vec3 heights(const Mat3& R) { return {R.zx, R.zy, R.zz}; }

/// Height [m, world] of a shape's lowest point, computed without the shape's full pose. For a mesh or height field it is the lowest point
/// of the bounding box.
/// @param origin m, world: height of the shape's origin
/// @param up_B unit: the world's up direction in the link's frame
double lowest_height(const SceneShape& shape, double origin, const Vec3& up_B) {
  const Shape& s = shape.shape;
  const Vec3 up = transpose_times(s.X_BS.R, up_B);
  const Vec3& h = shape.half;
  switch (s.type) {
    case ShapeType::sphere: return origin - s.radius;
    case ShapeType::capsule: return origin - s.radius - s.half_length * std::fabs(up.z);
    case ShapeType::cylinder:
    case ShapeType::ellipsoid: return origin - reach(s, -up);
    case ShapeType::box:
    case ShapeType::mesh:
    case ShapeType::height_field:
      return origin + dot(up, shape.centre) - (h.x * std::fabs(up.x) + h.y * std::fabs(up.y) + h.z * std::fabs(up.z));
  }
  return origin;
}

/// State of one call of find_contacts().
struct Search {
  const Scene& scene;
  std::span<const std::span<const Pose>> X_WB;
  double margin;
  Workspace& work;
  std::vector<ContactPoint>& out;
  std::span<const char> moved;
  Manifold manifold;

  [[nodiscard]] bool is_still(int system) const { return !moved.empty() && moved[static_cast<std::size_t>(system)] == 0; }

  [[nodiscard]] const Pose& link_pose(const SceneShape& s) const {
    return X_WB[static_cast<std::size_t>(s.system)][static_cast<std::size_t>(s.link)];
  }

  /// First shape of a system, and the one behind its last.
  [[nodiscard]] std::pair<std::size_t, std::size_t> shapes_of(std::size_t system) const {
    return {static_cast<std::size_t>(scene.first_shape(static_cast<int>(system))),
            static_cast<std::size_t>(scene.first_shape(static_cast<int>(system) + 1))};
  }

  /// Pose of shape i in the world. Most shapes are near no other one, and need no pose.
  const Pose& shape_pose(std::size_t i) {
    if (work.posed[i] != work.call) {
      const SceneShape& s = scene.shapes()[i];
      work.poses[i] = link_pose(s) * s.shape.X_BS;
      work.posed[i] = work.call;
    }
    return work.poses[i];
  }

  /// Appends the points of `manifold` to `out`.
  /// @param b null: the ground
  void add(const SceneShape& a, std::uint64_t index_a, const SceneShape* b, std::uint64_t index_b, double friction, double restitution) {
    for (int i = 0; i < manifold.count; ++i) {
      const ManifoldPoint& point = manifold.points[static_cast<std::size_t>(i)];
      ContactPoint& c = out.emplace_back();
      c.system_a = a.system;
      c.link_a = a.link;
      if (b != nullptr) {
        c.system_b = b->system;
        c.link_b = b->link;
      }
      c.p = point.p;
      c.n = point.n;
      c.distance = point.distance;
      c.friction = friction;
      c.restitution = restitution;
      c.key = make_key(index_a, index_b, point.feature);
    }
  }

  /// Contacts of all shapes with the ground.
  void ground() {
    const double height = scene.ground().height, limit = height + margin;
    for (std::size_t system = 0; system < X_WB.size(); ++system) {
      if (is_still(static_cast<int>(system))) continue;
      const auto [first, end] = shapes_of(system);
      for (std::size_t i = first; i < end; ++i) {
        const ShapeOutline& o = scene.outlines()[i];
        const Pose& X = X_WB[system][static_cast<std::size_t>(o.link)];
        const Vec3 up = heights(X.R);
        const double origin = dot(up, o.origin) + X.p.z;
        if (!(origin - o.reach < limit) || !o.movable) continue;
        const SceneShape& s = scene.shapes()[i];
        if (!(lowest_height(s, origin, up) < limit)) continue;
        find_ground_manifold(s, X * s.shape.X_BS, height, margin, work.lowest[i], work.manifold, manifold);
        add(s, i, nullptr, ground_index, s.ground_friction, s.ground_restitution);
      }
    }
  }

  /// True if the bounding spheres of shapes i and j are closer than the margin.
  [[nodiscard]] bool bounds_near(std::size_t i, std::size_t j) const {
    const Workspace::Ball &ball_a = work.balls[i], &ball_b = work.balls[j];
    const Vec3 gap = ball_a.c - ball_b.c;
    const double reach = std::max(ball_a.r + ball_b.r + margin, 0.0);
    return dot(gap, gap) < reach * reach;
  }

  /// Contacts of shapes i and j.
  void pair(std::size_t i, std::size_t j) {
    const SceneShape &a = scene.shapes()[i], &b = scene.shapes()[j];
    if (!can_collide(a.shape, b.shape)) return;
    if (is_simple(a.shape.type) && is_simple(b.shape.type)) {
      find_manifold(a.shape, shape_pose(i), b.shape, shape_pose(j), margin, manifold);
    } else {
      GilbertCache& cache = work.pairs.at(make_key(i, j, 1));
      find_manifold(a, shape_pose(i), b, shape_pose(j), margin, cache, work.manifold, manifold);
    }
    if (manifold.count == 0) return;
    add(a, i, &b, j, pair_friction(a.shape, b.shape), std::max(a.shape.restitution, b.shape.restitution));
  }

  /// Computes the bounding spheres of all shapes and the extents of all systems.
  void bounds() {
    for (std::size_t s = 0; s < X_WB.size(); ++s) {
      Vec3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
      const auto [first, end] = shapes_of(s);
      for (std::size_t i = first; i < end; ++i) {
        const ShapeOutline& o = scene.outlines()[i];
        const Vec3 c = X_WB[s][static_cast<std::size_t>(o.link)] * o.centre;
        const double r = o.bound;
        work.balls[i] = {c, r};
        low = {std::min(low.x, c.x - r), std::min(low.y, c.y - r), std::min(low.z, c.z - r)};
        high = {std::max(high.x, c.x + r), std::max(high.y, c.y + r), std::max(high.z, c.z + r)};
      }
      work.extents[s] = {low, high};
    }
  }

  /// Contacts between the shapes of one system.
  void within(int system) {
    const auto s = static_cast<std::size_t>(system);
    const auto [first, end] = shapes_of(s);
    const std::span<const Workspace::Ball> balls(work.balls);
    for (const ShapePair& p :
         near_self_pairs(scene.self_pairs(system), balls.subspan(first, end - first), first, margin, work.near_self[s]))
      if (const auto a = static_cast<std::size_t>(p.a), b = static_cast<std::size_t>(p.b); bounds_near(a, b)) pair(a, b);
  }

  [[nodiscard]] bool near(const Workspace::Extent& a, const Workspace::Extent& b) const {
    return a.low.x < b.high.x + margin && b.low.x < a.high.x + margin && a.low.y < b.high.y + margin && b.low.y < a.high.y + margin &&
           a.low.z < b.high.z + margin && b.low.z < a.high.z + margin;
  }

  [[nodiscard]] bool near(std::size_t shape, int system) const {
    const Workspace::Ball& ball = work.balls[shape];
    const Vec3 r{ball.r, ball.r, ball.r};
    return near({ball.c - r, ball.c + r}, work.extents[static_cast<std::size_t>(system)]);
  }

  /// Contacts between the shapes of two systems.
  void between(int system_a, int system_b) {
    if (!near(work.extents[static_cast<std::size_t>(system_a)], work.extents[static_cast<std::size_t>(system_b)])) return;
    for (int i = scene.first_shape(system_a); i < scene.first_shape(system_a + 1); ++i) {
      const auto a = static_cast<std::size_t>(i);
      if (!near(a, system_b)) continue;
      const bool a_moves = scene.outlines()[a].movable;
      for (int j = scene.first_shape(system_b); j < scene.first_shape(system_b + 1); ++j) {
        const auto b = static_cast<std::size_t>(j);
        if (bounds_near(a, b) && (a_moves || scene.outlines()[b].movable)) pair(a, b);
      }
    }
  }

  /// Contacts of all pairs, without a broad phase.
  void all_pairs() {
    const int systems = static_cast<int>(X_WB.size());
    for (int s = 0; s < systems; ++s)
      if (scene.self_collision(s) && !is_still(s)) within(s);
    if (!scene.options().between_systems) return;
    for (int a = 0; a < systems; ++a)
      for (int b = a + 1; b < systems; ++b)
        if (!is_still(a) || !is_still(b)) between(a, b);
  }

  /// The same contacts as all_pairs(), in the same order. The candidate pairs come from the superior tree (broad_phase.h).
  void crowd() {
    const std::span<const SceneShape> shapes = scene.shapes();
    if (!work.broad_phase) work.broad_phase = std::make_unique<BroadPhase>();
    const std::span<const BodyPair> candidates = work.broad_phase->find(scene, std::span(work.balls).first(shapes.size()), margin);
    const auto system = [&](std::int32_t i) { return shapes[static_cast<std::size_t>(i)].system; };
    const auto first = [](const ShapePair& p) { return std::pair(p.a, p.b); };
    work.near.clear();
    for (const BodyPair& p : candidates) {
      const auto a = static_cast<std::size_t>(p.a), b = static_cast<std::size_t>(p.b);
      const int of_a = system(p.a), of_b = system(p.b);
      if ((is_still(of_a) && is_still(of_b)) || !bounds_near(a, b)) continue;
      if (of_a != of_b
              ? scene.options().between_systems && near(a, of_b)
              : BroadPhase::covers(scene, of_a) && std::ranges::binary_search(scene.self_pairs(of_a), std::pair(p.a, p.b), {}, first))
        work.near.push_back({p.a, p.b});
    }
    const auto before = [&](const ShapePair& p, const ShapePair& q) {
      const int pa = system(p.a), pb = system(p.b), qa = system(q.a), qb = system(q.b);
      return std::tuple(pa != pb, pa, pb, p.a, p.b) < std::tuple(qa != qb, qa, qb, q.a, q.b);
    };
    if (!std::ranges::is_sorted(work.near, before)) std::ranges::sort(work.near, before);
    auto next = work.near.begin();
    const auto add_pair = [&](const ShapePair& p) { pair(static_cast<std::size_t>(p.a), static_cast<std::size_t>(p.b)); };
    for (int s = 0; s < static_cast<int>(X_WB.size()); ++s) {
      if (!scene.self_collision(s) || is_still(s)) continue;
      if (!BroadPhase::covers(scene, s)) within(s);
      for (; next != work.near.end() && system(next->b) == s && system(next->a) == s; ++next) add_pair(*next);
    }
    for (; next != work.near.end(); ++next) add_pair(*next);
  }
};

}  // namespace

void begin_from(const Scene& scene, std::span<const std::span<const Pose>> X_WB, std::span<const ContactPoint> contacts, Workspace& work) {
  reset_if_other_scene(scene, work);
  std::uint64_t last = 0;
  for (const ContactPoint& c : contacts) {
    const std::uint64_t a = c.key >> 44, b = (c.key >> 24) & ground_index, key = make_key(a, b, 1);
    if (b == ground_index || key == last) continue;
    last = key;
    const SceneShape &sa = scene.shapes()[static_cast<std::size_t>(a)], &sb = scene.shapes()[static_cast<std::size_t>(b)];
    if ((is_simple(sa.shape.type) && is_simple(sb.shape.type)) || !sa.convex || !sb.convex) continue;
    const Pose& X = X_WB[static_cast<std::size_t>(sa.system)][static_cast<std::size_t>(sa.link)];
    work.pairs.at(key).n = transpose_times(sa.shape.X_BS.R, transpose_times(X.R, c.n));
  }
}

void find_contacts(const Scene& scene, std::span<const std::span<const Pose>> X_WB, double margin, Workspace& work,
                   std::vector<ContactPoint>& out, std::span<const char> moved) {
  UGOKI_CHECK(X_WB.size() == scene.systems().size());
  if (work.balls.size() < scene.shapes().size()) {
    work.balls.resize(scene.shapes().size());
    work.poses.resize(scene.shapes().size());
    work.posed.resize(scene.shapes().size());
  }
  ++work.call;
  reset_if_other_scene(scene, work);
  if (work.extents.size() < X_WB.size()) work.extents.resize(X_WB.size());
  if (work.near_self.size() < X_WB.size()) work.near_self.resize(X_WB.size());
  out.clear();
  // Memory for 12 points per shape: the 8 corners of a box on the ground, and four points with other shapes. More contacts make `out` grow.
  if (out.capacity() < 12 * scene.shapes().size()) out.reserve(12 * scene.shapes().size());

  Search search{scene, X_WB, margin, work, out, moved, {}};
  if (scene.options().with_ground) search.ground();
  const int systems = static_cast<int>(X_WB.size());
  const bool between = scene.options().between_systems && systems > 1;
  bool self = false;
  for (int s = 0; s < systems; ++s) self = self || scene.self_collision(s);
  if (!between && !self) return;
  search.bounds();
  if (BroadPhase::is_faster(scene))
    search.crowd();
  else
    search.all_pairs();
}

}  // namespace ugoki::collision
