// The fast kernels, one instance at a time: against the paper's unit vectors, over all joint types and widths of registers.

#include "ugoki/dynamics/kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "random_mechanism.h"
#include "ugoki/base/hash.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::dynamics {
namespace {

using testing::RandomSource;

constexpr Vec3 gravity{0.7, -0.3, -9.81};

void expect_near(std::span<const double> a, std::span<const double> b, double relative, const char* what) {
  double scale = 1;
  for (const double x : b) scale = std::max(scale, std::fabs(x));
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], relative * scale) << what << ", freedom " << i;
}

/// All joint types; coordinate axes and their opposites among the others, joint frames turned and not.
MechanismSpec varied_spec(RandomSource& random, int links, bool floating_base) {
  MechanismSpec spec = testing::random_spec(random, links, {}, floating_base);
  for (LinkSpec& l : spec.links) {
    if (random.below(3) > 0) l.joint.X_PJ.R = Mat3::identity();
    if (random.below(3) > 0) {
      const double sign = random.below(2) == 0 ? 1 : -1;
      const int k = random.below(3);
      l.joint.axis = {k == 0 ? sign : 0, k == 1 ? sign : 0, k == 2 ? sign : 0};
      l.joint.axis2 = {k == 1 ? sign : 0, k == 2 ? sign : 0, k == 0 ? sign : 0};
    }
  }
  return spec;
}

TEST(Kernels, AgreeWithTheUnitVectorMethod) {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    RandomSource random(seed);
    const MechanismPtr m = Mechanism::make(varied_spec(random, 1 + random.below(25), seed % 2 == 0)).value();
    Workspace ws(*m);
    State s(*m);
    testing::randomize(random, *m, s);
    const std::span<const Vec6> external = seed % 3 == 0 ? std::span<const Vec6>() : s.external;
    update_kinematics(*m, s.q, s.v, ws);
    std::vector<double> by_units(s.v.size()), vdot(s.v.size()), tau(s.v.size()), staged(s.v.size());
    ASSERT_TRUE(calc_forward_dynamics_by_unit_vectors(*m, ws, s.tau, gravity, external, by_units));
    ASSERT_TRUE(calc_forward_dynamics(*m, ws, s.q, s.v, s.tau, gravity, external, vdot));
    expect_near(vdot, by_units, 1e-9, "forward");
    calc_inverse_dynamics(*m, ws, s.q, s.v, vdot, gravity, external, tau);
    expect_near(tau, s.tau, 1e-9, "inverse of forward");
    calc_inverse_dynamics(*m, ws, s.q, s.v, {}, gravity, external, tau);
    calc_inverse_dynamics(*m, ws, {}, gravity, external, staged);
    expect_near(tau, staged, 1e-12, "bias");
    const auto n = s.v.size();
    std::vector<double> M(n * n), reference(n * n);
    calc_inertia_matrix(*m, ws, reference);
    calc_inertia_rows(*m, ws, s.q);
    copy_inertia_rows(ws, M);
    expect_near(M, reference, 1e-12, "inertia matrix, entry");
  }
}

}  // namespace
}  // namespace ugoki::dynamics
