#include "ugoki/mechanism_edit/combine.h"

#include <gtest/gtest.h>

#include "random_joints.h"
#include "random_loops.h"
#include "ugoki/mechanism_edit/link_frames.h"
#include "ugoki/samples/samples.h"
#include "whole.h"

namespace ugoki {
namespace {

using testing::RandomSource;
constexpr JointType keeps_coordinates[] = {JointType::fixed,   JointType::revolute,    JointType::prismatic,
                                           JointType::helical, JointType::cylindrical, JointType::universal};

/// Checks that the pose of the reversed joint at q' is the inverse of the pose of the joint at q. reversed() documents q' for each type.
TEST(Reversed, IsTheInverseForEveryType) {
  test::Random random;
  for (const JointType type : test::all_joint_types)
    for (int round = 0; round < 20; ++round) {
      const Joint joint = random.joint(type);
      std::string lost;
      const Joint back = reversed(joint, lost);
      double q[7], r[7];
      random.coordinates(joint, q);
      std::copy(q, q + 7, r);
      const auto conjugate = [&](int at) {
        for (int i = 1; i < 4; ++i) r[at + i] = -q[at + i];
      };
      if (type == JointType::universal) std::swap(r[0], r[1]);
      if (type == JointType::spherical) conjugate(0);
      if (type == JointType::planar || type == JointType::floating) {
        const Pose inverse = joint_pose(joint, q).inverse();
        r[0] = inverse.p.x;
        r[1] = inverse.p.y;
        r[2] = type == JointType::planar ? -q[2] : inverse.p.z;
        if (type == JointType::floating) conjugate(3);
      }
      Joint plain = joint;
      plain.X_PJ = {};
      EXPECT_LT(testing::distance(joint_pose(back, r) * joint_pose(plain, q), Pose{}), 1e-12) << name_of(type);
    }
}

TEST(MakeRoot, KeepsRelativePosesInertiaAndLoops) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    RandomSource random(seed);
    MechanismSpec spec = testing::random_spec(random, 10, keeps_coordinates);
    for (LinkSpec& l : spec.links) l.shapes = {Shape::sphere(0.1, {random.rotation(), random.vec(0.2)})};
    spec.loops.push_back({.name = "rod",
                          .type = LoopType::ball,
                          .link_a = "link2",
                          .link_b = "link9",
                          .X_AJ = {random.rotation(), random.vec(1)},
                          .X_BJ = {random.rotation(), random.vec(1)}});
    const MechanismPtr before = *Mechanism::make(spec);
    const int root = 1 + random.below(9);
    std::vector<std::string> report;
    MechanismSpec turned = before->spec();
    const std::string root_name = before->link(root).name;
    make_root(turned, root, report);
    const auto made = Mechanism::make(turned);
    ASSERT_TRUE(made.has_value()) << made.error().text();
    const MechanismPtr after = *made;
    ASSERT_EQ(after->link_count(), before->link_count());
    EXPECT_FALSE(report.empty());

