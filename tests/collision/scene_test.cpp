#include "ugoki/collision/scene.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>
#include <tuple>

#include "allocation_count.h"
#include "random_shapes.h"
#include "ugoki/collision/distance.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::collision {
namespace {

Pose at(double x, double y, double z) { return {Mat3::identity(), {x, y, z}}; }

LinkSpec link(const char* name, const char* parent, JointType type, const Pose& X_PJ, std::vector<Shape> shapes) {
  LinkSpec l;
  l.name = name;
  l.parent = parent;
  l.joint.type = type;
  l.joint.X_PJ = X_PJ;
  l.joint.axis = {0, 1, 0};
  l.inertia = Inertia::from_centre(1, {}, {0.1, 0.1, 0.1, 0, 0, 0});
  l.shapes = std::move(shapes);
  return l;
}
MechanismPtr make(MechanismSpec spec) {
  auto m = Mechanism::make(std::move(spec));
  if (!m) {
    ADD_FAILURE() << m.error().text();
    return nullptr;
  }
  return *m;
}
MechanismPtr body(const Shape& shape, JointType joint = JointType::floating) {
  return make({"body", {link("body", "", joint, {}, {shape})}});
}

/// A character of 31 links with capsules for limbs and boxes for feet, arms hanging: its shapes are as close together as those of a human.
MechanismPtr character() {
  MechanismSpec spec{"character", {}};
  const auto capsule = [](double r, double length) { return Shape::capsule(r, {0, 0, -r}, {0, 0, r - length}); };
  spec.links.push_back(link("pelvis", "", JointType::floating, {}, {Shape::box({0.1, 0.15, 0.08})}));
  const char* spine[] = {"spine1", "spine2", "chest", "neck", "head"};
  std::string parent = "pelvis";
  for (const char* name : spine) {
    spec.links.push_back(
        link(name, parent.c_str(), JointType::spherical, at(0, 0, parent == "pelvis" ? 0.1 : 0.12), {Shape::sphere(0.09)}));
    parent = name;
  }
  for (const bool left : {false, true}) {
    const std::string side = left ? "left_" : "right_";
    const double y = left ? 0.1 : -0.1;
    const auto add = [&](const std::string& name, const std::string& on, JointType type, const Pose& X, const Shape& shape) {
      spec.links.push_back(link((side + name).c_str(), on.c_str(), type, X, {shape}));
    };
    add("thigh", "pelvis", JointType::spherical, at(0, y, -0.1), capsule(0.07, 0.42));
    add("shank", side + "thigh", JointType::revolute, at(0, 0, -0.42), capsule(0.05, 0.4));
    add("foot", side + "shank", JointType::universal, at(0, 0, -0.42), Shape::box({0.12, 0.045, 0.03}, at(0.06, 0, -0.04)));
    spec.links.back().joint.axis2 = {1, 0, 0};
    add("toes", side + "foot", JointType::revolute, at(0.19, 0, -0.05), Shape::box({0.03, 0.045, 0.02}, at(0.03, 0, 0)));
    add("clavicle", "chest", JointType::spherical, at(0, y * 0.3, 0.05), Shape::sphere(0.04));
    add("arm", side + "clavicle", JointType::spherical, at(0, y * 2.2, 0), capsule(0.045, 0.3));
    add("forearm", side + "arm", JointType::revolute, at(0, 0, -0.3), capsule(0.035, 0.26));
    add("hand", side + "forearm", JointType::spherical, at(0, 0, -0.26), Shape::box({0.02, 0.04, 0.06}, at(0, 0, -0.07)));
    for (int f = 0; f < 4; ++f)
      add("finger" + std::to_string(f), side + "hand", JointType::revolute, at(0, -0.03 + 0.02 * f, -0.13), capsule(0.009, 0.07));
  }
  // The 31st link, which is fixed.
  spec.links.push_back(link("pack", "chest", JointType::fixed, at(-0.14, 0, 0), {Shape::box({0.06, 0.12, 0.15})}));
  return make(std::move(spec));
}

struct Posed {
  std::vector<std::vector<Pose>> poses;
  std::vector<std::span<const Pose>> spans;
  explicit Posed(const Scene& scene) {
    for (const MechanismPtr& m : scene.systems()) {
      poses.emplace_back(static_cast<std::size_t>(m->link_count()));
      calc_poses(*m, m->neutral(), poses.back());
    }
    for (const auto& p : poses) spans.emplace_back(p);
  }
  void move(std::size_t system, const Pose& X) {
    for (Pose& p : poses[system]) p = X * p;
  }
};

std::vector<ContactPoint> contacts(const Scene& scene, const Posed& posed, double margin) {
  Workspace workspace;
  std::vector<ContactPoint> out;
  find_contacts(scene, posed.spans, margin, workspace, out);
  return out;
}

TEST(Scene, GroundContact) {
  Shape ball = Shape::sphere(0.5);
  ball.friction = 0.4;
  ball.restitution = 0.7;
  const Scene scene({body(ball)}, Ground{0.2, 0.9, 0.1});
  Posed posed(scene);
  posed.move(0, at(1, 2, 0.69));
  const auto found = contacts(scene, posed, 0.005);
  ASSERT_EQ(found.size(), 1U);
  const ContactPoint& c = found[0];
  EXPECT_EQ(std::tie(c.system_a, c.link_a, c.system_b, c.link_b), std::make_tuple(0, 0, -1, -1));
  EXPECT_NEAR(c.distance, -0.01, 1e-15);
  EXPECT_LT(norm(c.p - Vec3{1, 2, 0.195}), 1e-15);
  EXPECT_EQ(c.n, (Vec3{0, 0, 1}));
  EXPECT_DOUBLE_EQ(c.friction, 0.6);
  EXPECT_DOUBLE_EQ(c.restitution, 0.7);
  posed.move(0, at(0, 0, 0.02));
  EXPECT_TRUE(contacts(scene, posed, 0.005).empty());
  EXPECT_EQ(contacts(scene, posed, 0.0101).size(), 1U);
}

TEST(Scene, BetweenSystems) {
  const MechanismPtr ball = body(Shape::sphere(0.5)), box = body(Shape::box({0.5, 0.5, 0.5}));
  const Scene scene({box, ball}, {});
  Posed posed(scene);
  posed.move(0, at(0, 0, 5));
  posed.move(1, at(0, 0, 6.01));
  const auto found = contacts(scene, posed, 0.02);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].system_a, 0);
  EXPECT_EQ(found[0].system_b, 1);
  EXPECT_NEAR(found[0].distance, 0.01, 1e-12);
  EXPECT_LT(norm(found[0].n - Vec3{0, 0, -1}), 1e-12);  // normal from the upper ball b towards a
  EXPECT_LT(norm(found[0].p - Vec3{0, 0, 5.505}), 1e-12);
  SceneOptions apart;
  apart.between_systems = false;
  const Scene separate({box, ball}, {}, apart);
  EXPECT_TRUE(contacts(separate, posed, 0.02).empty());
}

