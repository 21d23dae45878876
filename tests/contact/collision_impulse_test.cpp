// The collision impulse, equations (6)-(19) of the paper (collision_impulse.h), compared with closed forms and with the paper's matrices;
// conservation laws on random mechanisms.

#include "ugoki/contact/collision_impulse.h"

#include <gtest/gtest.h>

#include <cmath>

#include "party.h"
#include "ugoki/dynamics/dense.h"

namespace ugoki::contact {
namespace {

MechanismPtr pendulum(double length, double mass, double radius) {
  MechanismSpec spec;
  spec.name = "pendulum";
  LinkSpec l;
  l.name = "ball";
  l.joint.type = JointType::revolute;
  l.joint.axis = {0, -1, 0};
  const double I = 0.4 * mass * radius * radius;
  l.inertia = Inertia::from_centre(mass, {0, 0, -length}, {I, I, I, 0, 0, 0});
  Shape ball = Shape::sphere(radius, {Mat3::identity(), {0, 0, -length}});
  ball.restitution = 1;
  ball.friction = 0;
  l.shapes.push_back(ball);
  spec.links.push_back(l);
  return Mechanism::make(std::move(spec)).value();
}

TEST(CollisionImpulse, TwoBallsMatchClosedForm) {
  for (const double e : {1.0, 0.6, 0.0}) {
    Party party;
    const MechanismPtr a = body("a", Shape::sphere(0.1), 1000), b = body("b", Shape::sphere(0.2), 700);
    party.add(a, State(*a));
    party.add(b, State(*b));
    party.states[1].q[0] = 0.3;
    party.states[0].v[3] = 3;
    party.states[0].v[4] = 0.5;
    party.states[1].v[3] = -1;
    const double m1 = a->mass(), m2 = b->mass();
    const ContactPoint c = between(0, 0, 1, 0, {0.1, 0, 0}, {-1, 0, 0}, e);
    EXPECT_EQ(party.collide({&c, 1}).status, ImpactStatus::ok);
    const double p = (1 + e) * 4 * m1 * m2 / (m1 + m2);
    EXPECT_NEAR(party.impulse.impulses()[0], p, 1e-12 * p);
    EXPECT_NEAR(party.states[0].v[3], 3 - p / m1, 1e-12);
    EXPECT_NEAR(party.states[1].v[3], -1 + p / m2, 1e-12);
    EXPECT_EQ(party.states[0].v[4], 0.5);
  }
}

TEST(CollisionImpulse, BallAgainstPendulumMatchesClosedForm) {
  Party party;
  const double l = 0.8, m = 2, r = 0.1;
  const MechanismPtr bob = pendulum(l, m, r), ball = body("ball", Shape::sphere(r), 900);
  party.add(bob, State(*bob));
  party.add(ball, State(*ball));
  party.states[1].q[0] = -2 * r;
  party.states[1].q[2] = -l;
  party.states[1].v[3] = 2;
  const ContactPoint c = between(0, 0, 1, 0, {-r, 0, -l}, {1, 0, 0}, 1);
  party.collide({&c, 1});
  const double inertia = m * l * l + 0.4 * m * r * r;
  const double p = 2 * 2 / (1 / ball->mass() + l * l / inertia);
  EXPECT_NEAR(party.states[0].v[0], p * l / inertia, 1e-12);
  EXPECT_NEAR(party.states[1].v[3], 2 - p / ball->mass(), 1e-12);
}

/// If k balls arrive from the left, k balls leave on the right.
TEST(CollisionImpulse, NewtonsCradleOfFiveBalls) {
  for (int k = 1; k <= 4; ++k) {
    Party party;
    std::vector<ContactPoint> contacts;
    for (int i = 0; i < 5; ++i) {
      const MechanismPtr ball = body("ball", Shape::sphere(0.1), 1000);
      party.add(ball, State(*ball));
      party.states.back().q[0] = 0.2 * i;
      party.states.back().v[3] = i < k ? 1.5 : 0;
      if (i > 0) contacts.push_back(between(i, 0, i - 1, 0, {0.2 * i - 0.1, 0, 0}, {1, 0, 0}, 1));
    }
    const double energy = party.energy();
    const ImpactReport report = party.collide(contacts);
    EXPECT_EQ(report.status, ImpactStatus::ok);
    EXPECT_LT(report.approach, 1e-12);
    for (int i = 0; i < 5; ++i) EXPECT_NEAR(party.states[static_cast<std::size_t>(i)].v[3], i < 5 - k ? 0 : 1.5, 1e-12) << k << " " << i;
    EXPECT_NEAR(party.energy(), energy, 1e-12 * energy);
  }
}

/// Balls of equal mass in a row, with several pairs approaching. Each sequential collision exchanges two velocities, so that in the end the
/// velocities are sorted. Simultaneous collisions would produce velocities that no ball had before.
TEST(CollisionImpulse, TouchingBallsOfEqualMassSortTheirVelocities) {
  RandomSource random(3);
  const MechanismPtr ball = body("ball", Shape::sphere(0.1), 1000);
  for (int round = 0; round < 50; ++round) {
    Party party;
    std::vector<ContactPoint> contacts;
    std::vector<double> speeds;
    for (int i = 0; i < 5; ++i) {
      party.add(ball, State(*ball));
      speeds.push_back(round == 0 ? 3 - i : random.uniform(-2, 2));
      party.states.back().q[0] = 0.2 * i;
      party.states.back().v[3] = speeds.back();
      if (i > 0) contacts.push_back(between(i, 0, i - 1, 0, {0.2 * i - 0.1, 0, 0}, {1, 0, 0}, 1));
    }
    EXPECT_EQ(party.collide(contacts).status, ImpactStatus::ok);
    std::ranges::sort(speeds);
    for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(party.states[i].v[3], speeds[i], 1e-12) << "round " << round << " ball " << i;
  }
}

TEST(CollisionImpulse, BoxLandingFlatReboundsWithoutRotation) {
  Party party;
  const MechanismPtr box = body("box", Shape::box({0.2, 0.1, 0.05}), 500);
  party.add(box, State(*box));
  party.states[0].q[2] = 0.05;
  party.states[0].v[5] = -2;
  std::vector<ContactPoint> corners;
  for (const double x : {-0.2, 0.2})
    for (const double y : {-0.1, 0.1}) corners.push_back(between(0, 0, -1, -1, {x, y, 0}, {0, 0, 1}, 0.5));
  party.collide(corners);
  EXPECT_NEAR(party.states[0].v[5], 1, 1e-12);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(party.states[0].v[static_cast<std::size_t>(k)], 0, 1e-12);
}

TEST(CollisionImpulse, ElasticCollisionsOfRandomMechanismsConserveEnergyAndMomentum) {
  RandomSource random(7);
  for (unsigned seed = 0; seed < 60; ++seed) {
    for (int kind = 0; kind < 3; ++kind) {  // open, mixed, closed systems
      RandomParty party(random, seed, kind, 1, false, 1 + random.below(6));
      const double energy = party.energy();
      const Vec6 momentum = party.momentum();
      std::vector<double> before;
      for (const ContactPoint& c : party.contacts) before.push_back(party.approach(c));
      const ImpactReport report = party.collide(party.contacts, {0, 0, false});
      ASSERT_EQ(report.status, ImpactStatus::ok) << "seed " << seed << " kind " << kind;
      EXPECT_NEAR(party.energy(), energy, 1e-12 * energy) << "seed " << seed << " kind " << kind;
      const bool free = std::ranges::none_of(party.loops, [](const auto& l) {  // no loop is attached to the world
        return l && std::ranges::any_of(l->loops(), [](const Loop& x) { return x.link_a < 0 || x.link_b < 0; });
      });
      const Vec6 change = party.momentum() - momentum;
      const double size = 1 + norm(momentum.v) + norm(momentum.w) + energy;
      if (free) EXPECT_LT(norm(change.v) + norm(change.w), 1e-12 * size) << "seed " << seed << " kind " << kind;
      double fastest = 0;
      for (const double u : before) fastest = std::max(fastest, u);
      for (const ContactPoint& c : party.contacts) EXPECT_LT(party.approach(c), 1e-10 * (1 + fastest)) << "seed " << seed;
      if (party.contacts.size() == 1 && before[0] > 0) EXPECT_NEAR(party.approach(party.contacts[0]), -before[0], 1e-10 * (1 + before[0]));
    }
  }
}

TEST(CollisionImpulse, PlasticCollisionsEndWithoutApproach) {
  RandomSource random(11);
  for (unsigned seed = 0; seed < 400; ++seed) {
    for (int kind = 0; kind < 3; ++kind) {
      RandomParty party(random, seed, kind, 0, true, 1 + random.below(8));
      const double energy = party.energy();
      ASSERT_EQ(party.collide(party.contacts).status, ImpactStatus::ok) << "seed " << seed << " kind " << kind;
      EXPECT_LE(party.energy(), energy * (1 + 1e-12));
      for (const ContactPoint& c : party.contacts)
        EXPECT_LT(party.approach(c), 1e-12 * (1 + std::sqrt(energy))) << "seed " << seed << " kind " << kind;
    }
  }
}

/// Compares with the paper's matrices M_G = H^T M H and J H, calculated as dense matrices. The columns of H are a basis of the velocities
/// that the loops allow.
TEST(CollisionImpulse, ClosedSystemsMatchGeneralizedInertia) {
  RandomSource random(5);
  int compared = 0;
  for (unsigned seed = 1; seed < 30; ++seed) {
    RandomParty party(random, seed, 1, 0.7, false, 1, true);
    ContactPoint& c = party.contacts[0];
    if (party.approach(c) < 0) c.n = -c.n;
    double open = 0;  // maximum |J v| of the loops, m/s | rad/s; cases with nearly dependent rows are skipped
    for (std::size_t i = 0; i < party.loops[0]->loops().size(); ++i) {
      dynamics::LoopRows rows(party.loops[0]->loops());
      dynamics::update_loop_rows(*party.mechanisms[0], *party.workspaces[0], party.loops[0]->loops(), party.states[0].q, party.states[0].v,
                                 rows);
      std::vector<double> J(party.states[0].v.size());
      for (int r = rows.first[i]; r < rows.first[i + 1]; ++r) {
        dynamics::calc_loop_jacobian_row(*party.mechanisms[0], *party.workspaces[0], party.loops[0]->loops()[i], rows, static_cast<int>(i),
                                         r, J);
        double rate = 0;
        for (std::size_t k = 0; k < J.size(); ++k) rate += J[k] * party.states[0].v[k];
        open = std::max(open, std::fabs(rate));
      }
    }
    if (open > 1e-9) continue;
    ++compared;
    const double u = -party.approach(c);
    // The velocity change dv of the closed system has the minimum kinetic energy subject to J_loops dv = 0. It is computed here with a
    // dense basis H of the changes that the loops allow.
    double inverse_mass = 0;
    std::vector<std::vector<double>> response(2);
    for (std::size_t s = 0; s < 2; ++s) {
      const Mechanism& m = *party.mechanisms[s];
      const auto n = static_cast<std::size_t>(m.nv());
      dynamics::Workspace& ws = *party.workspaces[s];
      std::vector<double> M(n * n), Jr(n, 0.0);
      if (party.loops[s]) dynamics::share_virtual_inertias(*party.loops[s], ws);
      dynamics::calc_inertia_matrix(m, ws, M);
      const int link = s == 0 ? c.link_a : c.link_b;
      const std::span<const int> chain = dynamics::chain_of_link(ws, link);
      std::vector<Vec3> rows(chain.size());
      dynamics::calc_point_jacobian(ws, link, c.p, rows);
      for (std::size_t k = 0; k < chain.size(); ++k) Jr[static_cast<std::size_t>(chain[k])] = dot(rows[k], c.n) * (s == 0 ? 1 : -1);
      std::vector<std::vector<double>> constraints;
      if (party.loops[s]) {
        dynamics::LoopRows loop_rows(party.loops[s]->loops());
        dynamics::update_loop_rows(m, ws, party.loops[s]->loops(), party.states[s].q, party.states[s].v, loop_rows);
        for (std::size_t i = 0; i < party.loops[s]->loops().size(); ++i)
          for (int r = loop_rows.first[i]; r < loop_rows.first[i + 1]; ++r) {
            std::vector<double> J(n);
            dynamics::calc_loop_jacobian_row(m, ws, party.loops[s]->loops()[i], loop_rows, static_cast<int>(i), r, J);
            constraints.push_back(J);
          }
      }
      // Basis H of the null space of the constraints by Gram-Schmidt, then x = H (H^T M H)^-1 H^T Jr
      std::vector<std::vector<double>> normal, H;
      const auto orthonormal = [n](std::vector<double> x, const auto&... sets) -> std::vector<double> {
        double size = 0;
        for (const double e : x) size += e * e;
        for (int again = 0; again < 2; ++again)
          (..., [&] {
            for (const auto& y : sets) {
              double part = 0;
              for (std::size_t k = 0; k < n; ++k) part += x[k] * y[k];
              for (std::size_t k = 0; k < n; ++k) x[k] -= part * y[k];
            }
          }());
        double left = 0;
        for (const double e : x) left += e * e;
        if (left < 1e-14 * (1 + size)) return {};
        for (double& e : x) e /= std::sqrt(left);
        return x;
      };
      for (const auto& row : constraints)
        if (auto x = orthonormal(row, normal); !x.empty()) normal.push_back(x);
      for (std::size_t k = 0; k < n; ++k) {
        std::vector<double> unit(n, 0.0);
        unit[k] = 1;
        if (auto x = orthonormal(unit, normal, H); !x.empty() && H.size() + normal.size() < n) H.push_back(x);
      }
      const std::size_t g = H.size();
      std::vector<double> MG(g * g), b(g);
      for (std::size_t i = 0; i < g; ++i) {
        for (std::size_t k = 0; k < n; ++k) b[i] += H[i][k] * Jr[k];
        for (std::size_t j = 0; j < g; ++j)
          for (std::size_t k = 0; k < n; ++k)
            for (std::size_t l = 0; l < n; ++l) MG[i * g + j] += H[i][k] * M[k * n + l] * H[j][l];
      }
      std::vector<double> x = b;
      ASSERT_TRUE(dynamics::factor_cholesky(MG, static_cast<int>(g), 1e-14)) << "seed " << seed;
      dynamics::solve_cholesky(MG, static_cast<int>(g), x);
      response[s].assign(n, 0.0);
      for (std::size_t i = 0; i < g; ++i) {
        inverse_mass += b[i] * x[i];
        for (std::size_t k = 0; k < n; ++k) response[s][k] += H[i][k] * x[i];
      }
    }
    const double p = -1.7 * u / inverse_mass;
    std::vector<std::vector<double>> expected(2);
    for (std::size_t s = 0; s < 2; ++s) {
      expected[s] = party.states[s].v;
      for (std::size_t k = 0; k < expected[s].size(); ++k) expected[s][k] += response[s][k] * p;
    }
    party.collide(party.contacts);
    for (std::size_t s = 0; s < 2; ++s)
      for (std::size_t k = 0; k < expected[s].size(); ++k)
        EXPECT_NEAR(party.states[s].v[k], expected[s][k], 1e-8 * (1 + std::fabs(expected[s][k])))
            << "seed " << seed << " " << s << " " << k;
  }
  EXPECT_GE(compared, 20);
}

/// Five adjacent pendulums in the stepper: the first and the last swing alternately.
TEST(CollisionImpulse, CradleSwingsInTheStepper) {
  std::vector<MechanismPtr> balls;
  for (int i = 0; i < 5; ++i) {
    MechanismSpec spec = pendulum(1, 1, 0.1)->spec();
    spec.links[0].joint.X_PJ.p = {0.2 * i, 0, 2};
    balls.push_back(Mechanism::make(std::move(spec)).value());
  }
  World w(balls, {}, {});
  w.states[0].q[0] = -0.5;
  const auto energy = [&] {
    double sum = 0;
    for (const State& s : w.states) sum += 0.5 * 1.004 * s.v[0] * s.v[0] + 9.81 * (1 - std::cos(s.q[0]));
    return sum;
  };
  const double before = energy();
  double last = 0, middle = 0, first_again = 0;
  for (int i = 0; i < 2000; ++i) {
    ASSERT_EQ(w.step(0.001).status, StepStatus::ok);
    last = std::max(last, w.states[4].q[0]);
    for (std::size_t k = 1; k < 4; ++k) middle = std::max(middle, std::fabs(w.states[k].q[0]));
    if (i > 1200) first_again = std::min(first_again, w.states[0].q[0]);
  }
  EXPECT_NEAR(last, 0.5, 0.01);
  EXPECT_LT(middle, 0.02);
  EXPECT_NEAR(first_again, -0.5, 0.02);
  EXPECT_NEAR(energy(), before, 0.02 * before);
}

}  // namespace
}  // namespace ugoki::contact
