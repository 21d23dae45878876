#include "ugoki/dynamics/dynamics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "random_mechanism.h"

namespace ugoki::dynamics {
namespace {

using testing::RandomSource;
using testing::without_armature;

constexpr Vec3 gravity{0, 0, -9.81};

double maximum(std::span<const double> x) {
  double out = 0;
  for (const double v : x) out = std::max(out, std::fabs(v));
  return out;
}

void expect_near(std::span<const double> a, std::span<const double> b, double relative, const char* label) {
  const double scale = std::max({maximum(a), maximum(b), 1.0});
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], relative * scale) << label << ", degree of freedom " << i;
}

// Forward dynamics by articulated bodies, by the factor of M and by the paper's unit vectors must agree. The tolerance of 1e-9 allows
// for the condition number of M (up to 1e5 here).
TEST(ForwardDynamics, ThreeMethodsAgree) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    RandomSource random(seed);
    const MechanismPtr m = Mechanism::make(random_spec(random, 1 + random.below(25), {}, seed % 2 == 0)).value();
    Workspace ws(*m);
    State s(*m);
    randomize(random, *m, s);
    update_kinematics(*m, s.q, s.v, ws);
    std::vector<double> by_bodies(s.v.size()), by_factor(s.v.size()), by_units(s.v.size());
    ASSERT_TRUE(calc_forward_dynamics(*m, ws, s.tau, gravity, s.external, by_bodies));
    ASSERT_TRUE(calc_forward_dynamics_by_factor(*m, ws, s.tau, gravity, s.external, by_factor));
    ASSERT_TRUE(calc_forward_dynamics_by_unit_vectors(*m, ws, s.tau, gravity, s.external, by_units));
    expect_near(by_bodies, by_units, 1e-9, "articulated bodies against unit vectors");
    expect_near(by_factor, by_units, 1e-9, "factor against unit vectors");
    std::vector<double> tau(s.v.size());
    calc_inverse_dynamics(*m, ws, by_bodies, gravity, s.external, tau);
    expect_near(tau, s.tau, 1e-9, "inverse of forward");
  }
}

TEST(InertiaMatrix, IsTheHessianOfKineticEnergy) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    RandomSource random(seed);
    const MechanismPtr m = Mechanism::make(without_armature(random_spec(random, 12))).value();
    Workspace ws(*m);
    State s(*m);
    randomize(random, *m, s);
    update_kinematics(*m, s.q, s.v, ws);
    const auto n = static_cast<std::size_t>(m->nv());
    std::vector<double> M(n * n);
    calc_inertia_matrix(*m, ws, M);
    double energy = 0;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) energy += 0.5 * s.v[i] * M[i * n + j] * s.v[j];
    EXPECT_NEAR(kinetic_energy(*m, ws), energy, 1e-12 * energy) << "seed " << seed;
  }
}

// The rate of kinetic plus potential energy must equal the power of the joint forces. This checks b(q, v), including the velocity
// products of every joint type.
TEST(ForwardDynamics, EnergyRateEqualsJointPowerForEveryJointType) {
  for (int type = 1; type < 9; ++type) {
    const JointType only[] = {static_cast<JointType>(type)};
    RandomSource random(static_cast<unsigned>(type));
    const MechanismPtr m = Mechanism::make(without_armature(random_spec(random, 6, only))).value();
    Workspace ws(*m);
    State s(*m);
    randomize(random, *m, s);
    std::vector<double> vdot(s.v.size());
    update_kinematics(*m, s.q, s.v, ws);
    ASSERT_TRUE(calc_forward_dynamics(*m, ws, s.tau, gravity, {}, vdot));
    double power = 0;
    for (std::size_t i = 0; i < s.v.size(); ++i) power += s.tau[i] * s.v[i];
    const double h = 1e-5;
    const auto energy_at = [&](double t) {
      std::vector<double> q(s.q.size()), v(s.v.size()), mean(s.v.size());
      for (std::size_t i = 0; i < v.size(); ++i) {
        v[i] = s.v[i] + t * vdot[i];
        mean[i] = s.v[i] + 0.5 * t * vdot[i];
      }
      integrate(*m, s.q, mean, t, q);
      update_kinematics(*m, q, v, ws);
      return kinetic_energy(*m, ws) + potential_energy(*m, ws, gravity);
    };
    const double rate = (energy_at(h) - energy_at(-h)) / (2 * h);
    EXPECT_NEAR(rate, power, 1e-6 * std::max(1.0, std::fabs(power)) * 100) << name_of(static_cast<JointType>(type));
  }
}

TEST(Momentum, RateEqualsExternalWrench) {
  RandomSource random(7);
  const MechanismPtr m = Mechanism::make(without_armature(random_spec(random, 15))).value();
  Workspace ws(*m);
  State s(*m);
  randomize(random, *m, s);
  std::vector<double> vdot(s.v.size());
  update_kinematics(*m, s.q, s.v, ws);
  for (int i = 0; i < 6; ++i) s.tau[static_cast<std::size_t>(i)] = 0;  // the floating base is not driven
  ASSERT_TRUE(calc_forward_dynamics(*m, ws, s.tau, {}, s.external, vdot));
  Vec6 expected;
  for (const Vec6& f : s.external) expected += f;
  const double h = 1e-5;
  const auto momentum_at = [&](double t) {
    std::vector<double> q(s.q.size()), v(s.v.size()), mean(s.v.size());
    for (std::size_t i = 0; i < v.size(); ++i) {
      v[i] = s.v[i] + t * vdot[i];
      mean[i] = s.v[i] + 0.5 * t * vdot[i];
    }
    integrate(*m, s.q, mean, t, q);
    update_kinematics(*m, q, v, ws);
    return momentum(*m, ws);
  };
  const Vec6 rate = (momentum_at(h) - momentum_at(-h)) * (0.5 / h);
  EXPECT_LT(norm(rate.v - expected.v), 1e-5 * norm(expected.v) + 1e-4);
  EXPECT_LT(norm(rate.w - expected.w), 1e-5 * norm(expected.w) + 1e-3);
}