TEST(Scene, NoGroundContactsWithoutGround) {
  SceneOptions options;
  options.with_ground = false;
  const Scene scene({body(Shape::sphere(0.5))}, {}, options);
  EXPECT_TRUE(contacts(scene, Posed(scene), 1).empty());
}

TEST(Scene, NonCollidingShapesAreIgnored) {
  Shape ghost = Shape::sphere(0.5);
  ghost.collides = false;
  const Scene scene({body(ghost)});
  EXPECT_TRUE(scene.shapes().empty());
  EXPECT_TRUE(contacts(scene, Posed(scene), 1).empty());
}

TEST(Scene, ImmovableShapesDoNotCollideWithEachOther) {
  const MechanismPtr wall = body(Shape::box({1, 1, 1}), JointType::fixed);
  const Scene scene({wall, wall, body(Shape::sphere(0.5))});
  Posed posed(scene);
  posed.move(2, at(0, 0, 1.4));
  const auto found = contacts(scene, posed, 0.01);
  ASSERT_EQ(found.size(), 2U);  // the ball with each wall; not wall with wall, not wall with ground
  for (const ContactPoint& c : found) EXPECT_EQ(c.system_b, 2);
}

/// Names of the link pairs that can collide in system 0.
std::set<std::pair<std::string, std::string>> pairs_of(const Scene& scene) {
  std::set<std::pair<std::string, std::string>> out;
  const Mechanism& m = *scene.systems()[0];
  for (const ShapePair& p : scene.self_pairs(0))
    out.emplace(m.link(scene.shapes()[static_cast<std::size_t>(p.a)].link).name,
                m.link(scene.shapes()[static_cast<std::size_t>(p.b)].link).name);
  return out;
}
using Names = std::set<std::pair<std::string, std::string>>;

