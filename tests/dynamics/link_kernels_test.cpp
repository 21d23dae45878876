#include "ugoki/dynamics/link_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "../mechanism/chain.h"
#include "random_mechanism.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/dynamics/kernels.h"

namespace ugoki::dynamics {
namespace {

constexpr Vec3 gravity{0.5, -1, -9.81};

/// A random mechanism in a random state.
struct Case {
  testing::RandomSource random;
  MechanismPtr m;
  State s;
  std::vector<double> vdot, other_v;  // random accelerations and velocities

  explicit Case(unsigned seed)
      : random(seed), m(Mechanism::make(testing::random_spec(random, 1 + random.below(25), {}, seed % 2 == 0)).value()), s(*m) {
    testing::randomize(random, *m, s);
    for (std::size_t i = 0; i < s.v.size(); ++i) {
      vdot.push_back(random.uniform(-5, 5));
      other_v.push_back(random.uniform(-5, 5));
    }
  }
};

double maximum(const Vec6& a) { return std::max({norm(a.w), norm(a.v)}); }

TEST(LinkKernels, HaveTheSameBitsForAllSimdWidths) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const Case c(seed);
    std::vector<double> first;
    for (const SimdWidth width : {SimdWidth::plain, SimdWidth::avx2, SimdWidth::avx512}) {
      if (!use_simd(width)) continue;
      Workspace ws(*c.m);
      std::vector<double> results, tau(c.s.v.size());
      const auto add = [&](const auto& values) {
        const auto* const begin = reinterpret_cast<const double*>(values.data());
        results.insert(results.end(), begin, begin + values.size() * sizeof(values[0]) / sizeof(double));
      };
      update_kinematics(*c.m, c.s.q, c.s.v, ws);
      add(ws.X_WB);
      add(ws.S);
      add(ws.V);
      add(ws.C);
      add(ws.I);
      calc_inverse_dynamics(*c.m, ws, c.vdot, gravity, c.s.external, tau);
      add(tau);
      add(ws.F);
      calc_bias_forces(*c.m, ws, c.s.q, c.other_v, gravity, c.s.external, tau);
      add(tau);
      if (width == SimdWidth::plain) first = results;
      ASSERT_EQ(results.size(), first.size());
      EXPECT_EQ(std::memcmp(results.data(), first.data(), first.size() * sizeof(double)), 0) << "seed " << seed;
    }
    use_simd(widest_simd());
  }
}

// The tolerances allow for the rounding errors of a few dozen additions.
TEST(LinkKernels, KinematicsAgreeWithTheirDefinitions) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Case c(seed);
    Kinematics k(*c.m);
    update_kinematics(*c.m, c.s.q, c.s.v, k);
    for (int i = 0; i < c.m->link_count(); ++i) {
      const auto at = static_cast<std::size_t>(i);
      const Link& link = c.m->link(i);
      const Pose X{k.X_WB[at].R, k.X_WB[at].p - k.p0};
      const double size = 1 + norm(X.p);
      Vec6 V = link.parent < 0 ? Vec6{} : k.V[static_cast<std::size_t>(link.parent)];
      Vec6 S[6], vJ;
      const int n = joint_subspace(link.joint, c.s.q.data() + link.q_index, S);
      for (int d = 0; d < n; ++d) {
        const auto dof = static_cast<std::size_t>(link.v_index + d);
        const Vec6 column = X.motion_to_parent(S[d]);
        EXPECT_LT(maximum(k.S[dof] - column), 1e-14 * size) << "link " << i;
        vJ += column * c.s.v[dof];
      }
      V += vJ;
      const Vec6 C =
          cross_motion(V, vJ) + X.motion_to_parent(joint_bias(link.joint, c.s.q.data() + link.q_index, c.s.v.data() + link.v_index));
      EXPECT_LT(maximum(k.V[at] - V), 1e-13 * size * (1 + maximum(V))) << "link " << i;
      EXPECT_LT(maximum(k.C[at] - C), 1e-13 * size * (1 + maximum(V) * maximum(V))) << "link " << i;
      const Inertia I = link.inertia.in_parent(X);
      const double scale = 1e-14 * (1 + I.I.xx + I.I.yy + I.I.zz);
      EXPECT_EQ(k.I[at].mass, I.mass);
      EXPECT_LT(norm(k.I[at].h - I.h), scale * size) << "link " << i;
      for (int column = 0; column < 3; ++column)
        EXPECT_LT(norm(k.I[at].I.matrix().column(column) - I.I.matrix().column(column)), scale) << "link " << i;
    }
  }
}

// A body 10 km away along the axis x: its inertia about this axis is that about its centre, and must not be a difference of large numbers.
TEST(LinkKernels, InertiaOfADistantBodyKeepsItsAccuracy) {
  const MechanismPtr m = testing::make_chain(2, [](int i, LinkSpec& l) {
    l.joint.type = JointType::revolute;
    l.joint.axis = {1, 0, 0};
    if (i > 0) l.joint.X_PJ.p = {1e4, 0, 0.1};
    l.inertia = Inertia::from_centre(1, {}, {0.01, 0.01, 0.01, 0, 0, 0});
  });
  Kinematics k(*m);
  const State s(*m);
  update_kinematics(*m, s.q, s.v, k);
  EXPECT_NEAR(k.I[1].I.xx, 0.02, 1e-15);
}

// The kernel that starts from q and v computes in link frames, by other code.
TEST(LinkKernels, ForcesAgreeWithTheFastKernel) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Case c(seed);
    Workspace ws(*c.m);
    const std::size_t n = c.s.v.size();
    std::vector<double> staged(n), fast(n);
    update_kinematics(*c.m, c.s.q, c.s.v, ws);
    const auto expect_equal = [&](const char* what) {
      double scale = 1;
      for (const double x : fast) scale = std::max(scale, std::fabs(x));
      for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(staged[i], fast[i], 1e-11 * scale) << what << ", DOF " << i;
    };
    calc_inverse_dynamics(*c.m, ws, c.vdot, gravity, c.s.external, staged);
    calc_inverse_dynamics(*c.m, ws, c.s.q, c.s.v, c.vdot, gravity, c.s.external, fast);
    expect_equal("with accelerations");
    calc_inverse_dynamics(*c.m, ws, {}, gravity, {}, staged);
    calc_inverse_dynamics(*c.m, ws, c.s.q, c.s.v, {}, gravity, {}, fast);
    expect_equal("without accelerations");
    calc_bias_forces(*c.m, ws, c.s.q, c.other_v, gravity, c.s.external, staged);
    calc_inverse_dynamics(*c.m, ws, c.s.q, c.other_v, {}, gravity, c.s.external, fast);
    expect_equal("bias at other velocities");
  }
}

}  // namespace
}  // namespace ugoki::dynamics
