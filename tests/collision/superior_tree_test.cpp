// The queries of the superior tree (box hierarchy over groups of bodies), compared with measuring all pairs.

#include "ugoki/collision/superior_tree.h"

#include <gtest/gtest.h>

#include "allocation_count.h"
#include "random_shapes.h"
#include "ugoki/collision/pair_queries.h"

namespace ugoki::collision {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Groups of bodies, one shape each, that move by small steps.
class World {
 public:
  /// @param size m, half width of the region of the groups
  /// @param spread m, half width of the region of a group's bodies
  World(unsigned seed, int groups, int links, double size) : World(seed, groups, links, size, 0.1 * size) {}
  World(unsigned seed, int groups, int links, double size, double spread) : random_(seed) {
    for (int g = 0; g < groups; ++g) {
      const Vec3 base = random_.vec(size);
      for (int i = 0; i < links; ++i) {
        Shape s = random_.shape();
        s.X_BS = {};
        shapes.push_back(s);
        bodies.push_back(make_tree_body(make_collider(s), g));
        poses.push_back({rotation_about(random_.unit(), random_.in(-pi, pi)), base + random_.vec(spread)});
        spin_.push_back(random_.vec(0.03));
        drift_.push_back(random_.vec(0.02));
      }
    }
  }
  void move(double speed = 1) {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      if (random_.below(50) == 0) drift_[i] = random_.vec(0.02), spin_[i] = random_.vec(0.03);
      poses[i].p += drift_[i] * speed - poses[i].p * (0.001 * speed);
      poses[i].R = to_matrix(exp_map(spin_[i] * speed)) * poses[i].R;
    }
  }
  test::Random& random() { return random_; }

  std::vector<Shape> shapes;
  std::vector<TreeBody> bodies;
  std::vector<Pose> poses;

 private:
  test::Random random_;
  std::vector<Vec3> spin_, drift_;
};

/// The closed-form distances as a PairFunction. Above the cutoff it returns the cutoff, the weakest lower bound that is allowed.
class ClosedForms : public PairFunction {
 public:
  explicit ClosedForms(const World& world) : world_(world) {}
  PairDistance distance(int a, int b, double cutoff, PairCache&) override {
    ++calls;
    const auto i = static_cast<std::size_t>(a), k = static_cast<std::size_t>(b);
    PairDistance out;
    out = closed_form_distance(world_.shapes[i], world_.poses[i], world_.shapes[k], world_.poses[k]);
    out.exact = out.distance <= cutoff;
    if (!out.exact) out.lower = cutoff;  // the weakest allowed bound
    return out;
  }
  int calls = 0;

 private:
  const World& world_;
};

NearPair brute_nearest(const World& w, int group_a, int group_b, const PairFilter& filter) {
  ClosedForms f(w);
  NearPair best;
  best.near.distance = infinity;
  PairCache cache;
  for (int a = 0; a < static_cast<int>(w.bodies.size()); ++a)
    for (int b = 0; b < static_cast<int>(w.bodies.size()); ++b) {
      if (w.bodies[static_cast<std::size_t>(a)].group != group_a || w.bodies[static_cast<std::size_t>(b)].group != group_b) continue;
      if ((group_a == group_b && a >= b) || filter.excluded(a, b)) continue;
      const PairDistance d = f.distance(a, b, infinity, cache);
      if (d.distance < best.near.distance) best = {{a, b}, d};
    }
  return best;
}

std::vector<NearPair> brute_within(const World& w, double margin, const PairFilter& filter) {
  ClosedForms f(w);
  std::vector<NearPair> out;
  PairCache cache;
  for (int a = 0; a < static_cast<int>(w.bodies.size()); ++a)
    for (int b = a + 1; b < static_cast<int>(w.bodies.size()); ++b) {
      const int ga = w.bodies[static_cast<std::size_t>(a)].group, gb = w.bodies[static_cast<std::size_t>(b)].group;
      if (ga == gb ? !filter.inside(ga) : !filter.between_groups) continue;
      if (filter.excluded(a, b)) continue;
      const PairDistance d = f.distance(a, b, infinity, cache);
      if (d.distance <= margin) out.push_back({{a, b}, d});
    }
  return out;
}

