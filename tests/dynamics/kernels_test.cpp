// The fast kernels on single instances, compared with the paper's unit-vector method for all joint types and SIMD register widths.

#include "ugoki/dynamics/kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>

#include "../mechanism/chain.h"
#include "allocation_count.h"
#include "ugoki/dynamics/batch.h"
#include "ugoki/dynamics/dynamics.h"
#include "varied_mechanism.h"

namespace ugoki::dynamics {
namespace {

using testing::RandomSource;

constexpr Vec3 gravity{0.7, -0.3, -9.81};

void expect_near(std::span<const double> a, std::span<const double> b, double relative, const char* label) {
  double scale = 1;
  for (const double x : b) scale = std::max(scale, std::fabs(x));
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], relative * scale) << label << ", degree of freedom " << i;
}

TEST(Kernels, AgreeWithTheUnitVectorMethod) {
  std::size_t pairs = 0;
  for (unsigned seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    RandomSource random(seed);
    const MechanismPtr m = Mechanism::make(seed <= 200 ? testing::varied_spec(random, 1 + random.below(25), seed % 2 == 0)
                                                       : testing::twins_spec(random, seed % 2 == 0))
                               .value();
    Workspace ws(*m);
    pairs += ws.twins.pairs.size();
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
  EXPECT_GT(pairs, 300U);
}

// Mechanisms with twins (equal subtrees in two lanes) give identical bits for every SIMD register width.
TEST(Kernels, ResultsAreBitIdenticalForAllSimdWidths) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    RandomSource random(seed);
    const MechanismPtr m = Mechanism::make(testing::twins_spec(random, seed % 2 == 0)).value();
    Workspace ws(*m);
    State s(*m);
    testing::randomize(random, *m, s);
    std::vector<double> vdot(s.v.size()), tau(s.v.size()), first_vdot, first_tau, first_rows;
    for (const SimdWidth width : {SimdWidth::plain, SimdWidth::avx2, SimdWidth::avx512}) {
      if (!use_simd(width)) continue;
      ASSERT_TRUE(calc_forward_dynamics(*m, ws, s.q, s.v, s.tau, gravity, {}, vdot));
      calc_inverse_dynamics(*m, ws, s.q, s.v, s.tau, gravity, {}, tau);
      calc_inertia_rows(*m, ws, s.q);
      if (width == SimdWidth::plain) first_vdot = vdot, first_tau = tau, first_rows = ws.M;
      EXPECT_EQ(std::memcmp(vdot.data(), first_vdot.data(), vdot.size() * sizeof(double)), 0) << "seed " << seed;
      EXPECT_EQ(std::memcmp(ws.M.data(), first_rows.data(), ws.M.size() * sizeof(double)), 0) << "seed " << seed;
      EXPECT_EQ(std::memcmp(tau.data(), first_tau.data(), tau.size() * sizeof(double)), 0) << "seed " << seed;
    }
    use_simd(widest_simd());
  }
}

// The matrix has more entries than the kernel gathers before it writes them out (inertia_entries_at_once).
TEST(Kernels, InertiaMatrixOfManyLinksMatchesReference) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    RandomSource random(seed);
    const MechanismPtr m = Mechanism::make(testing::varied_spec(random, 90, seed % 2 == 0)).value();
    Workspace ws(*m);
    State s(*m);
    testing::randomize(random, *m, s);
    update_kinematics(*m, s.q, s.v, ws);
    calc_inertia_rows(*m, ws);
    const std::vector<double> reference = ws.M;
    ASSERT_GT(reference.size(), static_cast<std::size_t>(inertia_entries_at_once));
    calc_inertia_rows(*m, ws, s.q);
    expect_near(ws.M, reference, 1e-12, "inertia matrix");
  }
}

// A mechanism with two legs is singular if the tip of either leg has no moment of inertia about its joint.
TEST(Kernels, SingularTwinsAreReported) {
  for (const std::string side : {"none", "left", "right"}) {
    MechanismSpec spec;
    LinkSpec hip;
    hip.name = "hip";
    hip.joint.type = JointType::floating;
    hip.inertia = Inertia::from_centre(5, {}, {0.1, 0.1, 0.1, 0, 0, 0});
    spec.links.push_back(hip);
    for (const std::string leg : {"left", "right"})
      for (int i = 0; i < 3; ++i) {
        LinkSpec l;
        l.name = leg + std::to_string(i);
        l.parent = i == 0 ? "hip" : leg + std::to_string(i - 1);
        l.joint.type = JointType::revolute;
        l.joint.axis = {0, 1, 0};
        l.joint.X_PJ.p = {0, leg == "left" ? 0.1 : -0.1, -0.3};
        const bool point = i == 2 && leg == side;
        l.inertia = point ? Inertia::from_centre(1, {}, {}) : Inertia::from_centre(1, {0, 0, -0.1}, {0.01, 0.01, 0.01, 0, 0, 0});
        spec.links.push_back(l);
      }
    const MechanismPtr m = Mechanism::make(std::move(spec)).value();
    Workspace ws(*m);
    const State s(*m);
    EXPECT_EQ(ws.twins.pairs.size(), 1U);
    std::vector<double> vdot(s.v.size());
    EXPECT_EQ(calc_forward_dynamics(*m, ws, s.q, s.v, s.tau, gravity, {}, vdot), side == "none") << side;
  }
}

