#include "ugoki/dynamics/derivatives.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "allocation_count.h"
#include "random_mechanism.h"
#include "reference_dynamics.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::dynamics {
namespace {

using testing::RandomSource;
using Complex = std::complex<double>;
using Reference = testing::ReferenceDynamics<Complex>;

constexpr Vec3 gravity{0.3, -0.4, -9.81};
constexpr double step = 1e-30;  // complex steps have no cancellation, so the step can be tiny

std::vector<Complex> complex_of(std::span<const double> x) { return {x.begin(), x.end()}; }

struct Case {
  MechanismPtr m;
  State s;
  std::vector<double> vdot;

  Case(unsigned seed, int links, std::span<const JointType> only, bool floating) {
    RandomSource random(seed);
    m = Mechanism::make(random_spec(random, links, only, floating)).value();
    s = State(*m);
    randomize(random, *m, s);
    vdot.resize(s.v.size());
    for (double& x : vdot) x = random.uniform(-8, 8);
  }

  /// Derivative of tau with respect to one variable by complex steps, [n * n] row-major.
  /// @param variable 0: q, 1: v, 2: vdot @param pushed true: with external wrenches
  std::vector<double> reference(int variable, bool pushed) const {
    const std::size_t n = s.v.size();
    std::vector<double> out(n * n);
    for (std::size_t j = 0; j < n; ++j) {
      std::vector<Complex> dq(n), v = complex_of(s.v), a = complex_of(vdot);
      (variable == 0 ? dq : variable == 1 ? v : a)[j] += Complex(0, step);
      const std::vector<Complex> tau =
          Reference::inverse(*m, s.q, dq, v, a, gravity, pushed ? std::span<const Vec6>(s.external) : std::span<const Vec6>{});
      for (std::size_t i = 0; i < n; ++i) out[i * n + j] = tau[i].imag() / step;
    }
    return out;
  }
};

double maximum(std::span<const double> x) {
  double out = 0;
  for (const double v : x) out = std::max(out, std::fabs(v));
  return out;
}

double relative_error(std::span<const double> a, std::span<const double> b) {
  double out = 0;
  for (std::size_t i = 0; i < a.size(); ++i) out = std::max(out, std::fabs(a[i] - b[i]));
  return out / std::max(maximum(b), 1.0);
}

/// Maximum relative error of the derivatives of tau with respect to q and v, and of M, compared with the reference.
double inverse_error(const Case& c, bool pushed) {
  const std::size_t n = c.s.v.size();
  Workspace ws(*c.m);
  InverseDerivatives d(*c.m, ws);
  update_kinematics(*c.m, c.s.q, c.s.v, ws);
  calc_inverse_dynamics_derivatives(*c.m, ws, c.s.v, c.vdot, gravity,
                                    pushed ? std::span<const Vec6>(c.s.external) : std::span<const Vec6>{}, d);
  std::vector<double> dq(n * n), dv(n * n), M(n * n);
  expand(ws, d.below_q, d.above_q, dq);
  expand(ws, d.below_v, d.above_v, dv);
  expand(ws, ws.M, ws.M, M);
  return std::max(
      {relative_error(dq, c.reference(0, pushed)), relative_error(dv, c.reference(1, pushed)), relative_error(M, c.reference(2, pushed))});
}

// The reference does not use spatial vectors. Complex steps make its derivatives exact to rounding.
TEST(ReferenceDynamics, AgreesWithNewtonEuler) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const Case c(seed, 12, {}, seed % 2 == 0);
    Workspace ws(*c.m);
    update_kinematics(*c.m, c.s.q, c.s.v, ws);
    std::vector<double> tau(c.s.v.size()), other;
    calc_inverse_dynamics(*c.m, ws, c.vdot, gravity, c.s.external, tau);
    for (const Complex& x :
         Reference::inverse(*c.m, c.s.q, std::vector<Complex>(tau.size()), complex_of(c.s.v), complex_of(c.vdot), gravity, c.s.external))
      other.push_back(x.real());
    EXPECT_LT(relative_error(tau, other), 1e-12) << "seed " << seed;
  }
}

TEST(InverseDerivatives, EveryJointTypeAgreesWithComplexSteps) {
  for (int type = 0; type < 9; ++type) {
    const JointType only[] = {static_cast<JointType>(type)};
    for (const bool pushed : {false, true}) {
      const Case c(static_cast<unsigned>(type) + 1, 6, only, type % 2 == 0);
      EXPECT_LT(inverse_error(c, pushed), 1e-12) << name_of(only[0]) << (pushed ? " pushed" : "");
    }
  }
}

