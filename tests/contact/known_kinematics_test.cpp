#include "ugoki/dynamics/known_kinematics.h"

#include <gtest/gtest.h>

#include "../dynamics/random_mechanism.h"
#include "../mechanism/chain.h"
#include "ugoki/contact/contact_search.h"
#include "ugoki/contact/scene_step.h"
#include "world.h"

namespace ugoki::contact {
namespace {

using dynamics::Kinematics;

bool equal(const Pose& a, const Pose& b) { return a.R == b.R && a.p == b.p; }

/// True if both have the same bits, apart from the signs of zeros.
bool equal(const Kinematics& a, const Kinematics& b) {
  const auto same = [](const Inertia& x, const Inertia& y) { return x.mass == y.mass && x.h == y.h && x.I.matrix() == y.I.matrix(); };
  return a.p0 == b.p0 && std::ranges::equal(a.X_WB, b.X_WB, [](const Pose& x, const Pose& y) { return equal(x, y); }) && a.S == b.S &&
         a.V == b.V && a.C == b.C && std::ranges::equal(a.I, b.I, same);
}

/// A floating chain of `links` capsules of 0.3 m on spherical and revolute joints.
MechanismPtr chain(int links) {
  return testing::make_chain(links, [](int i, LinkSpec& l) {
    l.joint.type = i == 0 ? JointType::floating : i % 3 == 1 ? JointType::spherical : JointType::revolute;
    l.joint.axis = {0, 1, 0};
    l.joint.X_PJ.p = i > 0 ? Vec3{0.3, 0, 0} : Vec3{};
    l.shapes.push_back(Shape::capsule(0.03, {0.04, 0, 0}, {0.26, 0, 0}));
    l.inertia = solid_inertia(l.shapes[0], 1000);
  });
}

/// A box, a ball and a chain that fall on the ground.
struct Falling {
  std::vector<MechanismPtr> mechanisms = {body("box", Shape::box({0.1, 0.2, 0.3}), 500), body("ball", Shape::sphere(0.1), 500), chain(5)};
  collision::Ground ground;
  collision::Scene scene{mechanisms, ground};
  ContactSearch search{scene, 0.02};
  SceneStep step{mechanisms, ground, {}};
  std::vector<State> states{State(*mechanisms[0]), State(*mechanisms[1]), State(*mechanisms[2])};
  std::vector<collision::SystemMotion> motions;
  std::vector<StepSystem> systems;
  std::span<const dynamics::KnownKinematics> known;

