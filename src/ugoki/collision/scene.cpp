#include "ugoki/collision/scene.h"

#include <algorithm>
#include <array>
#include <utility>

#include "ugoki/base/check.h"
#include "ugoki/base/hash.h"
#include "ugoki/collision/broad_phase.h"
#include "ugoki/collision/core.h"
#include "ugoki/collision/distance.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::collision {
namespace {

/// The bodies of a mechanism (links welded together) and the joints between them.
struct Bodies {
  static constexpr int no_body = -2;
  std::vector<int> body;                    // [links] body of the link: index of the body's first link; -1: the world
  std::vector<std::pair<int, int>> joined;  // pairs of bodies that a joint or a loop joint connects, smaller index first
  std::vector<Vec3> joint_origin;           // [links] m: origin of the joint of the link's body; frame: parent body's first link
  std::vector<int> parent_of;               // [links] body to which the joint of the link's body is attached; no_body: floating

  explicit Bodies(const Mechanism& m) {
    const auto count = static_cast<std::size_t>(m.link_count());
    std::vector<Pose> X_body(count);  // pose of each link in the frame of its body's first link
    for (std::size_t i = 0; i < count; ++i) {
      const Link& link = m.links()[i];
      const auto p = static_cast<std::size_t>(link.parent);
      const int parent_body = link.parent < 0 ? -1 : body[p];
      const Pose X_parent = link.parent < 0 ? Pose{} : X_body[p];
      const bool welded = link.joint.nv() == 0;
      body.push_back(welded ? parent_body : static_cast<int>(i));
      const bool floats = link.joint.type == JointType::floating;
      parent_of.push_back(welded && link.parent >= 0 ? parent_of[p] : floats ? no_body : parent_body);
      X_body[i] = welded ? X_parent * link.joint.X_PJ : Pose{};
      const Vec3 origin = X_parent * link.joint.X_PJ.p;
      joint_origin.push_back(welded && link.parent >= 0 ? joint_origin[p] : origin);
    }
    for (std::size_t i = 0; i < count; ++i) {  // a virtual link is a second body of its real link (LinkSpec::real)
      const Link& link = m.links()[i];
      if (link.real >= 0) join(parent_of[i], body[static_cast<std::size_t>(link.real)]);
      join(parent_of[i], body[i]);
    }
    for (const Loop& loop : m.loops())  // a loop joint joins its two links; a gear or a distance constraint does not
      if (loop.type != LoopType::gear && loop.type != LoopType::distance && loop.link_a >= 0 && loop.link_b >= 0)
        join(body[static_cast<std::size_t>(loop.link_a)], body[static_cast<std::size_t>(loop.link_b)]);
    for (std::size_t i = 0; i < count; ++i) {
      const Link& link = m.links()[i];
      if (link.real >= 0) body[i] = body[static_cast<std::size_t>(link.real)];
    }
    std::sort(joined.begin(), joined.end());
  }

  static std::pair<int, int> ordered(int a, int b) { return {std::min(a, b), std::max(a, b)}; }
  void join(int a, int b) { joined.push_back(ordered(a, b)); }

  [[nodiscard]] bool adjacent(int link_a, int link_b) const {
    const auto a = static_cast<std::size_t>(link_a), b = static_cast<std::size_t>(link_b);
    if (body[a] == body[b]) return true;
    if (std::binary_search(joined.begin(), joined.end(), ordered(body[a], body[b]))) return true;
    return parent_of[a] == parent_of[b] && parent_of[a] != no_body && norm(joint_origin[a] - joint_origin[b]) < 1e-6;
  }
};

}  // namespace

Scene::Scene(std::vector<MechanismPtr> systems, const Ground& ground, const SceneOptions& options)
    : systems_(std::move(systems)), ground_(ground), options_(options) {
  for (std::size_t s = 0; s < systems_.size(); ++s) {
    const Mechanism& m = *systems_[s];
    const Bodies bodies(m);
    first_shape_.push_back(static_cast<int>(shapes_.size()));
    self_on_.push_back(options.self_collision ? 1 : 0);
    for (int i = 0; i < m.link_count(); ++i) {
      for (const Shape& shape : m.link(i).shapes) {
        if (!shape.collides) continue;
        SceneShape& out = shapes_.emplace_back(SceneShape{make_collider(shape)});
        out.system = static_cast<int>(s);
        out.link = i;
        out.movable = bodies.body[static_cast<std::size_t>(i)] >= 0;
        out.ground_friction = std::sqrt(shape.friction * ground.friction);
        out.ground_restitution = std::max(shape.restitution, ground.restitution);
      }
    }
    UGOKI_CHECK(shapes_.size() < (1U << 20) - 1);  // ContactPoint::key has 20 bits for a shape's index

    std::vector<Pose> X_WB(static_cast<std::size_t>(m.link_count()));
    calc_poses(m, m.neutral(), X_WB);
    std::vector<ShapePair>& pairs = self_pairs_.emplace_back();
    for (std::size_t i = static_cast<std::size_t>(first_shape_.back()); i < shapes_.size(); ++i) {
      for (std::size_t j = i + 1; j < shapes_.size(); ++j) {
        const SceneShape &a = shapes_[i], &b = shapes_[j];
        if (bodies.adjacent(a.link, b.link) || !can_collide(a.shape, b.shape)) continue;
        if (std::ranges::binary_search(m.exclusions(), std::array{a.link, b.link})) continue;  // a.link <= b.link
        const double d = distance(a, X_WB[static_cast<std::size_t>(a.link)], b, X_WB[static_cast<std::size_t>(b.link)]);
        if (d > 1e-9) pairs.push_back({static_cast<std::int32_t>(i), static_cast<std::int32_t>(j)});
      }
    }
  }
  first_shape_.push_back(static_cast<int>(shapes_.size()));
  if (std::ranges::any_of(shapes_, [](const SceneShape& s) { return !s.convex; }))
    for (SceneShape& s : shapes_)
      if (s.convex) s.core = make_core(s);
  for (const SceneShape& s : shapes_) outlines_.push_back({s.shape.X_BS * s.centre, s.bound, s.shape.X_BS.p, s.reach, s.link, s.movable});
  Hash64 content;
  for (const SceneShape& s : shapes_) {
    content.add((static_cast<std::uint64_t>(s.system) << 8) | static_cast<std::uint64_t>(s.shape.type));
    content.add(s.movable ? s.bound : -s.bound);
    content.add(s.support.hull != nullptr ? s.support.hull->hash : 0);
  }
  for (const std::vector<ShapePair>& pairs : self_pairs_)
    for (const ShapePair& p : pairs) content.add((static_cast<std::uint64_t>(p.a) << 32) | static_cast<std::uint64_t>(p.b));
  content_ = content.value();
}

void Workspace::forget() {
  pairs.forget();
  std::fill(lowest.begin(), lowest.end(), 0);
}

Workspace::Workspace() = default;
Workspace::Workspace(Workspace&&) noexcept = default;
Workspace& Workspace::operator=(Workspace&&) noexcept = default;
Workspace::~Workspace() = default;
Workspace::Workspace(const Scene& scene) : balls(scene.shapes().size()), poses(balls.size()), posed(balls.size()), extents(scene.systems().size()) {}

}  // namespace ugoki::collision
