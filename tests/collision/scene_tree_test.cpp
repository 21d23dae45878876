// The superior tree over a scene, compared with find_contacts() and with brute force.

#include "ugoki/collision/scene_tree.h"

#include <gtest/gtest.h>

#include "../mechanism/chain.h"
#include "random_shapes.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::collision {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

MechanismPtr chain(test::Random& random, const Vec3& base, bool fixed_first) {
  return testing::make_chain(6, [&](int i, LinkSpec& l) {
    l.joint.type = i == 0 && fixed_first ? JointType::fixed : JointType::revolute;
    l.joint.axis = random.unit();
    l.joint.X_PJ.p = i == 0 ? base : Vec3{0.35, 0, 0};
    l.inertia = Inertia::from_centre(1, {0.2, 0, 0}, {0.01, 0.01, 0.01, 0, 0, 0});
    l.shapes = {i % 2 == 0 ? Shape::capsule(0.04, {0.05, 0, 0}, {0.3, 0, 0}) : Shape::cylinder(0.05, 0.1, {Mat3::identity(), {0.2, 0, 0}})};
  });
}

TEST(SceneTree, MatchesFindContactsAndBruteForce) {
  test::Random random(2);
  SceneOptions options;
  options.with_ground = false;
  options.self_collision = true;
  Scene scene({chain(random, {}, true), chain(random, {0.1, 0.15, 0}, true), chain(random, {0, -0.15, 0.1}, false)}, {}, options);
  scene.set_self_collision(1, false);
  SceneTree tree(scene);
  Workspace workspace(scene);
  DistanceWorkspace distances;
  std::vector<std::vector<double>> q, v;
  std::vector<std::vector<Pose>> X;
  for (const MechanismPtr& m : scene.systems()) {
    q.push_back(m->neutral());
    for (double& x : v.emplace_back(static_cast<std::size_t>(m->nv()))) x = random.in(-1, 1);
    X.emplace_back(static_cast<std::size_t>(m->link_count()));
  }
  std::vector<ContactPoint> contacts;
  std::vector<NearPair> pairs;
  std::size_t max_pairs = 0;
  for (int step = 0; step < 300; ++step) {
    std::vector<std::span<const Pose>> poses;
    for (std::size_t s = 0; s < q.size(); ++s) {
      integrate(*scene.systems()[s], q[s], v[s], 0.02, q[s]);
      calc_poses(*scene.systems()[s], q[s], X[s]);
      poses.push_back(X[s]);
    }
    tree.update(poses);
    const double margin = 0.2;
    tree.pairs_within(margin, pairs);
    max_pairs = std::max(max_pairs, pairs.size());
    find_contacts(scene, poses, margin, workspace, contacts);
    // Each pair in the list has a contact, and each contact belongs to a pair in the list.
    const auto links = [&](const NearPair& p) {
      const SceneShape &a = scene.shapes()[static_cast<std::size_t>(p.bodies.a)], &b = scene.shapes()[static_cast<std::size_t>(p.bodies.b)];
      return std::array<int, 4>{a.system, a.link, b.system, b.link};
    };
    for (const NearPair& p : pairs) {
      if (p.near.distance > margin - 1e-6) continue;
      EXPECT_TRUE(std::ranges::any_of(contacts, [&](const ContactPoint& c) {
        return std::array<int, 4>{c.system_a, c.link_a, c.system_b, c.link_b} == links(p);
      })) << step;
    }
    for (const ContactPoint& c : contacts) {
      if (c.distance > margin - 1e-6) continue;
      EXPECT_TRUE(std::ranges::any_of(pairs, [&](const NearPair& p) {
        return std::array<int, 4>{c.system_a, c.link_a, c.system_b, c.link_b} == links(p);
      })) << step;
    }
    // Expected closest pairs, found by measuring all pairs.
    for (const auto& [a, b] : std::vector<std::pair<int, int>>{{0, 1}, {2, 0}, {2, 2}}) {
      double minimum = infinity;
      for (int i = scene.first_shape(a); i < scene.first_shape(a + 1); ++i)
        for (int j = scene.first_shape(b); j < scene.first_shape(b + 1); ++j) {
          const auto is_pair = [&](const ShapePair& p) { return p.a == i && p.b == j; };
          if (a == b && std::ranges::none_of(scene.self_pairs(a), is_pair)) continue;
          const SceneShape &s = scene.shapes()[static_cast<std::size_t>(i)], &t = scene.shapes()[static_cast<std::size_t>(j)];
          PairCache cache;
          minimum =
              std::min(minimum, find_pair_distance(s, poses[static_cast<std::size_t>(a)][static_cast<std::size_t>(s.link)] * s.shape.X_BS,
                                                   t, poses[static_cast<std::size_t>(b)][static_cast<std::size_t>(t.link)] * t.shape.X_BS,
                                                   infinity, cache, distances)
                                    .distance);
        }
      EXPECT_NEAR(tree.nearest(a, b).near.distance, minimum, 1e-10) << step;
    }
  }
  EXPECT_GT(max_pairs, 5u);
}

}  // namespace
}  // namespace ugoki::collision