TEST(Scene, SelfPairsExcludeAdjacentLinks) {
  const Shape bead = Shape::sphere(0.1);
  // chain a - b - c - d, far apart
  const Scene chain(
      {make({"chain",
             {link("a", "", JointType::floating, {}, {bead}), link("b", "a", JointType::revolute, at(1, 0, 0), {bead}),
              link("c", "b", JointType::fixed, at(1, 0, 0), {bead}), link("d", "c", JointType::revolute, at(1, 0, 0), {bead})}})});
  EXPECT_EQ(pairs_of(chain), (Names{{"a", "d"}}));  // b and c are one body, adjacent to both a and d

  // Siblings attached at the same point cannot collide, siblings attached at different points can.
  const auto siblings = [&](double apart) {
    return Scene({make({"siblings",
                        {link("a", "", JointType::floating, {}, {bead}),
                         link("b", "a", JointType::spherical, at(1, apart, 0), {Shape::sphere(0.1, at(0, 1, 0))}),
                         link("c", "a", JointType::spherical, at(1, 0, 0), {Shape::sphere(0.1, at(0, -1, 0))})}})});
  };
  EXPECT_EQ(pairs_of(siblings(0)), Names{});
  EXPECT_EQ(pairs_of(siblings(0.1)), (Names{{"b", "c"}}));

  // Floating bodies of one mechanism share no joint, although both start at the origin: they can collide.
  const Scene loose({make(
      {"loose",
       {link("a", "", JointType::floating, {}, {Shape::sphere(0.1, at(1, 0, 0))}), link("b", "", JointType::floating, {}, {bead})}})});
  EXPECT_EQ(pairs_of(loose), (Names{{"a", "b"}}));

  // Links that overlap in the neutral position cannot collide, although no joint connects them.
  const Scene thick(
      {make({"thick",
             {link("a", "", JointType::floating, {}, {Shape::sphere(0.5)}), link("b", "a", JointType::revolute, at(0.4, 0, 0), {bead}),
              link("c", "b", JointType::revolute, at(0.1, 0, 0), {bead}), link("d", "c", JointType::revolute, at(1, 0, 0), {bead})}})});
  EXPECT_EQ(pairs_of(thick), (Names{{"a", "d"}, {"b", "d"}}));
}

TEST(Scene, VirtualLinkBelongsToTheBodyOfItsRealLink) {
  const Shape bead = Shape::sphere(0.1);
  MechanismSpec spec{"loop",
                     {link("a", "", JointType::floating, {}, {bead}), link("b", "a", JointType::revolute, at(1, 0, 0), {bead}),
                      link("c", "b", JointType::revolute, at(0, 1, 0), {bead}), link("d", "a", JointType::revolute, at(0, 5, 0), {bead}),
                      link("c2", "d", JointType::revolute, at(1, 0, 0), {bead})}};
  spec.links.back().real = "c";
  const Scene scene({make(std::move(spec))});
  // The virtual link c2 is the same body as c, so d is adjacent to c and cannot collide with c or c2.
  EXPECT_EQ(pairs_of(scene), (Names{{"a", "c"}, {"a", "c2"}, {"b", "d"}}));
}

