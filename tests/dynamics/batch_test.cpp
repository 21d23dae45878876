// Batched dynamics: results compared with the functions for one instance, independence of lanes, same bits for every SIMD register width.

#include "ugoki/dynamics/batch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "ugoki/base/hash.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/dynamics/kernels.h"
#include "varied_mechanism.h"

namespace ugoki::dynamics {
namespace {

using testing::RandomSource;

constexpr Vec3 gravity{0.7, -0.3, -9.81};

/// Calls `body` with each SIMD width that this processor supports, then selects the widest again.
template <class Body>
void for_each_width(const Body& body) {
  for (const SimdWidth width : {SimdWidth::plain, SimdWidth::avx2, SimdWidth::avx512}) {
    if (!use_simd(width)) continue;
    SCOPED_TRACE("width " + std::to_string(static_cast<int>(width)));
    body(width);
  }
  use_simd(widest_simd());
}

/// Random states, joint forces and external wrenches of several instances of one random mechanism.
struct Crowd {
  MechanismPtr m;
  std::vector<State> states;
  std::vector<std::vector<double>> external;

  Crowd(unsigned seed, int links, int instances) {
    RandomSource random(seed);
    m = Mechanism::make(testing::varied_spec(random, links, seed % 2 == 0)).value();
    for (int i = 0; i < instances; ++i) {
      State s(*m);
      testing::randomize(random, *m, s);
      std::vector<double> wrenches;
      for (const Vec6& f : s.external) wrenches.insert(wrenches.end(), {f.w.x, f.w.y, f.w.z, f.v.x, f.v.y, f.v.z});
      states.push_back(std::move(s));
      external.push_back(std::move(wrenches));
    }
  }

  template <class Real>
  BatchWorkspace<Real> batch() const {
    BatchWorkspace<Real> b(*m, static_cast<int>(states.size()));
    b.use_external();
    for (int i = 0; i < b.instances(); ++i) {
      const State& s = states[static_cast<std::size_t>(i)];
      b.set_state(i, s.q, s.v);
      b.set(b.tau, i, s.tau);
      b.set(b.external, i, external[static_cast<std::size_t>(i)]);
    }
    return b;
  }
};

double relative_difference(std::span<const double> a, std::span<const double> b) {
  double scale = 1, worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    scale = std::max(scale, std::fabs(b[i]));
    worst = std::max(worst, std::fabs(a[i] - b[i]));
  }
  return worst / scale;
}

template <class Real>
void expect_matches_single_instances(double tolerance) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Crowd crowd(seed, 3 + static_cast<int>(seed), static_cast<int>(1 + seed * 3));
    BatchWorkspace<Real> b = crowd.batch<Real>();
    Workspace ws(*crowd.m);
    const auto n = static_cast<std::size_t>(crowd.m->nv());
    std::vector<double> one(n), many(n), q(static_cast<std::size_t>(crowd.m->nq())), back(n);
    EXPECT_EQ(calc_forward_dynamics(b, gravity), 0);
    for (int i = 0; i < b.instances(); ++i) {
      const State& s = crowd.states[static_cast<std::size_t>(i)];
      ASSERT_TRUE(calc_forward_dynamics(*crowd.m, ws, s.q, s.v, s.tau, gravity, s.external, one));
      b.get(b.vdot, i, many);
      EXPECT_LT(relative_difference(many, one), tolerance) << "forward, instance " << i;
    }
    calc_inverse_dynamics(b, gravity);
    for (int i = 0; i < b.instances(); ++i) {
      b.get(b.tau, i, back);
      EXPECT_LT(relative_difference(back, crowd.states[static_cast<std::size_t>(i)].tau), tolerance) << "inverse, instance " << i;
    }
    BatchWorkspace<Real> stepping = crowd.batch<Real>();
    EXPECT_EQ(step_semi_implicit(stepping, gravity, 1e-3), 0);
    for (int i = 0; i < b.instances(); ++i) {
      State s = crowd.states[static_cast<std::size_t>(i)];
      ASSERT_TRUE(calc_forward_dynamics(*crowd.m, ws, s.q, s.v, s.tau, gravity, s.external, one));
      for (std::size_t k = 0; k < n; ++k) s.v[k] += 1e-3 * one[k];
      integrate(*crowd.m, s.q, s.v, 1e-3, s.q);
      stepping.get_state(i, q, many);
      EXPECT_LT(relative_difference(q, s.q), tolerance) << "step, q of instance " << i;
      EXPECT_LT(relative_difference(many, s.v), tolerance) << "step, v of instance " << i;
    }
  }
}

// The tolerances are rounding error times the condition number of these trees, which is up to 1e5.
TEST(Batch, DoubleResultsMatchSingleInstances) { expect_matches_single_instances<double>(1e-10); }
TEST(Batch, FloatResultsMatchSingleInstancesToSinglePrecision) { expect_matches_single_instances<float>(2e-2); }

