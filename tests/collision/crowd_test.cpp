// For a crowd of mechanisms, compares the contacts of find_contacts(), which takes its pairs from the superior tree, with a test of all
// pairs.

#include <gtest/gtest.h>

#include <tuple>

#include "../mechanism/chain.h"
#include "allocation_count.h"
#include "random_shapes.h"
#include "ugoki/collision/broad_phase.h"
#include "ugoki/collision/pair_table.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::collision {
namespace {

/// A chain of `links` links with one shape each; the first link is attached to the world by a joint of the given type.
MechanismPtr chain(test::Random& random, int links, JointType first) {
  return testing::make_chain(links, [&](int i, LinkSpec& l) {
    l.joint.type = i == 0 ? first : JointType::revolute;
    l.joint.axis = random.unit();
    l.joint.X_PJ.p = i == 0 ? random.vec(1) : random.vec(0.3);
    l.inertia = Inertia::from_centre(1, {}, {0.1, 0.1, 0.1, 0, 0, 0});
    l.shapes = {random.below(4) == 0 ? Shape::cylinder(0.1, 0.2) : random.shape()};
  });
}

/// Moving mechanisms with their state and poses.
struct Crowd {
  std::vector<MechanismPtr> systems;
  std::vector<std::vector<double>> q, v;
  std::vector<std::vector<Pose>> X;
  std::vector<std::span<const Pose>> views;
  std::vector<char> moved;

  Crowd(test::Random& random, int count, int long_ones) {
    for (int i = 0; i < count; ++i) {
      const bool fixed = i % 7 == 3;
      systems.push_back(chain(random, i < long_ones ? 160 : 1 + random.below(3), fixed ? JointType::fixed : JointType::floating));
      const Mechanism& m = *systems.back();
      q.push_back(m.neutral());
      for (double& x : v.emplace_back(static_cast<std::size_t>(m.nv()))) x = random.in(-0.5, 0.5);
      if (!fixed)
        for (std::size_t k = 0; k < 3; ++k) q.back()[k] = random.in(-4, 4);
      X.emplace_back(m.links().size());
      moved.push_back(1);
    }
    for (const auto& x : X) views.emplace_back(x);
  }
  /// Moves the mechanisms by one step. Some reverse their velocity, some do not move (moved = 0).
  void step(test::Random& random, double dt) {
    for (std::size_t s = 0; s < systems.size(); ++s) {
      if (random.below(20) == 0)
        for (double& x : v[s]) x = -x;
      moved[s] = random.below(3) == 0 ? 0 : 1;
      if (moved[s] != 0) integrate(*systems[s], q[s], v[s], dt, q[s]);
      calc_poses(*systems[s], q[s], X[s]);
    }
  }
};

using ContactRecord = std::tuple<int, int, int, int, double, double, double, double, double, double, double>;
ContactRecord record_of(const ContactPoint& c, int system_a, int system_b) {
  return {system_a, c.link_a, system_b, c.link_b, c.p.x, c.p.y, c.p.z, c.n.x, c.n.y, c.n.z, c.distance};
}

/// Brute force: a scene for each system and for each pair of systems, too small for the broad phase.
class AllPairs {
 public:
  AllPairs(const Crowd& crowd, const std::vector<int>& self, const SceneOptions& options) {
    SceneOptions alone = options;
    alone.between_systems = false;
    ground_ = Scene(crowd.systems, {}, alone);
    alone.with_ground = false;
    for (const int s : self) {
      self_.push_back({s, Scene({crowd.systems[static_cast<std::size_t>(s)]}, {}, alone)});
      self_.back().second.set_self_collision(0, true);
    }
    alone.between_systems = true;
    const int count = options.between_systems ? static_cast<int>(crowd.systems.size()) : 0;
    for (int a = 0; a < count; ++a)
      for (int b = a + 1; b < count; ++b)
        pairs_.push_back(
            {a, b, Scene({crowd.systems[static_cast<std::size_t>(a)], crowd.systems[static_cast<std::size_t>(b)]}, {}, alone)});
  }
  std::vector<ContactRecord> find(const Crowd& crowd, double margin, bool only_moved) {
    std::vector<ContactRecord> out;
    std::vector<ContactPoint> contacts;
    const auto add = [&](const Scene& scene, std::span<const std::span<const Pose>> X, std::span<const char> moved, int a, int b) {
      workspace_.forget();
      find_contacts(scene, X, margin, workspace_, contacts, only_moved ? moved : std::span<const char>());
      for (const ContactPoint& c : contacts)
        out.push_back(record_of(c, a < 0 ? c.system_a : a, a < 0 || c.system_b < 0 ? c.system_b : c.system_b == 0 ? a : b));
    };
    add(ground_, crowd.views, crowd.moved, -1, -1);
    for (const auto& [s, scene] : self_)
      add(scene, {&crowd.views[static_cast<std::size_t>(s)], 1}, {&crowd.moved[static_cast<std::size_t>(s)], 1}, s, s);
    for (const auto& [a, b, scene] : pairs_) {
      const auto i = static_cast<std::size_t>(a), k = static_cast<std::size_t>(b);
      const std::span<const Pose> X[2] = {crowd.views[i], crowd.views[k]};
      const char moved[2] = {crowd.moved[i], crowd.moved[k]};
      add(scene, X, moved, a, b);
    }
    return out;
  }