MechanismPtr make_chain(int links) {
  return testing::make_chain(links, [](int i, LinkSpec& l) {
    l.joint.type = JointType::revolute;
    l.joint.axis = {i % 3 == 0 ? 1.0 : 0.0, i % 3 == 1 ? 1.0 : 0.0, i % 3 == 2 ? 1.0 : 0.0};
    l.joint.X_PJ.p = {0, 0, 0.3};
    l.inertia = Inertia::from_centre(1, {0.01, 0, 0.15}, {0.01, 0.01, 0.002, 0, 0, 0});
  });
}

// The chain is 3 km long and nearly straight. Rounding errors of the torques are proportional to the maximum moment of the weight, so
// errors are compared with that moment.
TEST(Kernels, ChainOfTenThousandJointsKeepsItsAccuracy) {
  const MechanismPtr m = make_chain(10'000);
  Workspace ws(*m);
  State s(*m);
  RandomSource random(12);
  for (double& q : s.q) q = random.uniform(-0.02, 0.02);
  for (double& v : s.v) v = random.uniform(-1e-3, 1e-3);
  for (double& tau : s.tau) tau = random.uniform(-20, 20);
  std::vector<double> vdot(s.v.size()), tau(s.v.size()), load(s.v.size());
  calc_inverse_dynamics(*m, ws, s.q, s.v, {}, gravity, {}, load);
  double scale = 0, worst = 0;
  for (const double x : load) scale = std::max(scale, std::fabs(x));
  ASSERT_TRUE(calc_forward_dynamics(*m, ws, s.q, s.v, s.tau, gravity, {}, vdot));
  calc_inverse_dynamics(*m, ws, s.q, s.v, vdot, gravity, {}, tau);
  for (std::size_t i = 0; i < tau.size(); ++i) worst = std::max(worst, std::fabs(tau[i] - s.tau[i]));
  EXPECT_LT(worst, 1e-9 * scale) << "maximum load " << scale;
}

// In a falling chain held at one end, accelerations relative to free fall decay along the chain. With a torque on the last joint,
// accelerations decay towards the first joint. In both cases tiny values must become zero before they are subnormal.
TEST(Kernels, ChainOfTenThousandJointsMakesNoSubnormalNumbers) {
  const MechanismPtr m = make_chain(10'000);
  Workspace ws(*m);
  State s(*m);
  RandomSource random(13);
  for (double& q : s.q) q = random.uniform(-0.3, 0.3);
  std::vector<double> vdot(s.v.size());
  const auto expect_no_subnormals = [&](const char* label, const Vec3& acting_gravity) {
    ASSERT_TRUE(calc_forward_dynamics(*m, ws, s.q, s.v, s.tau, acting_gravity, {}, vdot));
    for (std::size_t i = 0; i < vdot.size(); ++i)
      ASSERT_TRUE(vdot[i] == 0 || std::fabs(vdot[i]) >= std::numeric_limits<double>::min()) << label << ", joint " << i << ": " << vdot[i];
  };
  expect_no_subnormals("held at one end", gravity);
  s.tau.back() = 1;
  expect_no_subnormals("torque on the last joint", Vec3{});
}

TEST(Kernels, AllocateNothing) {
  RandomSource random(3);
  const MechanismPtr m = Mechanism::make(testing::varied_spec(random, 20, true)).value();
  Workspace ws(*m);
  BatchWorkspace<double> doubles(*m, 20);
  BatchWorkspace<float> floats(*m, 20);
  State s(*m);
  testing::randomize(random, *m, s);
  std::vector<double> out(s.v.size());
  const long before = allocations_so_far();
  EXPECT_TRUE(calc_forward_dynamics(*m, ws, s.q, s.v, s.tau, gravity, s.external, out));
  calc_inverse_dynamics(*m, ws, s.q, s.v, s.tau, gravity, s.external, out);
  calc_inertia_rows(*m, ws, s.q);
  EXPECT_EQ(step_semi_implicit(doubles, gravity, 1e-3) + step_semi_implicit(floats, gravity, 1e-3), 0);
  calc_inverse_dynamics(doubles, gravity);
  calc_inverse_dynamics(floats, gravity);
  EXPECT_EQ(allocations_so_far(), before);
}

#ifdef UGOKI_NM
// Translation units compiled for wide registers must not define weak symbols. The linker could use such a function in other units,
// and on an older processor its instructions would be illegal.
TEST(Kernels, DefineNoWeakSymbols) {
  FILE* const pipe = popen(UGOKI_NM " " UGOKI_DYNAMICS_LIBRARY, "r");
  ASSERT_NE(pipe, nullptr);
  char line[4096];
  bool in_kernels = false;
  int symbols = 0;
  while (std::fgets(line, sizeof line, pipe) != nullptr) {
    const std::string text = line;
    if (text.find(".o:") != std::string::npos) in_kernels = text.find("kernels_") != std::string::npos;
    if (!in_kernels) continue;
    symbols += text.find(" t ") != std::string::npos ? 1 : 0;
    if (text.find("DW.ref.") != std::string::npos) continue;
    for (const char* const kind : {" W ", " V ", " u "}) EXPECT_EQ(text.find(kind), std::string::npos) << text;
  }
  EXPECT_EQ(pclose(pipe), 0);
  EXPECT_GT(symbols, 0);
}
#endif

}  // namespace
}  // namespace ugoki::dynamics