template <class Real>
void expect_lanes_independent() {
  const Crowd crowd(4, 12, 37);
  BatchWorkspace<Real> clean = crowd.batch<Real>(), poisoned = crowd.batch<Real>();
  constexpr Real nan = std::numeric_limits<Real>::quiet_NaN(), huge = std::numeric_limits<Real>::max();
  const auto lanes = static_cast<std::size_t>(BatchWorkspace<Real>::lanes);
  const auto poison = [&](std::vector<Real>& x) {
    for (std::size_t k = 0; k < x.size(); ++k)
      if (k % lanes % 3 == 1) x[k] = k / lanes % 2 == 0 ? nan : huge;
  };
  for (std::vector<Real>* x : {&poisoned.q, &poisoned.v, &poisoned.tau, &poisoned.external}) poison(*x);
  step_semi_implicit(clean, gravity, 1e-3);
  step_semi_implicit(poisoned, gravity, 1e-3);
  calc_inverse_dynamics(clean, gravity);
  calc_inverse_dynamics(poisoned, gravity);
  for (auto x : {&BatchWorkspace<Real>::q, &BatchWorkspace<Real>::v, &BatchWorkspace<Real>::vdot, &BatchWorkspace<Real>::tau})
    for (std::size_t k = 0; k < (clean.*x).size(); ++k) {
      if (k % lanes % 3 == 1) continue;
      ASSERT_EQ((clean.*x)[k], (poisoned.*x)[k]) << k;
    }
}
TEST(Batch, NanInOneLaneDoesNotAffectOthers) {
  for_each_width([](SimdWidth) {
    expect_lanes_independent<double>();
    expect_lanes_independent<float>();
  });
}

TEST(Batch, SingularInstancesAreFlaggedAndNotMoved) {
  MechanismSpec spec;
  spec.name = "spinner";
  LinkSpec l;
  l.name = "rod";
  l.joint.type = JointType::prismatic;
  l.inertia = Inertia{1.0, {}, {}};
  spec.links.push_back(l);
  l.name = "tip";
  l.parent = "rod";
  l.joint.type = JointType::spherical;
  l.joint.X_PJ.p = {1, 0, 0};
  l.inertia = Inertia{1.0, {}, {}};  // a point mass at the ball's centre: no inertia about it
  spec.links.push_back(l);
  const MechanismPtr m = Mechanism::make(std::move(spec)).value();
  BatchWorkspace<double> b(*m, 3);
  const std::vector<double> q = b.q, v = b.v;
  EXPECT_EQ(step_semi_implicit(b, gravity, 0.01), 3);
  EXPECT_EQ(b.singular[2], 1);
  EXPECT_EQ(b.q, q);
  EXPECT_EQ(b.v, v);
}

/// Hash of the bits of all kernel results for one crowd.
std::string hash_of_all(const Crowd& crowd) {
  Hash64 hash;
  Workspace ws(*crowd.m);
  const auto n = static_cast<std::size_t>(crowd.m->nv());
  std::vector<double> x(n);
  for (const State& s : crowd.states) {
    EXPECT_TRUE(calc_forward_dynamics(*crowd.m, ws, s.q, s.v, s.tau, gravity, s.external, x));
    hash.add(x);
    calc_inverse_dynamics(*crowd.m, ws, s.q, s.v, s.tau, gravity, s.external, x);
    hash.add(x);
    calc_inertia_rows(*crowd.m, ws, s.q);
    hash.add(ws.M);
  }
  BatchWorkspace<double> d = crowd.batch<double>();
  BatchWorkspace<float> f = crowd.batch<float>();
  EXPECT_EQ(step_semi_implicit(d, gravity, 1e-3) + step_semi_implicit(f, gravity, 1e-3), 0);
  calc_inverse_dynamics(d, gravity);
  calc_inverse_dynamics(f, gravity);
  for (int i = 0; i < d.instances(); ++i) {
    for (auto array : {&BatchWorkspace<double>::v, &BatchWorkspace<double>::vdot, &BatchWorkspace<double>::tau}) {
      d.get(d.*array, i, x);
      hash.add(x);
    }
    for (auto array : {&BatchWorkspace<float>::v, &BatchWorkspace<float>::vdot, &BatchWorkspace<float>::tau}) {
      f.get(f.*array, i, x);
      hash.add(x);
    }
  }
  return hash.hex();
}

TEST(Batch, ResultsAreBitIdenticalForAllSimdWidths) {
  const Crowd crowd(10, 14, 21);
  std::string first;
  int widths = 0;
  for_each_width([&](SimdWidth) {
    ++widths;
    const std::string hash = hash_of_all(crowd);
    if (first.empty()) first = hash;
    EXPECT_EQ(hash, first);
    EXPECT_EQ(hash, "dd779350638c1954");  // computed with clang 19 at -O3
  });
  EXPECT_GE(widths, 1);
}

}  // namespace
}  // namespace ugoki::dynamics