    State s(*before);
    testing::randomize(random, *before, s);
    // The coordinates of a reversed joint belong to the link that was its parent.
    std::vector<double> q = after->neutral();
    for (int i = 0; i < before->link_count(); ++i) {
      const Link& l = before->link(i);
      if (l.joint.type == JointType::floating) continue;
      bool on_path = false;
      for (int k = root; k >= 0; k = before->link(k).parent) on_path = on_path || k == i;
      const Link& to = after->link(after->find_link(on_path ? before->link(l.parent).name : l.name));
      ASSERT_EQ(to.joint.type, l.joint.type);
      for (int k = 0; k < l.joint.nq(); ++k) {
        const int from = on_path && l.joint.type == JointType::universal ? 1 - k : k;
        q[static_cast<std::size_t>(to.q_index + k)] = s.q[static_cast<std::size_t>(l.q_index + from)];
      }
    }
    std::vector<Pose> X(10), Y(10);
    calc_poses(*before, s.q, X);
    calc_poses(*after, q, Y);
    const Pose to_root = X[static_cast<std::size_t>(root)].inverse();
    const Pose new_root = Y[static_cast<std::size_t>(after->find_link(root_name))].inverse();
    for (int i = 0; i < 10; ++i) {
      const int j = after->find_link(before->link(i).name);
      // Shapes and inertia relative to the new root must be equal, independent of the choice of link frames.
      EXPECT_LT(testing::distance(to_root * X[static_cast<std::size_t>(i)] * before->link(i).shapes[0].X_BS,
                                  new_root * Y[static_cast<std::size_t>(j)] * after->link(j).shapes[0].X_BS),
                1e-11);
      EXPECT_LT(testing::difference(before->link(i).inertia.in_parent(to_root * X[static_cast<std::size_t>(i)]),
                                    after->link(j).inertia.in_parent(new_root * Y[static_cast<std::size_t>(j)])),
                1e-10);
    }
    const Loop &old_loop = before->loops()[0], &new_loop = after->loops()[0];
    EXPECT_LT(testing::distance(to_root * X[static_cast<std::size_t>(old_loop.link_b)] * old_loop.X_BJ,
                                new_root * Y[static_cast<std::size_t>(new_loop.link_b)] * new_loop.X_BJ),
              1e-11);
  }
}

TEST(Combine, JointKeepsMassInertiaLoopsAndShapes) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(seed);
    RandomSource random(seed);
    testing::RandomLoops first(seed), second(seed + 50);
    MechanismSpec a_spec = first.m->spec(), b_spec = testing::random_spec(random, 8, keeps_coordinates);
    b_spec.name = "other";
    a_spec.exclusions = {{"link1", "link4"}};
    b_spec.exclusions = {{"link2", "link7"}};
    b_spec.links[3].shapes = {Shape::box({0.1, 0.2, 0.3}, {random.rotation(), random.vec(1)})};
    const MechanismPtr a = *Mechanism::make(a_spec), b = *Mechanism::make(b_spec);
    CombineOptions options;
    options.link_a = "link4";
    options.link_b = "link" + std::to_string(random.below(8));
    options.X_AB = {random.rotation(), random.vec(1)};
    options.X_BJ = {random.rotation(), random.vec(0.3)};
    options.joint.type = static_cast<JointType>(random.below(9));
    const auto made = combine(*a, *b, options);
    ASSERT_TRUE(made.has_value()) << made.error().text();
    const Mechanism& m = *made->mechanism;
    EXPECT_EQ(m.link_count(), 20);
    EXPECT_NEAR(m.mass(), a->mass() + b->mass(), 1e-9 * m.mass());
    ASSERT_EQ(made->links_b.size(), 8u);
    ASSERT_EQ(m.exclusions().size(), 2u);
    for (const auto& [one, other] : {std::pair{"link1", "link4"}, {"other link2", "other link7"}})
      EXPECT_EQ(std::ranges::count(m.exclusions(), std::array{std::min(m.find_link(one), m.find_link(other)),
                                                              std::max(m.find_link(one), m.find_link(other))}),
                1);
    EXPECT_EQ(made->links_b[0], "other link0");  // prefixed, because both mechanisms have a link0

    // In the neutral position a's links are unchanged, b's have the requested pose, and the total inertia is the sum.
    std::vector<Pose> X_a(12), X_b(8), X(20);
    calc_poses(*a, a->neutral(), X_a);
    calc_poses(*b, b->neutral(), X_b);
    calc_poses(m, m.neutral(), X);
    const Pose moved = X_a[4] * options.X_AB * X_b[static_cast<std::size_t>(b->find_link(options.link_b))].inverse();
    Inertia sum = testing::whole_inertia(*a, a->neutral()) + testing::whole_inertia(*b, b->neutral()).in_parent(moved);
    EXPECT_LT(testing::difference(sum, testing::whole_inertia(m, m.neutral())), 1e-12);
    for (int i = 0; i < 12; ++i)
      EXPECT_LT(testing::distance(X_a[static_cast<std::size_t>(i)],
                                  X[static_cast<std::size_t>(m.find_link(made->links_a[static_cast<std::size_t>(i)]))]),
                1e-12);
    const int box = m.find_link(made->links_b[3]);
    ASSERT_EQ(m.link(box).shapes.size(), 1u);
    EXPECT_LT(testing::distance(X[static_cast<std::size_t>(box)] * m.link(box).shapes[0].X_BS, moved * X_b[3] * b->link(3).shapes[0].X_BS),
              1e-12);
  }
}