TEST(Scene, GroupsAndExclusionsPreventPairs) {
  // groups and partners as MuJoCo's contype and conaffinity: a and b belong to no group that the other collides with, c to both
  const auto bead = [](std::uint32_t groups, std::uint32_t partners) {
    Shape s = Shape::sphere(0.1);
    s.groups = groups;
    s.partners = partners;
    return s;
  };
  const auto loose = [&](std::vector<std::array<std::string, 2>> exclusions) {
    MechanismSpec spec{"loose",
                       {link("a", "", JointType::floating, {}, {bead(2, 2)}), link("b", "", JointType::floating, at(1, 0, 0), {bead(1, 0)}),
                        link("c", "", JointType::floating, at(2, 0, 0), {bead(4, 3)})}};
    spec.exclusions = std::move(exclusions);
    return make(std::move(spec));
  };
  EXPECT_EQ(pairs_of(Scene({loose({})})), (Names{{"a", "c"}, {"b", "c"}}));
  EXPECT_EQ(pairs_of(Scene({loose({{"c", "a"}, {"a", "c"}})})), (Names{{"b", "c"}}));

  // The same rule holds between systems and in the search for impacts; the ground collides with all.
  for (const bool collide : {false, true}) {
    const Scene scene({body(bead(2, 2)), body(bead(collide ? 2 : 1, 0))});
    Posed posed(scene);
    posed.move(0, at(0, 0, 0.1));
    posed.move(1, at(0.19, 0, 0.1));
    EXPECT_EQ(contacts(scene, posed, 0.01).size(), collide ? 3U : 2U);
  }
}

TEST(Scene, SmoothShapesHaveNoFrictionWithEachOther) {
  Shape smooth = Shape::sphere(0.1), rough = smooth;
  smooth.friction = rough.friction = 0.5;
  smooth.smooth = true;
  const Scene scene({body(smooth), body(smooth), body(rough)}, {.friction = 0.5});
  Posed posed(scene);
  posed.move(0, at(0, 0, 0.1));
  posed.move(1, at(0.2, 0, 5));
  posed.move(2, at(0, 0, 0.3));
  auto found = contacts(scene, posed, 0.01);
  ASSERT_EQ(found.size(), 2U);  // with the ground and with the rough ball
  for (const ContactPoint& c : found) EXPECT_DOUBLE_EQ(c.friction, 0.5);
  posed.move(2, at(0, 0, 8.7));
  posed.move(1, at(-0.2, 0, -4.7));  // to (0, 0, 0.3)
  found = contacts(scene, posed, 0.01);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[1].friction, 0);
}

TEST(Scene, SelfCollisionCanBeSwitchedAtRunTime) {
  Scene scene({character()});
  EXPECT_EQ(scene.systems()[0]->link_count(), 31);
  Posed posed(scene);
  posed.move(0, at(0, 0, 3));
  EXPECT_FALSE(scene.self_collision(0));
  EXPECT_TRUE(contacts(scene, posed, 0.02).empty());
  scene.set_self_collision(0, true);
  for (const ContactPoint& c : contacts(scene, posed, 0.02)) EXPECT_GT(c.distance, 0);  // pairs that overlap at rest are excluded
  // A hand moves into the thigh.
  const int hand = scene.systems()[0]->find_link("left_hand"), thigh = scene.systems()[0]->find_link("left_thigh");
  Pose& X = posed.poses[0][static_cast<std::size_t>(hand)];
  X.p.y = 0.14;
  bool found = false;
  for (const ContactPoint& c : contacts(scene, posed, 0.0))
    if (c.link_a == thigh && c.link_b == hand) found = c.distance < 0;
  EXPECT_TRUE(found);
  scene.set_self_collision(0, false);
  EXPECT_TRUE(contacts(scene, posed, 0.02).empty());
}