 private:
  Workspace workspace_;
  Scene ground_;
  std::vector<std::pair<int, Scene>> self_;
  std::vector<std::tuple<int, int, Scene>> pairs_;
};

void compare(Crowd crowd, test::Random& random, const std::vector<int>& self, const SceneOptions& options, std::size_t minimum) {
  Scene scene(crowd.systems, {}, options);
  for (const int s : self) scene.set_self_collision(s, true);
  ASSERT_TRUE(BroadPhase::is_faster(scene));
  AllPairs all(crowd, self, options);
  Workspace workspace(scene);
  std::vector<ContactPoint> contacts;
  std::size_t max_found = 0;
  for (int step = 0; step < 12; ++step) {
    crowd.step(random, step % 5 == 4 ? 0.5 : 0.02);
    const double margin = step % 3 == 0 ? -0.01 : 0.05;
    const bool only_moved = step % 2 == 0;
    workspace.forget();  // warm starts of other steps would change the last bits
    find_contacts(scene, crowd.views, margin, workspace, contacts, only_moved ? crowd.moved : std::span<const char>());
    std::vector<ContactRecord> found;
    for (const ContactPoint& c : contacts) found.push_back(record_of(c, c.system_a, c.system_b));
    ASSERT_EQ(found, all.find(crowd, margin, only_moved)) << "step " << step;
    max_found = std::max(max_found, found.size());
  }
  EXPECT_GT(max_found, minimum);
}

/// The warm start of a pair must be empty after forget(), and other pairs must not see it.
TEST(PairTable, ForgottenPairsBeginWithoutWarmStart) {
  PairTable table;
  constexpr std::uint64_t pairs = 1000;  // enough for several enlargements of the table
  for (std::uint64_t key = 1; key <= pairs; ++key) {
    EXPECT_EQ(table.at(key).count, 0);
    table.at(key).count = static_cast<std::int32_t>(key);
  }
  for (std::uint64_t key = 1; key <= pairs; ++key) EXPECT_EQ(table.at(key).count, static_cast<std::int32_t>(key));
  table.forget();
  table.at(7).count = 1;
  table.at(pairs + 1).count = 2;
  EXPECT_EQ(table.at(7).count, 1);
  EXPECT_EQ(table.at(pairs + 1).count, 2);
  for (std::uint64_t key = 1; key <= pairs; ++key)
    if (key != 7) EXPECT_EQ(table.at(key).count, 0) << "pair " << key;
}

TEST(Crowd, ContactsMatchBruteForceBitwise) {
  test::Random random(77);
  compare(Crowd(random, 150, 0), random, {}, {}, 100);
}

TEST(Crowd, SelfContactsOfLongChainsMatchBruteForce) {
  test::Random random(78);
  compare(Crowd(random, 10, 2), random, {1, 5, 8}, {}, 100);
  SceneOptions apart;
  apart.between_systems = false;
  compare(Crowd(random, 3, 2), random, {0, 1}, apart, 30);
}

TEST(Crowd, WorkspaceFollowsSwitchesAndOtherScenes) {
  test::Random random(79);
  Crowd crowd(random, 150, 1);
  crowd.step(random, 0.1);
  Scene scene(crowd.systems);
  Workspace workspace(scene);
  std::vector<ContactPoint> off, on, again, other;
  find_contacts(scene, crowd.views, 0.05, workspace, off);
  scene.set_self_collision(0, true);
  find_contacts(scene, crowd.views, 0.05, workspace, on);
  EXPECT_GT(on.size(), off.size());
  scene.set_self_collision(0, false);
  find_contacts(scene, crowd.views, 0.05, workspace, again);
  EXPECT_EQ(again.size(), off.size());
  const std::vector<MechanismPtr> fewer(crowd.systems.begin() + 1, crowd.systems.end());
  const Scene small(fewer);
  find_contacts(small, std::span(crowd.views).subspan(1), 0.05, workspace, other);
  EXPECT_LT(other.size(), off.size());
  Workspace fresh;
  find_contacts(small, std::span(crowd.views).subspan(1), 0.05, fresh, again);
  EXPECT_EQ(again.size(), other.size());
}

TEST(Crowd, CoherentStepsAllocateNothing) {
  test::Random random(80);
  Crowd crowd(random, 160, 0);
  const Scene scene(crowd.systems);
  Workspace workspace(scene);
  std::vector<ContactPoint> contacts;
  long allocated = 0;
  for (int step = 0; step < 300; ++step) {
    crowd.step(random, 0.002);
    const long before = allocations_so_far();
    find_contacts(scene, crowd.views, 0.02, workspace, contacts);
    if (step > 100) allocated += allocations_so_far() - before;
  }
  EXPECT_LE(allocated, 2) << "allocations are allowed only for pairs that come near for the first time";
}

}  // namespace
}  // namespace ugoki::collision