TEST(SuperiorTree, ClosestPairMatchesBruteForce) {
  long calls = 0, pairs = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    World w(seed, 2, seed % 3 == 0 ? 1 : 20, seed % 4 == 0 ? 0.3 : 2.0);
    SuperiorTree tree(w.bodies);
    ClosestPair query(0, 1);
    ClosedForms f(w);
    for (int step = 0; step < 300; ++step) {
      w.move(step % 97 == 0 ? 20 : 1);
      tree.update(w.poses);
      const NearPair& found = query.find(tree, f);
      const NearPair expected = brute_nearest(w, 0, 1, {});
      ASSERT_EQ(found.near.distance, expected.near.distance) << "seed " << seed << " step " << step;
      ASSERT_EQ(found.bodies, expected.bodies);
    }
    calls += f.calls;
    pairs += 300L * tree.bodies() * tree.bodies() / 4;
  }
  EXPECT_LT(calls * 15, pairs);
}

TEST(SuperiorTree, ClosestPairIsCorrectAfterStepsWithoutQueries) {
  World w(5, 3, 12, 1.5);
  SuperiorTree tree(w.bodies);
  ClosestPair one(0, 2), two(2, 1);
  ClosedForms f(w);
  for (int step = 0; step < 500; ++step) {
    w.move();
    tree.update(w.poses);
    if (step % 7 == 0) {
      ASSERT_EQ(one.find(tree, f).near.distance, brute_nearest(w, 0, 2, {}).near.distance) << step;
    }
    if (step % 31 == 0) {
      ASSERT_EQ(two.find(tree, f).bodies, brute_nearest(w, 2, 1, {}).bodies) << step;
    }
  }
}

TEST(SuperiorTree, SelfCollisionIgnoresExcludedPairs) {
  World w(9, 2, 20, 1.0);
  PairFilter filter;
  std::vector<BodyPair> excluded;
  for (int i = 0; i + 1 < 20; ++i) excluded.push_back({i + 1, i});
  filter.exclude(excluded);
  SuperiorTree tree(w.bodies);
  ClosestPair query(0, 0, filter);
  ClosedForms f(w);
  for (int step = 0; step < 300; ++step) {
    w.move();
    tree.update(w.poses);
    const NearPair expected = brute_nearest(w, 0, 0, filter);
    ASSERT_EQ(query.find(tree, f).near.distance, expected.near.distance) << step;
    ASSERT_EQ(query.find(tree, f).bodies, expected.bodies) << step;
  }
}

void expect_same(const std::vector<NearPair>& found, const std::vector<NearPair>& expected, int step) {
  ASSERT_EQ(found.size(), expected.size()) << step;
  for (std::size_t i = 0; i < found.size(); ++i) {
    ASSERT_EQ(found[i].bodies, expected[i].bodies) << step;
    ASSERT_EQ(found[i].near.distance, expected[i].near.distance) << step;
  }
}

TEST(SuperiorTree, PairsWithinMarginMatchBruteForce) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    World w(100 + seed, seed % 2 == 0 ? 60 : 4, seed % 2 == 0 ? 1 : 15, 3.0);
    PairFilter filter;
    filter.inside_group = {0, 1, 0, 1};
    filter.between_groups = seed != 5;
    filter.exclude({{16, 18}, {3, 40}, {22, 20}});
    SuperiorTree tree(w.bodies);
    PairsWithin query(filter);
    ClosedForms f(w);
    std::vector<NearPair> found;
    std::size_t maximum = 0;
    for (int step = 0; step < 200; ++step) {
      w.move(step % 61 == 0 ? 30 : 1);
      tree.update(w.poses);
      const double margin = step < 150 ? 0.2 : step < 175 ? -0.05 : 0.5;
      query.find(tree, margin, f, found);
      expect_same(found, brute_within(w, margin, filter), step);
      maximum = std::max(maximum, found.size());
    }
    EXPECT_GT(maximum, 20u);
  }
}

TEST(SuperiorTree, ResultsDoNotDependOnHistory) {
  World w(31, 10, 8, 2.0);
  PairFilter filter;
  filter.inside_group.assign(10, 1);
  SuperiorTree tree(w.bodies);
  PairsWithin query(filter);
  ClosedForms f(w);
  std::vector<NearPair> found, again;
  for (int step = 0; step < 150; ++step) {
    w.move();
    tree.update(w.poses);
    query.find(tree, 0.1, f, found);
    if (step % 10 != 0) continue;
    SuperiorTree fresh(w.bodies);
    fresh.update(w.poses);
    PairsWithin first(filter);
    first.find(fresh, 0.1, f, again);
    expect_same(found, again, step);
  }
}

TEST(SuperiorTree, CoherentStepsAllocateNothing) {
  World w(77, 2, 20, 2.0);
  SuperiorTree tree(w.bodies);
  ClosestPair nearest(0, 1);
  PairsWithin within({});
  ClosedForms f(w);
  std::vector<NearPair> found;
  found.reserve(400);
  for (int step = 0; step < 2000; ++step) {
    const long before = allocations_so_far();
    w.move(0.3);
    tree.update(w.poses);
    (void)nearest.find(tree, f);
    within.find(tree, 0.2, f, found);
    if (step >= 500) {
      ASSERT_EQ(allocations_so_far(), before) << step;
    }
  }
}