TEST(Combine, LoopIsClosedInTheNeutralPosition) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    RandomSource random(seed);
    const MechanismPtr a = *Mechanism::make(testing::random_spec(random, 6)), b = *Mechanism::make(testing::random_spec(random, 6));
    CombineOptions options{.link_a = "link3",
                           .link_b = "link4",
                           .X_AB = {random.rotation(), random.vec(1)},
                           .X_BJ = {random.rotation(), random.vec(1)},
                           .attachment = Attachment::loop};
    options.loop.type = static_cast<LoopType>(random.below(8));
    options.loop.length = 0.4;
    options.loop.axis2 = {1, 0, 0};
    const auto made = combine(*a, *b, options);
    ASSERT_TRUE(made.has_value()) << made.error().text();
    const Mechanism& m = *made->mechanism;
    ASSERT_EQ(m.loops().size(), 1u);
    EXPECT_EQ(m.nv(), a->nv() + b->nv());
    EXPECT_NEAR(m.mass(), a->mass() + b->mass(), 1e-12 * m.mass());
    const Loop& loop = m.loops()[0];
    std::vector<Pose> X(12);
    calc_poses(m, m.neutral(), X);
    const Pose A = X[static_cast<std::size_t>(loop.link_a)] * loop.X_AJ, B = X[static_cast<std::size_t>(loop.link_b)] * loop.X_BJ;
    if (loop.type == LoopType::distance)
      EXPECT_NEAR(norm(A.p - B.p), 0.4, 1e-12);
    else
      EXPECT_LT(testing::distance(A, B), 1e-12);
    EXPECT_LT(testing::distance(X[static_cast<std::size_t>(m.find_link("link3"))] * options.X_AB,
                                X[static_cast<std::size_t>(m.find_link(made->links_b[4]))]),
              1e-12);
  }
}

TEST(Combine, WeldedSwordAddsMassAndNoDofs) {
  const samples::Sample sample = samples::make_sample();
  const MechanismPtr man = sample.resources.mechanisms.at("human");
  LinkSpec blade = testing::link_of("blade", "", JointType::floating);
  blade.inertia = solid_inertia(Shape::box({0.4, 0.02, 0.004}, {Mat3::identity(), {0.4, 0, 0}}), 7800);
  const MechanismPtr sword = *Mechanism::make({.name = "sword", .links = {blade}});
  int hand = -1;
  for (int i = 0; i < man->link_count(); ++i)
    if (man->link(i).label == "hand right") hand = i;
  ASSERT_GE(hand, 0);
  const auto armed = combine(*man, *sword, {.link_a = man->link(hand).name, .link_b = "blade", .X_AB = {Mat3::identity(), {0, 0, -0.08}}});
  ASSERT_TRUE(armed.has_value());
  EXPECT_EQ(armed->mechanism->nv(), man->nv());  // a weld adds no DOF
  EXPECT_NEAR(armed->mechanism->mass(), man->mass() + 0.8 * 0.04 * 0.008 * 7800, 1e-9);
}

TEST(Combine, ErrorsNameTheMissingLinks) {
  const MechanismPtr ball = samples::make_ball();
  const auto made = combine(*ball, *ball, {.link_a = "nose", .link_b = "tail"});
  ASSERT_FALSE(made.has_value());
  EXPECT_EQ(made.error().problems.size(), 2u);
  EXPECT_NE(made.error().text().find("nose"), std::string::npos);
  EXPECT_NE(made.error().text().find("tail"), std::string::npos);
  CombineOptions no_length{.link_b = ball->link(0).name, .attachment = Attachment::loop};
  no_length.loop.type = LoopType::distance;
  EXPECT_FALSE(combine(*ball, *ball, no_length).has_value());
}

}  // namespace
}  // namespace ugoki
