#include "ugoki/dynamics/centroidal.h"

#include <gtest/gtest.h>

#include <cmath>

#include "random_mechanism.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::dynamics {
namespace {

using testing::RandomSource;
using testing::without_armature;

constexpr Vec3 gravity{0.5, -1, -9.81};

struct Scene {
  MechanismPtr m;
  State s;
  Workspace ws;

  explicit Scene(unsigned seed) : Scene(seed, RandomSource(seed)) {}
  Scene(unsigned seed, RandomSource random)
      : m(Mechanism::make(without_armature(random_spec(random, 15, {}, seed % 2 == 0))).value()), s(*m), ws(*m) {
    randomize(random, *m, s);
    update_kinematics(*m, s.q, s.v, ws);
  }
};

double size(const Vec6& x) { return norm(x.w) + norm(x.v); }

TEST(Centroidal, EqualsSumOverLinks) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Scene c(seed);
    const Centroidal g = calc_centroidal(*c.m, c.ws);
    // Sum over the links: position, velocity and angular momentum of each link's centre of mass, from calc_velocities()
    std::vector<Pose> X(c.ws.X_WB.size());
    std::vector<Vec6> V(X.size());
    calc_poses(*c.m, c.s.q, X);
    calc_velocities(*c.m, c.s.q, c.s.v, V);
    double mass = 0;
    Vec3 first, linear;
    for (std::size_t i = 0; i < X.size(); ++i) {
      const Inertia& I = c.m->links()[i].inertia;
      mass += I.mass;
      first += (X[i] * I.centre()) * I.mass;
      linear += X[i].R * (V[i].v + cross(V[i].w, I.centre())) * I.mass;
    }
    const Vec3 centre = first / mass;
    Vec3 angular, about_z;
    for (std::size_t i = 0; i < X.size(); ++i) {
      const Inertia& I = c.m->links()[i].inertia;
      const Vec3 r = X[i] * I.centre() - centre;
      angular += X[i].R * (I.about_centre() * V[i].w) + cross(r, X[i].R * (V[i].v + cross(V[i].w, I.centre())) * I.mass);
      about_z += X[i].R * (I.about_centre() * transpose_times(X[i].R, Vec3{0, 0, 1})) + cross(r, cross({0, 0, 1}, r)) * I.mass;
    }
    EXPECT_NEAR(g.mass, mass, 1e-12 * mass);
    EXPECT_LT(norm(g.centre - centre), 1e-12) << "seed " << seed;
    EXPECT_LT(norm(g.velocity - linear / mass), 1e-12 * (1 + norm(g.velocity)));
    EXPECT_LT(norm(g.momentum.v - linear), 1e-12 * norm(linear));
    EXPECT_LT(norm(g.momentum.w - angular), 1e-11 * (1 + norm(angular))) << "seed " << seed;
    EXPECT_LT(norm(g.inertia * Vec3{0, 0, 1} - about_z), 1e-11 * norm(about_z));
    EXPECT_LT(norm(g.centre - centre_of_mass(*c.m, X)), 1e-12);
  }
}

TEST(CentroidalMatrix, TimesVelocityIsMomentumAndRateMatchesExternalForces) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Scene c(seed);
    const std::size_t n = c.s.v.size();
    std::vector<Vec6> A_G(n);
    calc_centroidal_matrix(*c.m, c.ws, A_G);
    Vec6 h;
    for (std::size_t f = 0; f < n; ++f) h += A_G[f] * c.s.v[f];
    const Centroidal g = calc_centroidal(*c.m, c.ws);
    EXPECT_LT(size(h - g.momentum), 1e-12 * (1 + size(h))) << "seed " << seed;

    // The momentum about the centre of mass is changed by gravity and external wrenches, not by joint forces
    std::vector<double> vdot(n);
    ASSERT_TRUE(calc_forward_dynamics(*c.m, c.ws, c.s.tau, gravity, c.s.external, vdot));
    const Vec6 bias = calc_centroidal_momentum_rate(*c.m, c.ws, {});
    Vec6 rate = bias;
    for (std::size_t f = 0; f < n; ++f) rate += A_G[f] * vdot[f];
    EXPECT_LT(size(rate - calc_centroidal_momentum_rate(*c.m, c.ws, vdot)), 1e-10 * (1 + size(rate)));

    const auto momentum_at = [&](double t) {
      std::vector<double> q(c.s.q.size()), v(n), mean(n);
      for (std::size_t i = 0; i < n; ++i) {
        v[i] = c.s.v[i] + t * vdot[i];
        mean[i] = c.s.v[i] + 0.5 * t * vdot[i];
      }
      integrate(*c.m, c.s.q, mean, t, q);
      Workspace ws(*c.m);
      update_kinematics(*c.m, q, v, ws);
      return calc_centroidal(*c.m, ws).momentum;
    };
    const auto slope = [&](double k) { return (momentum_at(k) - momentum_at(-k)) * (0.5 / k); };
    const Vec6 measured = slope(5e-5) * (4.0 / 3) - slope(1e-4) * (1.0 / 3);
    EXPECT_LT(size(rate - measured), 1e-6 * (1 + size(rate))) << "seed " << seed;
    if (seed % 2 == 1) continue;  // odd seeds have a fixed base, on which the world exerts forces
    for (std::size_t i = 0; i < 6; ++i) c.s.tau[i] = 0;
    ASSERT_TRUE(calc_forward_dynamics(*c.m, c.ws, c.s.tau, gravity, c.s.external, vdot));
    Vec6 expected{{}, gravity * g.mass};
    for (const Vec6& e : c.s.external) expected += Vec6{e.w - cross(g.centre, e.v), e.v};
    EXPECT_LT(size(calc_centroidal_momentum_rate(*c.m, c.ws, vdot) - expected), 1e-9 * (1 + size(expected))) << "seed " << seed;
  }
}

TEST(PotentialGradient, EqualsStaticJointForcesAndEnergyDerivative) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Scene c(seed);
    const std::size_t n = c.s.v.size();
    for (double& x : c.s.v) x = 0;
    update_kinematics(*c.m, c.s.q, c.s.v, c.ws);
    std::vector<double> gradient(n), tau(n), q(c.s.q.size()), unit(n);
    calc_potential_gradient(*c.m, c.ws, gravity, gradient);
    calc_inverse_dynamics(*c.m, c.ws, {}, gravity, {}, tau);
    for (std::size_t f = 0; f < n; ++f) {
      EXPECT_NEAR(gradient[f], tau[f], 1e-11 * (1 + std::fabs(tau[f]))) << "seed " << seed;
      const auto energy = [&](double h) {
        unit[f] = 1;
        integrate(*c.m, c.s.q, unit, h, q);
        unit[f] = 0;
        update_kinematics(*c.m, q, c.s.v, c.ws);
        return potential_energy(*c.m, c.ws, gravity);
      };
      EXPECT_NEAR((energy(1e-5) - energy(-1e-5)) / 2e-5, gradient[f], 1e-5 * (1 + std::fabs(gradient[f]))) << "seed " << seed;
    }
  }
}

}  // namespace
}  // namespace ugoki::dynamics
