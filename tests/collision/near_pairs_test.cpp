#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <set>
#include <utility>

#include "ugoki/collision/near_self_pairs.h"

namespace ugoki::collision {
namespace {

using Pairs = std::set<std::pair<int, int>>;

/// Spheres that move through each other, while all of them travel and turn together.
class Swarm {
 public:
  Swarm(int count, int first, std::uint32_t seed) : random_(seed) {
    for (int i = 0; i < count; ++i) {
      balls.push_back({{}, 0.02 + 0.1 * unit_(random_)});
      at_.push_back({place(), place(), place()});
      v_.push_back(Vec3{place(), place(), place()} * 0.5);
    }
    for (int a = 0; a < count; ++a)
      for (int b = a + 1; b < count; ++b)
        if (unit_(random_) < 0.7) all.push_back({first + a, first + b});
  }
  void move(double dt) {
    time_ += dt;
    const Mat3 R = to_matrix(exp_map({0.7 * time_, 0.3 * time_, 0}));
    for (std::size_t i = 0; i < balls.size(); ++i) {
      at_[i] += v_[i] * dt;
      for (int k = 0; k < 3; ++k)
        if (std::fabs(at_[i][k]) > 1) v_[i][k] = -v_[i][k];
      balls[i].c = R * at_[i] + Vec3{3 * time_, 0, -5 * time_};
    }
  }
  /// Pairs whose spheres are closer than the margin.
  [[nodiscard]] Pairs near(int first, double margin) const {
    Pairs out;
    for (const ShapePair& p : all) {
      const Workspace::Ball &a = balls[static_cast<std::size_t>(p.a - first)], &b = balls[static_cast<std::size_t>(p.b - first)];
      if (norm(a.c - b.c) < a.r + b.r + margin) out.insert({p.a, p.b});
    }
    return out;
  }

  std::vector<Workspace::Ball> balls;
  std::vector<ShapePair> all;

 private:
  double place() { return 2 * unit_(random_) - 1; }
  std::mt19937 random_;
  std::uniform_real_distribution<double> unit_{0, 1};
  std::vector<Vec3> at_, v_;
  double time_ = 0;
};

TEST(NearSelfPairs, ContainAllPairsWithinTheMargin) {
  constexpr int first = 17;
  for (std::uint32_t seed = 0; seed < 5; ++seed) {
    Swarm swarm(30, first, seed);
    Workspace::NearPairs known;
    std::size_t returned = 0, made = 0;
    constexpr int steps = 2000;
    for (int i = 0; i < steps; ++i) {
      swarm.move(i % 500 == 499 ? 0.5 : 0.002);  // jumps as well
      const double margin = i % 3 == 0 ? 0.02 : i % 3 == 1 ? -4e-4 : 0.01;
      const std::vector<Vec3> before = known.at;
      const std::span<const ShapePair> pairs = near_self_pairs(swarm.all, swarm.balls, first, margin, known);
      made += before != known.at ? 1 : 0;
      returned += pairs.size();
      const auto order = [](const ShapePair& p, const ShapePair& q) { return std::pair(p.a, p.b) < std::pair(q.a, q.b); };
      EXPECT_TRUE(std::ranges::is_sorted(pairs, order));
      Pairs found;
      for (const ShapePair& p : pairs) found.insert({p.a, p.b});
      for (const auto& p : swarm.near(first, margin)) ASSERT_TRUE(found.contains(p)) << "seed " << seed << ", step " << i;
    }
    EXPECT_LT(returned, steps * swarm.all.size() / 2);  // the list leaves out most of the pairs,
    EXPECT_LT(made, steps / 4U);                        // and is not made again in most steps
  }
}

TEST(NearSelfPairs, FewPairsAreReturnedAsTheyAre) {
  Swarm swarm(6, 0, 1);
  swarm.move(0.002);
  Workspace::NearPairs known;
  EXPECT_EQ(near_self_pairs(swarm.all, swarm.balls, 0, 0.02, known).data(), swarm.all.data());
}

TEST(NearSelfPairs, SpheresThatAreNotFiniteAreInNoPairAndReturn) {
  Swarm swarm(30, 0, 2);
  swarm.move(0.002);
  Workspace::NearPairs known;
  (void)near_self_pairs(swarm.all, swarm.balls, 0, 0.02, known);
  const Vec3 before = swarm.balls[0].c;
  swarm.balls[0].c.x = std::numeric_limits<double>::quiet_NaN();
  for (const ShapePair& p : near_self_pairs(swarm.all, swarm.balls, 0, 0.02, known)) EXPECT_NE(p.a, 0);
  swarm.balls[0].c = before;
  Pairs found;
  for (const ShapePair& p : near_self_pairs(swarm.all, swarm.balls, 0, 0.02, known)) found.insert({p.a, p.b});
  for (const auto& p : swarm.near(0, 0.02)) EXPECT_TRUE(found.contains(p));
}

}  // namespace
}  // namespace ugoki::collision