TEST(Kinematics, SingleLinksHaveTheBitsOfAllLinks) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    RandomSource random(seed);
    const MechanismPtr m = Mechanism::make(random_spec(random, 1 + random.below(20), {}, seed % 2 == 0)).value();
    Workspace all(*m), some(*m);
    State s(*m), other(*m);
    randomize(random, *m, s);
    randomize(random, *m, other);
    update_kinematics(*m, s.q, s.v, all);
    update_kinematics(*m, other.q, other.v, some);  // old values, which must not be used
    std::vector<char> known(static_cast<std::size_t>(m->link_count()));
    for (int count = 0; count < 3; ++count) {
      const int link = random.below(m->link_count());
      update_path_kinematics(*m, s.q, s.v, link, known, some);
      for (int i = link; i >= 0; i = m->link(i).parent) {
        const auto at = static_cast<std::size_t>(i);
        EXPECT_EQ(known[at], 1);
        EXPECT_EQ(some.X_WB[at].p, all.X_WB[at].p);
        EXPECT_EQ(some.V[at].w, all.V[at].w);
        EXPECT_EQ(some.V[at].v, all.V[at].v);
      }
    }
    EXPECT_EQ(some.p0, all.p0);
  }
}

TEST(PointJacobian, IsTheDerivativeOfThePosition) {
  RandomSource random(3);
  const MechanismPtr m = Mechanism::make(random_spec(random, 12)).value();
  Workspace ws(*m);
  State s(*m);
  randomize(random, *m, s);
  update_kinematics(*m, s.q, s.v, ws);
  const int link = m->link_count() - 1;
  const Vec3 local{0.1, -0.2, 0.3};
  const Vec3 p = ws.X_WB[static_cast<std::size_t>(link)] * local;
  const std::span<const int> chain = chain_of_link(ws, link);
  std::vector<Vec3> rows(chain.size());
  calc_point_jacobian(ws, link, p, rows);
  Vec3 velocity;
  for (std::size_t k = 0; k < chain.size(); ++k) velocity += rows[k] * s.v[static_cast<std::size_t>(chain[k])];
  EXPECT_LT(norm(velocity - point_velocity(ws, link, p)), 1e-12);
  const double h = 1e-6;
  const auto position_at = [&](double t) {
    std::vector<double> q(s.q.size());
    std::vector<Pose> X(static_cast<std::size_t>(m->link_count()));
    integrate(*m, s.q, s.v, t, q);
    calc_poses(*m, q, X);
    return X[static_cast<std::size_t>(link)] * local;
  };
  EXPECT_LT(norm((position_at(h) - position_at(-h)) * (0.5 / h) - velocity), 1e-7);
}

TEST(Factor, SolvesAndTransposedFactorGivesTheDelassusMatrix) {
  RandomSource random(11);
  const MechanismPtr m = Mechanism::make(random_spec(random, 14)).value();
  Workspace ws(*m);
  State s(*m);
  randomize(random, *m, s);
  update_kinematics(*m, s.q, s.v, ws);
  const auto n = static_cast<std::size_t>(m->nv());
  std::vector<double> M(n * n);
  calc_inertia_matrix(*m, ws, M);
  ASSERT_EQ(factor(ws, {}), -1);
  std::vector<double> x(n), back(n);
  for (double& v : x) v = random.uniform(-1, 1);
  back = x;
  solve(ws, back);
  for (std::size_t i = 0; i < n; ++i) {
    double sum = 0;
    for (std::size_t j = 0; j < n; ++j) sum += M[i * n + j] * back[j];
    EXPECT_NEAR(sum, x[i], 1e-9);
  }
  const int link = m->link_count() - 1;
  const std::span<const int> chain = chain_of_link(ws, link);
  std::vector<Vec3> rows(chain.size());
  calc_point_jacobian(ws, link, {0.5, 0.2, 0.1}, rows);
  std::vector<double> full(n), y(chain.size());
  for (std::size_t k = 0; k < chain.size(); ++k) full[static_cast<std::size_t>(chain[k])] = y[k] = rows[k].z;
  const std::vector<double> j = full;
  solve(ws, full);
  double direct = 0, through = 0;
  for (std::size_t i = 0; i < n; ++i) direct += j[i] * full[i];
  apply_inverse_transposed_factor(ws, ws.link_chain[static_cast<std::size_t>(link)], y);
  for (std::size_t k = 0; k < y.size(); ++k) through += y[k] * y[k] * ws.D_inverse[static_cast<std::size_t>(chain[k])];
  EXPECT_NEAR(direct, through, 1e-10 * std::fabs(direct));
}

TEST(ForwardDynamics, SingularInertiaIsReported) {
  MechanismSpec spec;
  spec.name = "spinner";
  LinkSpec l;
  l.name = "rod";
  l.joint.type = JointType::revolute;
  l.inertia = Inertia{1.0, {}, {}};  // a point mass on the axis: no inertia about it
  spec.links.push_back(l);
  const MechanismPtr m = Mechanism::make(std::move(spec)).value();
  Workspace ws(*m);
  State s(*m);
  update_kinematics(*m, s.q, s.v, ws);
  std::vector<double> vdot(1);
  EXPECT_FALSE(calc_forward_dynamics(*m, ws, s.tau, gravity, {}, vdot));
  calc_inertia_rows(*m, ws);
  EXPECT_EQ(factor(ws, {}), 0);
}

}  // namespace
}  // namespace ugoki::dynamics