  Falling() {
    put(states[0], {0, 0, 0.31});
    put(states[1], {0.05, 0.02, 0.8});
    put(states[2], {1, 0, 0.2});
    states[0].v[1] = 0.4;
    states[2].v[7] = 1;
    for (State& x : states) {
      motions.push_back({x.q, x.v});
      systems.push_back({x.q, x.v, x.tau, {}, {}, {}, nullptr});
    }
  }
  /// Lets the search and the next step use the kinematics at the end of the last step.
  void use_known() {
    for (std::size_t s = 0; s < systems.size(); ++s) systems[s].known = &step.end()[s];
    known = step.end();
  }
  void advance() { ASSERT_EQ(step.step(systems, search.find(motions, 0.002, known), 0.002).status, StepStatus::ok); }
};

TEST(KnownKinematics, BelongToTheStateOfTheLastUpdate) {
  const MechanismPtr ball = body("ball", Shape::sphere(0.1), 500);
  State x(*ball);
  dynamics::KnownKinematics known(*ball);
  EXPECT_EQ(known.find(x.q, x.v), nullptr);
  put(x, {1, 2, 3});
  known.update(*ball, x.q, x.v);
  ASSERT_NE(known.find(x.q, x.v), nullptr);
  EXPECT_EQ(known.find(x.q, x.v)->p0, Vec3(1, 2, 3));
  State other = x;
  other.q[2] = 3 + 1e-15;
  EXPECT_EQ(known.find(other.q, x.v), nullptr);
  other.v[5] = 1e-300;
  EXPECT_EQ(known.find(x.q, other.v), nullptr);
}

TEST(KnownKinematics, OfAMechanismThatCannotMoveAreKnown) {
  MechanismSpec spec;
  spec.name = "wall";
  spec.links.emplace_back().name = "wall";
  const MechanismPtr wall = Mechanism::make(std::move(spec)).value();
  dynamics::KnownKinematics known(*wall);
  EXPECT_EQ(known.find({}, {}), nullptr);
  known.update(*wall, {}, {});
  EXPECT_NE(known.find({}, {}), nullptr);
}

TEST(KnownKinematics, OfAStepAreThoseAtItsEnd) {
  Falling f;
  for (State& x : f.states) x.q[2] += 0.1;  // the first steps have no contacts
  for (int i = 0; i < 500; ++i) {
    f.advance();
    for (std::size_t s = 0; s < f.states.size(); ++s) {
      Kinematics exact(*f.mechanisms[s]);
      const Kinematics* const end = f.step.end()[s].find(f.states[s].q, f.states[s].v);
      ASSERT_NE(end, nullptr) << "step " << i << ", system " << s;
      dynamics::update_kinematics(*f.mechanisms[s], f.states[s].q, f.states[s].v, exact);
      EXPECT_TRUE(equal(*end, exact)) << "step " << i << ", system " << s;
    }
  }
}

TEST(KnownKinematics, DoNotChangeTheBits) {
  Falling with, without;
  with.use_known();
  for (int i = 0; i < 500; ++i) {
    with.advance();
    without.advance();
    for (std::size_t s = 0; s < with.states.size(); ++s) {
      ASSERT_EQ(with.states[s].q, without.states[s].q) << "step " << i;
      ASSERT_EQ(with.states[s].v, without.states[s].v) << "step " << i;
    }
  }
}

TEST(KnownKinematics, AreUsedByTheSearchAndByTheStep) {
  Falling f;
  // Kinematics that do not belong to the mechanisms: bodies of the same structure without mass, 10 m above their joints.
  std::vector<dynamics::KnownKinematics> wrong;
  for (std::size_t s = 0; s < f.mechanisms.size(); ++s) {
    MechanismSpec spec = f.mechanisms[s]->spec();
    for (LinkSpec& l : spec.links) l.inertia = Inertia::from_centre(1e-300, {}, {});
    spec.links[0].joint.X_PJ.p = {0, 0, 10.0 + 10.0 * static_cast<double>(s)};
    const MechanismPtr high = Mechanism::make(std::move(spec)).value();
    wrong.emplace_back(*high).update(*high, f.states[s].q, f.states[s].v);
  }
  EXPECT_FALSE(f.search.find(f.motions, 0.002).empty());
  std::vector<collision::ContactPoint>& contacts = f.search.find(f.motions, 0.002, wrong);
  EXPECT_TRUE(contacts.empty());
  for (std::size_t s = 0; s < wrong.size(); ++s) f.systems[s].known = &wrong[s];
  EXPECT_EQ(f.step.step(f.systems, contacts, 0.002).status, StepStatus::singular);
}

TEST(Kinematics, HaveTheBitsOfCalcPoses) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    testing::RandomSource random(seed);
    MechanismSpec spec = testing::random_spec(random, 12);
    for (LinkSpec& l : spec.links)
      if (random.below(2) == 0) l.joint.X_PJ.R = Mat3::identity();  // a joint frame that is parallel to its link
    const MechanismPtr m = Mechanism::make(std::move(spec)).value();
    State x(*m);
    for (const Link& link : m->links()) {
      const double v[6] = {random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2),
                           random.uniform(-2, 2), random.uniform(-2, 2), 1};
      joint_integrate(link.joint, x.q.data() + link.q_index, v, 1, x.q.data() + link.q_index);
    }
    Kinematics k(*m);
    std::vector<Pose> X(k.X_WB.size());
    dynamics::update_kinematics(*m, x.q, x.v, k);
    calc_poses(*m, x.q, X);
    for (std::size_t i = 0; i < X.size(); ++i) {
      EXPECT_TRUE(equal(X[i], k.X_WB[i])) << "seed " << seed << ", link " << i;
      // The same pose by the definition, with products of complete poses.
      const Link& link = m->links()[i];
      const Pose X_PB = link.joint.X_PJ * joint_pose(link.joint, x.q.data() + link.q_index);
      const Pose defined = link.parent < 0 ? X_PB : X[static_cast<std::size_t>(link.parent)] * X_PB;
      EXPECT_LT(norm(X[i].p - defined.p), 1e-14);
      for (int c = 0; c < 3; ++c) EXPECT_LT(norm(X[i].R.column(c) - defined.R.column(c)), 1e-14);
    }
  }
}

/// Number of contacts of a step of 2 ms whose first system has the joint speed `speed` [rad/s].
std::size_t contacts_at(const std::vector<MechanismPtr>& mechanisms, double speed) {
  const collision::Scene scene(mechanisms, {-100, 0, 0});
  ContactSearch search(scene, 0.02);
  std::vector<State> states;
  for (const MechanismPtr& m : mechanisms) states.emplace_back(*m);
  states[0].v[0] = speed;
  std::vector<collision::SystemMotion> motions;
  for (State& x : states) motions.push_back({x.q, x.v});
  return search.find(motions, 0.002).size();
}

TEST(ContactSearch, FindsWhatTheTipOfASlowlyTurningArmReaches) {
  // An arm of one link on a hinge, 20 m long: at 4 rad/s its tip moves by 0.16 m in a step. The floor is 0.1 m below the tip.
  MechanismSpec spec;
  spec.name = "arm";
  LinkSpec l;
  l.name = "arm";
  l.joint.type = JointType::revolute;
  l.joint.axis = {0, 1, 0};
  l.shapes.push_back(Shape::sphere(0.1, {Mat3::identity(), {20, 0, 0}}));
  l.inertia = solid_inertia(l.shapes[0], 1000);
  spec.links.push_back(l);
  const MechanismPtr arm = Mechanism::make(std::move(spec)).value();
  MechanismSpec plate;
  plate.name = "plate";
  LinkSpec p;
  p.name = "plate";
  p.shapes.push_back(Shape::box({1, 1, 0.05}, {Mat3::identity(), {20, 0, -0.25}}));
  plate.links.push_back(p);
  const std::vector<MechanismPtr> systems = {arm, Mechanism::make(std::move(plate)).value()};
  EXPECT_EQ(contacts_at(systems, 0.1), 0U);
  EXPECT_GT(contacts_at(systems, 4), 0U);
}

}  // namespace
}  // namespace ugoki::contact
