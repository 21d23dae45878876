#include "ugoki/contact/shared_poses.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "ugoki/contact/contact_search.h"
#include "ugoki/contact/scene_step.h"
#include "world.h"

namespace ugoki::contact {
namespace {

bool equal(const Pose& a, const Pose& b) { return a.R == b.R && a.p == b.p; }

/// A box and a ball that fall on the ground.
struct Falling {
  std::vector<MechanismPtr> mechanisms = {body("box", Shape::box({0.1, 0.2, 0.3}), 500), body("ball", Shape::sphere(0.1), 500)};
  collision::Ground ground;
  collision::Scene scene{mechanisms, ground};
  ContactSearch search{scene, 0.02};
  SceneStep step{mechanisms, ground, {}};
  std::vector<State> states{State(*mechanisms[0]), State(*mechanisms[1])};
  std::vector<collision::SystemMotion> motions;
  std::vector<StepSystem> systems;

  Falling() {
    put(states[0], {0, 0, 0.31});
    put(states[1], {0.05, 0.02, 0.8});
    states[0].v[1] = 0.4;
    for (State& x : states) {
      motions.push_back({x.q, x.v});
      systems.push_back({x.q, x.v, x.tau, {}, {}, {}});
    }
  }
  void advance() { ASSERT_EQ(step.step(systems, search.find(motions, 0.002), 0.002).status, StepStatus::ok); }
};

TEST(SharedPoses, AreKnownOnlyAtThePositionsOfTheLastExchange) {
  const std::vector<MechanismPtr> systems = {body("ball", Shape::sphere(0.1), 500)};
  State x(*systems[0]);
  SharedPoses shared(systems);
  SharedPoses::Values values(systems);
  std::ranges::copy(x.q, values.q[0].begin());
  EXPECT_TRUE(shared.find(0, values.q[0]).empty());
  shared.exchange(values);
  EXPECT_EQ(shared.find(0, x.q).size(), 1U);
  x.q[2] = 1e-300;
  EXPECT_TRUE(shared.find(0, x.q).empty());
}

TEST(SharedPoses, OfAStepAreThePosesAtItsEnd) {
  Falling f;
  SharedPoses shared(f.mechanisms);
  f.step.set_shared_poses(&shared);
  int known = 0;
  for (int i = 0; i < 500; ++i) {
    f.advance();
    for (std::size_t s = 0; s < f.states.size(); ++s) {
      const std::span<const Pose> found = shared.find(s, f.states[s].q);
      if (found.empty()) continue;
      ++known;
      Pose exact;
      calc_poses(*f.mechanisms[s], f.states[s].q, {&exact, 1});
      EXPECT_TRUE(equal(found[0], exact)) << "step " << i << ", system " << s;
    }
  }
  EXPECT_GT(known, 800);  // not in flight, where steps have no contacts and are not guarded
}

TEST(SharedPoses, DoNotChangeTheBits) {
  Falling with, without;
  SharedPoses shared(with.mechanisms);
  with.search.set_shared_poses(&shared);
  with.step.set_shared_poses(&shared);
  for (int i = 0; i < 500; ++i) {
    with.advance();
    without.advance();
    for (std::size_t s = 0; s < with.states.size(); ++s) ASSERT_EQ(with.states[s].q, without.states[s].q) << "step " << i;
  }
}

TEST(SharedPoses, AreUsedByTheContactSearch) {
  Falling f;
  SharedPoses shared(f.mechanisms);
  f.search.set_shared_poses(&shared);
  const std::size_t before = f.search.find(f.motions, 0.002).size();
  SharedPoses::Values values(f.mechanisms);  // poses far above the ground, which do not belong to the positions
  for (std::size_t s = 0; s < f.states.size(); ++s) {
    std::ranges::copy(f.states[s].q, values.q[s].begin());
    values.X_WB[s][0] = {Mat3::identity(), {0, 0, 10.0 + static_cast<double>(s)}};
  }
  shared.exchange(values);
  EXPECT_GT(before, 0U);
  EXPECT_TRUE(f.search.find(f.motions, 0.002).empty());
}

}  // namespace
}  // namespace ugoki::contact
