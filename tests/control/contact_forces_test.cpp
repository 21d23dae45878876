#include "ugoki/control/contact_forces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "ugoki/dynamics/kernels.h"

namespace ugoki::control {
namespace {

double random_number(std::mt19937_64& engine, double size) { return std::uniform_real_distribution<double>(-size, size)(engine); }

std::vector<Support> two_feet(double friction) {
  std::vector<Support> out;
  for (const double y : {-0.1, 0.1})
    for (const double x : {-0.05, 0.2})
      for (const double w : {-0.04, 0.04}) out.push_back({{x, y + w, 0}, {0, 0, 1}, friction});
  return out;
}

/// Independent reference: projected coordinate descent on the primal problem, slow but simple.
double primal_optimum(const std::vector<Support>& supports, const Vec3& origin, const Vec6& w, double lever, double eps) {
  std::vector<Vec6> G;
  std::vector<double> costs;
  for (const Support& s : supports) {
    const Vec3 t1 = normalized(s.along - s.n * dot(s.n, s.along)), t2 = cross(s.n, t1);
    for (const Vec3& t : {t1, -t1, t2, -t2}) {
      const Vec3 e = s.n + t * s.friction;
      G.push_back({cross(s.p - origin, e) / lever, e});
      costs.push_back(eps * s.cost);
    }
  }
  std::vector<double> beta(G.size(), 0.0);
  Vec6 r{w.w / lever, w.v};
  for (int sweep = 0; sweep < 200000; ++sweep) {
    double change = 0;
    for (std::size_t k = 0; k < G.size(); ++k) {
      const double next = std::max(0.0, beta[k] + (dot(G[k], r) - costs[k] * beta[k]) / (dot(G[k], G[k]) + costs[k]));
      r -= G[k] * (next - beta[k]);
      change = std::max(change, std::fabs(next - beta[k]));
      beta[k] = next;
    }
    if (change < 1e-12) break;
  }
  double value = 0.5 * dot(r, r);
  for (std::size_t k = 0; k < beta.size(); ++k) value += 0.5 * costs[k] * beta[k] * beta[k];
  return value;
}

TEST(ContactForces, StandingWeightIsSharedWithoutMissingWrench) {
  ContactForceProblem problem;
  const std::vector<Support> feet = two_feet(0.7);
  std::vector<Vec3> forces(feet.size());
  const Vec6 missing = problem.solve(feet, {0.07, 0, 0.9}, {{}, {0, 0, 700}}, 0.9, 1e-6, forces);
  EXPECT_LT(norm(missing.v), 0.01);
  EXPECT_LT(norm(missing.w), 0.01);
  for (const Vec3& f : forces) EXPECT_GE(f.z, 0);
}

TEST(ContactForces, HaveTheSameBitsForAllSimdWidths) {
  std::mt19937_64 engine(5);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<Support> feet = two_feet(0.7);
    for (Support& s : feet) s.cost = 1 + 0.5 * trial;
    Vec6 wrench;
    for (int k = 0; k < 3; ++k) {
      wrench.w[k] = random_number(engine, 200);
      wrench.v[k] = random_number(engine, 800);
    }
    std::vector<Vec3> first(feet.size()), forces(feet.size());
    Vec6 first_missing;
    for (const dynamics::SimdWidth width : {dynamics::SimdWidth::plain, dynamics::SimdWidth::avx2, dynamics::SimdWidth::avx512}) {
      if (!dynamics::use_simd(width)) continue;
      ContactForceProblem problem;
      const Vec6 missing = problem.solve(feet, {0.07, 0, 0.9}, wrench, 0.9, 1e-4, forces);
      if (width == dynamics::SimdWidth::plain) {
        first = forces;
        first_missing = missing;
      }
      EXPECT_EQ(forces, first) << "trial " << trial;
      EXPECT_EQ(missing, first_missing) << "trial " << trial;
    }
    dynamics::use_simd(dynamics::widest_simd());
  }
}

TEST(ContactForces, MatchesIndependentOptimizer) {
  std::mt19937_64 engine(5);
  for (int trial = 0; trial < 60; ++trial) {
    std::vector<Support> feet = two_feet(trial % 2 ? 0.7 : 0.3);
    if (trial % 3 == 0)
      for (Support& s : feet) s.cost = 1 + 50 * std::fabs(random_number(engine, 1));
    const Vec6 w{{random_number(engine, 200), random_number(engine, 200), random_number(engine, 50)},
                 {random_number(engine, 400), random_number(engine, 400), 400 + random_number(engine, 800)}};
    const Vec3 origin{random_number(engine, 0.2), random_number(engine, 0.2), 0.9};
    const double eps = 1e-2, lever = 0.9;
    ContactForceProblem problem;
    std::vector<Vec3> forces(feet.size());
    const Vec6 missing = problem.solve(feet, origin, w, lever, eps, forces);
    EXPECT_LT(problem.iterations(), 30);
    // The primal objective cannot be calculated from the forces, because the multipliers beta of the friction pyramids are not unique. The
    // objective follows from the missing wrench: y = missing (moments / lever) is the dual optimum, and the optimal value is w.y / 2.
    const double value = 0.5 * (dot(w.w, missing.w) / (lever * lever) + dot(w.v, missing.v));
    const double wanted = primal_optimum(feet, origin, w, lever, eps);
    EXPECT_NEAR(value, wanted, 1e-6 * (1 + std::fabs(wanted))) << "trial " << trial;
    for (std::size_t i = 0; i < feet.size(); ++i) {
      const Vec3 f = forces[i];
      const Vec3 t1 = any_perpendicular({0, 0, 1}), t2 = cross(Vec3{0, 0, 1}, t1);
      EXPECT_LE(std::fabs(dot(f, t1)) + std::fabs(dot(f, t2)), feet[i].friction * f.z + 1e-9);
    }
  }
}

TEST(ContactForces, DownwardForceOrNoSupportIsAllMissing) {
  ContactForceProblem problem;
  const std::vector<Support> feet = two_feet(0.7);
  std::vector<Vec3> forces(feet.size());
  const Vec6 down = problem.solve(feet, {0, 0, 0.9}, {{}, {0, 0, -500}}, 0.9, 1e-6, forces);
  EXPECT_NEAR(down.v.z, -500, 1e-6);
  const Vec6 flight = problem.solve({}, {0, 0, 0.9}, {{1, 2, 3}, {4, 5, 6}}, 0.9, 1e-6, {});
  EXPECT_EQ(flight.v.x, 4);
}

}  // namespace
}  // namespace ugoki::control