// Compares the broad phase with brute force over all pairs of shapes, without bounding volumes.
TEST(Scene, BroadPhaseMissesNothing) {
  test::Random random(41);
  for (int i = 0; i < 300 && !testing::Test::HasFailure(); ++i) {
    std::vector<MechanismPtr> systems;
    for (int k = 0; k < 6; ++k) systems.push_back(body(random.shape()));
    const Scene scene(systems);
    Posed posed(scene);
    for (std::size_t k = 0; k < 6; ++k) posed.move(k, random.pose(1));
    std::set<std::pair<int, int>> expected, found;
    const double margin = 0.1;
    for (int a = 0; a < 6; ++a) {
      const auto& X = posed.poses;
      const auto ia = static_cast<std::size_t>(a);
      if (distance_to_ground(scene.shapes()[ia].shape, X[ia][0], 0) < margin) expected.emplace(a, -1);
      for (int b = a + 1; b < 6; ++b) {
        const auto ib = static_cast<std::size_t>(b);
        if (distance(scene.shapes()[ia].shape, X[ia][0], scene.shapes()[ib].shape, X[ib][0]) < margin) expected.emplace(a, b);
      }
    }
    std::set<std::uint64_t> keys;
    for (const ContactPoint& c : contacts(scene, posed, margin)) {
      found.emplace(c.system_a, c.system_b);
      EXPECT_TRUE(keys.insert(c.key).second) << "two contacts with one key";
    }
    EXPECT_EQ(found, expected) << "case " << i;
  }
}

TEST(Scene, ContactsAreReproducible) {
  Scene scene({character(), body(Shape::box({0.3, 0.3, 0.3})), body(Shape::sphere(0.1))});
  scene.set_self_collision(0, true);
  Posed posed(scene);
  posed.move(0, at(0, 0, 0.9));
  posed.move(1, at(0.2, 0, 0.2));
  const auto first = contacts(scene, posed, 0.05), second = contacts(scene, posed, 0.05);
  ASSERT_GT(first.size(), 10U);
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].key, second[i].key);
    EXPECT_EQ(first[i].p, second[i].p);
    EXPECT_EQ(first[i].distance, second[i].distance);
  }
}

TEST(Scene, KeysPersistWhileTheCharacterMoves) {
  const Scene scene({character()});
  Posed posed(scene);
  posed.move(0, at(0, 0, 1.008));
  std::set<std::uint64_t> before, after;
  for (const ContactPoint& c : contacts(scene, posed, 0.02)) before.insert(c.key);
  posed.move(0, {rotation_about({0, 0, 1}, 0.01), {0.01, 0, -0.001}});
  for (const ContactPoint& c : contacts(scene, posed, 0.02)) after.insert(c.key);
  EXPECT_GE(before.size(), 8U);
  EXPECT_EQ(before, after);
}

TEST(Scene, NonFinitePosesHaveNoContacts) {
  Scene scene({character(), body(Shape::sphere(0.1))});
  scene.set_self_collision(0, true);
  Posed posed(scene);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (auto& poses : posed.poses)
    for (Pose& X : poses) X.p = {nan, nan, nan};
  EXPECT_TRUE(contacts(scene, posed, 0.05).empty());
}

TEST(Scene, EmptySceneHasNoContacts) {
  const Scene scene({}, {});
  EXPECT_TRUE(contacts(scene, Posed(scene), 0.05).empty());
}

TEST(Scene, NoAllocationAfterWarmUp) {
  Scene scene({character(), body(Shape::box({0.3, 0.3, 0.3})), body(Shape::box({0.4, 0.1, 0.1}))});
  scene.set_self_collision(0, true);
  Posed posed(scene);
  posed.move(0, at(0, 0, 3));
  Workspace workspace(scene);
  std::vector<ContactPoint> out;
  find_contacts(scene, posed.spans, 0.05, workspace, out);  // warm-up without contacts
  posed.move(0, at(0, 0, -2.1));
  posed.move(1, at(0.2, 0, 0.2));
  posed.move(2, at(0.2, 0, 0.55));
  const auto before = allocations_so_far();
  for (int i = 0; i < 100; ++i) {
    posed.move(0, {rotation_about({0, 0, 1}, 0.05), {0, 0, -0.001}});
    find_contacts(scene, posed.spans, 0.05, workspace, out);
  }
  EXPECT_EQ(allocations_so_far(), before);
  EXPECT_GT(out.size(), 20U);
}

}  // namespace
}  // namespace ugoki::collision