TEST(SuperiorTree, CoherentStepsExamineFewPairs) {
  World w(8, 2, 200, 4.0, 3.0);
  SuperiorTree tree(w.bodies);
  ClosestPair nearest(0, 1);
  ClosedForms f(w);
  long examined = 0, front = 0;
  for (int step = 0; step < 200; ++step) {
    w.move(0.3);
    tree.update(w.poses);
    (void)nearest.find(tree, f);
    examined += nearest.counts().candidates;
    front += nearest.counts().front;
  }
  EXPECT_LT(examined, 200 * 200);
  EXPECT_LT(front, 200 * 4000);  // sum over 200 steps of the number of node pairs in the front; there are 40000 pairs of bodies
}

TEST(SuperiorTree, DistantPairsAtRestAreNotMeasuredAgain) {
  World w(55, 2, 20, 1.0, 1.0);
  SuperiorTree tree(w.bodies);
  ClosestPair nearest(0, 1);
  PairsWithin within({});
  ClosedForms f(w), g(w);
  std::vector<NearPair> found;
  for (int step = 0; step < 10; ++step) {
    tree.update(w.poses);
    f.calls = g.calls = 0;
    (void)nearest.find(tree, f);
    within.find(tree, step < 3 ? -1 : 0.05, g, found);  // finds no pair in the first three steps; then the margin becomes 0.05 m
  }
  EXPECT_EQ(f.calls, 1);
  EXPECT_EQ(g.calls, static_cast<int>(found.size()));
}

TEST(SuperiorTree, BodiesAtNonFinitePosesAreIgnored) {
  World w(13, 2, 6, 1.0);
  SuperiorTree tree(w.bodies);
  ClosestPair nearest(0, 1);
  PairsWithin within({});
  ClosedForms f(w);
  std::vector<NearPair> found;
  for (int step = 0; step < 60; ++step) {
    w.move();
    World broken = w;
    ClosedForms g(broken);
    const bool bad = step / 10 % 2 == 1;
    if (bad) broken.poses[2].p.y = step < 30 ? infinity : -std::nan("");
    if (bad) broken.poses[7].R.xx = std::nan("");
    tree.update(broken.poses);
    // Expected: the closest pair of the remaining bodies.
    NearPair expected;
    expected.near.distance = infinity;
    PairCache cache;
    for (int a = 0; a < 6; ++a)
      for (int b = 6; b < 12; ++b) {
        if (bad && (a == 2 || b == 7)) continue;
        const PairDistance d = g.distance(a, b, infinity, cache);
        if (d.distance < expected.near.distance) expected = {{a, b}, d};
      }
    ASSERT_EQ(nearest.find(tree, g).near.distance, expected.near.distance) << step;
    within.find(tree, 10, g, found);
    ASSERT_EQ(found.size(), bad ? 25u : 36u) << step;
  }
}

TEST(SuperiorTree, EmptyTreeAndSingleBodyHaveNoPairs) {
  SuperiorTree none{std::span<const TreeBody>{}};
  none.update({});
  World w(1, 1, 1, 1);
  ClosedForms f(w);
  std::vector<NearPair> found;
  PairsWithin within({});
  within.find(none, 1, f, found);
  EXPECT_TRUE(found.empty());
  SuperiorTree one(w.bodies);
  one.update(w.poses);
  within.find(one, 1, f, found);
  EXPECT_TRUE(found.empty());
  ClosestPair self(0, 0), other(0, 3);
  EXPECT_EQ(self.find(one, f).bodies.a, -1);
  EXPECT_EQ(other.find(one, f).near.distance, infinity);
}

TEST(SuperiorTree, ExactFarFromTheOriginAndAfterLongTravel) {
  World w(21, 2, 10, 1.0);
  for (Pose& X : w.poses) X.p += {3e4, -2e4, 1e4};
  SuperiorTree tree(w.bodies);
  ClosestPair query(0, 1);
  ClosedForms f(w);
  for (int step = 0; step < 400; ++step) {
    for (std::size_t i = 0; i < w.poses.size(); ++i) w.poses[i].p += Vec3{900.0 + (i % 2 == 0 ? 0.01 : 0.0), 0, 0};
    tree.update(w.poses);
    ASSERT_EQ(query.find(tree, f).near.distance, brute_nearest(w, 0, 1, {}).near.distance) << step;
  }
}

}  // namespace
}  // namespace ugoki::collision