TEST(InverseDerivatives, RandomTreesAgreeWithComplexSteps) {
  double worst = 0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const Case c(seed, 14, {}, seed % 2 == 0);
    const double error = inverse_error(c, seed % 3 != 0);
    EXPECT_LT(error, 1e-12) << "seed " << seed;
    worst = std::max(worst, error);
  }
  RecordProperty("worst", std::to_string(worst));
}

TEST(InverseDerivatives, EmptyAccelerationMeansZero) {
  const Case c(5, 10, {}, true);
  Workspace ws(*c.m);
  InverseDerivatives a(*c.m, ws), b(*c.m, ws);
  update_kinematics(*c.m, c.s.q, c.s.v, ws);
  const std::vector<double> zero(c.s.v.size());
  calc_inverse_dynamics_derivatives(*c.m, ws, c.s.v, {}, gravity, c.s.external, a);
  calc_inverse_dynamics_derivatives(*c.m, ws, c.s.v, zero, gravity, c.s.external, b);
  EXPECT_EQ(a.below_q, b.below_q);
  EXPECT_EQ(a.above_q, b.above_q);
  EXPECT_EQ(a.above_v, b.above_v);
}

// The derivatives of vdot = M^-1 (tau - b) must satisfy the implicitly differentiated reference equations, M d vdot = -d tau.
TEST(ForwardDerivatives, SatisfyTheReferenceEquations) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Case c(seed, 12, {}, seed % 2 == 0);
    const std::size_t n = c.s.v.size();
    Workspace ws(*c.m);
    ForwardDerivatives d(*c.m, ws);
    update_kinematics(*c.m, c.s.q, c.s.v, ws);
    ASSERT_EQ(calc_forward_dynamics_derivatives(*c.m, ws, c.s.v, c.s.tau, gravity, c.s.external, d), -1);
    std::vector<double> vdot(n);
    ASSERT_TRUE(calc_forward_dynamics(*c.m, ws, c.s.tau, gravity, c.s.external, vdot));
    EXPECT_LT(relative_error(d.vdot, vdot), 1e-9);
    c.vdot = d.vdot;
    const std::vector<double> dtau_dq = c.reference(0, true), dtau_dv = c.reference(1, true), M = c.reference(2, true);
    const auto product = [&](std::span<const double> X) {
      std::vector<double> out(n * n);
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t k = 0; k < n; ++k)
          for (std::size_t j = 0; j < n; ++j) out[i * n + j] += M[i * n + k] * X[k * n + j];
      return out;
    };
    std::vector<double> minus_q = dtau_dq, minus_v = dtau_dv, unit(n * n);
    for (double& x : minus_q) x = -x;
    for (double& x : minus_v) x = -x;
    for (std::size_t i = 0; i < n; ++i) unit[i * n + i] = 1;
    EXPECT_LT(relative_error(product(d.dq), minus_q), 1e-10);
    EXPECT_LT(relative_error(product(d.dv), minus_v), 1e-10);
    EXPECT_LT(relative_error(product(d.dtau), unit), 1e-10);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) EXPECT_EQ(d.dtau[i * n + j], d.dtau[j * n + i]);
  }
}

TEST(ForwardDerivatives, AllocateNothing) {
  const Case c(3, 12, {}, true);
  Workspace ws(*c.m);
  ForwardDerivatives d(*c.m, ws);
  update_kinematics(*c.m, c.s.q, c.s.v, ws);
  const long before = allocations_so_far();
  EXPECT_EQ(calc_forward_dynamics_derivatives(*c.m, ws, c.s.v, c.s.tau, gravity, c.s.external, d), -1);
  EXPECT_EQ(allocations_so_far(), before);
}

TEST(ForwardDerivatives, ReportTheDofWithoutInertia) {
  MechanismSpec spec;
  spec.name = "spinner";
  for (int i = 0; i < 2; ++i) {
    LinkSpec l;
    l.name = i == 0 ? "base" : "rod";
    if (i > 0) l.parent = "base";
    l.joint.type = JointType::revolute;
    l.inertia = i == 0 ? Inertia::from_centre(1, {1, 0, 0}, {}) : Inertia{1.0, {}, {}};  // a point mass on the joint's axis
    spec.links.push_back(l);
  }
  const MechanismPtr m = Mechanism::make(std::move(spec)).value();
  Workspace ws(*m);
  State s(*m);
  ForwardDerivatives d(*m, ws);
  update_kinematics(*m, s.q, s.v, ws);
  EXPECT_EQ(calc_forward_dynamics_derivatives(*m, ws, s.v, s.tau, gravity, {}, d), 1);
}

}  // namespace
}  // namespace ugoki::dynamics
