// The paper's method for closed link systems, compared with maximal coordinates, published values, closed forms and invariants.

#include "ugoki/dynamics/closed_reference.h"

#include <gtest/gtest.h>

#include "allocation_count.h"
#include "closed_motion.h"
#include "maximal_coordinates.h"
#include "random_loops.h"

namespace ugoki::dynamics {
namespace {

using namespace ugoki::testing;

constexpr Vec3 gravity{0, 0, -9.81};

/// A random tree with up to four random loops, closed at position and velocity level, under random forces.
struct RandomSystem {
  RandomLoops random;
  MechanismPtr m;
  State s;
  std::vector<Loop> closed;
  ClosedWorkspace cw;

  explicit RandomSystem(unsigned seed)
      : random(seed), m(*Mechanism::make(without_armature(random.m->spec()))), s(random.state), closed(chosen(seed)), cw(*m, closed) {
    RandomSource source(seed + 700);
    for (double& t : s.tau) t = source.uniform(-20, 20);
    for (Vec6& f : s.external) f = {source.vec(3), source.vec(10)};
    find_full_rank(*m, s.q, cw);
    close_velocities(*m, s.q, s.v, cw);
    update_closed(*m, s.q, s.v, cw);
  }
  std::vector<Loop> chosen(unsigned seed) {
    RandomSource source(seed + 900);
    std::vector<Loop> out;
    for (const Loop& loop : random.loops)
      if (source.below(3) == 0 && out.size() < 4) out.push_back(loop);
    Workspace ws(*m);
    LoopRows rows(out);
    update_kinematics(*m, s.q, s.v, ws);
    update_loop_rows(*m, ws, out, s.q, s.v, rows);
    for (std::size_t i = 0; i < out.size(); ++i)
      if (out[i].type == LoopType::gear) out[i].polynomial[0] += rows.gap[static_cast<std::size_t>(rows.first[i])];
    return out;
  }
};

double maximum(std::span<const double> x) {
  double maximum = 0;
  for (const double value : x) maximum = std::max(maximum, std::fabs(value));
  return maximum;
}

std::vector<double> loop_forces(const Mechanism& m, ClosedWorkspace& cw, std::span<const double> tau, std::span<const double> vdot) {
  std::vector<double> out(static_cast<std::size_t>(cw.rows.count()));
  calc_loop_forces(m, cw, tau, gravity_y, {}, vdot, out);
  return out;
}

TEST(ClosedReference, RandomSystemsMatchMaximalCoordinates) {
  for (unsigned seed = 1; seed <= 80; ++seed) {
    SCOPED_TRACE(seed);
    RandomSystem c(seed);
    std::vector<double> vdot(c.s.v.size());
    ASSERT_TRUE(calc_closed_forward_dynamics_by_unit_vectors(*c.m, c.cw, c.s.tau, gravity, c.s.external, vdot));
    MaximalCoordinates bodies(*c.m, c.closed);
    const std::vector<Vec6> expected = bodies.accelerations(c.s, gravity), got = bodies.accelerations_of(c.s, vdot);
    double size = 1, error = 0;
    for (std::size_t i = 0; i < got.size(); ++i) {
      size = std::max({size, norm(expected[i].w), norm(expected[i].v)});
      error = std::max({error, norm(got[i].w - expected[i].w), norm(got[i].v - expected[i].v)});
    }
    EXPECT_LT(error / size, 1e-7);  // the error of the finite differences
    EXPECT_EQ(c.cw.dofs(), 6 * c.m->link_count() - bodies.rank());
  }
}

// The columns of H are velocities that the loops allow. Motion along a column keeps the loops closed to first order: the gap grows with
// the square of the displacement.
TEST(ClosedReference, ColumnsOfHKeepLoopsClosed) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(seed);
    RandomSystem c(seed);
    const auto g = static_cast<std::size_t>(c.cw.dofs());
    const std::vector<double> H = c.cw.H;
    const std::vector<int> G(c.cw.theta_G().begin(), c.cw.theta_G().end());
    for (std::size_t k = 0; k < g; ++k) {
      std::vector<double> column(c.s.v.size()), q(c.s.q.size());
      for (std::size_t i = 0; i < column.size(); ++i) column[i] = H[i * g + k];
      EXPECT_EQ(column[static_cast<std::size_t>(G[k])], 1.0);
      const double size = std::max(1.0, maximum(column));
      double gap[2];
      for (int half = 0; half < 2; ++half) {
        integrate(*c.m, c.s.q, column, (half ? 0.5e-4 : 1e-4) / size, q);
        update_kinematics(*c.m, q, c.s.v, c.cw.open);
        update_loop_rows(*c.m, c.cw.open, c.cw.loops, q, c.s.v, c.cw.rows);
        gap[half] = measure_gap(c.cw).gap;
      }
      EXPECT_LT(gap[1], std::max(0.27 * gap[0], 1e-13));
      EXPECT_LT(gap[0], 1e-7);
    }
  }
}

TEST(ClosedReference, AccelerationsKeepLoopsClosed) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(seed);
    RandomSystem c(seed);
    std::vector<double> vdot(c.s.v.size()), q(c.s.q.size()), mean(vdot.size());
    ASSERT_TRUE(calc_closed_forward_dynamics_by_unit_vectors(*c.m, c.cw, c.s.tau, gravity, c.s.external, vdot));
    double gap[2];
    for (int half = 0; half < 2; ++half) {  // the motion is exact to second order in time: the gap is of third order
      const double t = half ? 1e-4 : 2e-4;
      for (std::size_t i = 0; i < mean.size(); ++i) mean[i] = c.s.v[i] + 0.5 * t * vdot[i];
      integrate(*c.m, c.s.q, mean, t, q);
      update_kinematics(*c.m, q, c.s.v, c.cw.open);
      update_loop_rows(*c.m, c.cw.open, c.cw.loops, q, c.s.v, c.cw.rows);
      gap[half] = measure_gap(c.cw).gap;
    }
    EXPECT_LT(gap[1], std::max(0.14 * gap[0], 1e-14));
  }
}

TEST(ClosedReference, InverseDynamicsInvertsForwardDynamicsWithMinimumNorm) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(seed);
    RandomSystem c(seed);
    const std::size_t n = c.s.v.size();
    std::vector<double> vdot(n), tau(n), again(n), weights;
    ASSERT_TRUE(calc_closed_forward_dynamics_by_unit_vectors(*c.m, c.cw, c.s.tau, gravity, c.s.external, vdot));
    // Drives at all independent DOFs (theta_G): the resulting forces reproduce the accelerations
    std::vector<int> driven(c.cw.theta_G().begin(), c.cw.theta_G().end());
    ASSERT_TRUE(calc_closed_inverse_dynamics(*c.m, c.cw, vdot, gravity, c.s.external, {}, driven, {}, tau));
    ASSERT_TRUE(calc_closed_forward_dynamics_by_unit_vectors(*c.m, c.cw, tau, gravity, c.s.external, again));
    for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(again[i], vdot[i], 1e-8 * std::max(1.0, maximum(vdot)));
    // Drives at all DOFs: the forces have the minimum norm, weighted by W, among all forces with the same effect. Hence tau^T W x = 0 for
    // all x with H^T x = 0.
    RandomSource source(seed);
    driven.clear();
    for (int i = 0; i < static_cast<int>(n); ++i) {
      driven.push_back(i);
      weights.push_back(source.uniform(0.1, 10));
    }
    ASSERT_TRUE(calc_closed_inverse_dynamics(*c.m, c.cw, vdot, gravity, c.s.external, {}, driven, weights, tau));
    ASSERT_TRUE(calc_closed_forward_dynamics_by_unit_vectors(*c.m, c.cw, tau, gravity, c.s.external, again));
    for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(again[i], vdot[i], 1e-8 * std::max(1.0, maximum(vdot)));
    const std::vector<double> J = c.cw.J;  // J H = 0, so each row of J is such an x
    for (std::size_t k = 0; k < c.cw.active.size(); ++k) {
      double work = 0, size = 1e-300;
      for (std::size_t i = 0; i < n; ++i) {
        const double x = J[k * n + i] / c.cw.dof_scale[i];
        work += tau[i] * weights[i] * x;
        size += std::fabs(tau[i] * weights[i] * x);
      }
      EXPECT_LT(std::fabs(work) / std::max(size, 1e-3), 1e-8);
    }
    // Too few drives are rejected
    if (c.cw.dofs() > 0) {
      driven.assign(c.cw.theta_G().begin() + 1, c.cw.theta_G().end());
      EXPECT_FALSE(calc_closed_inverse_dynamics(*c.m, c.cw, vdot, gravity, c.s.external, {}, driven, {}, tau));
    }
  }
}

TEST(ClosedReference, LoopForcesBalanceEveryJoint) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    RandomSystem c(seed);
    const std::size_t n = c.s.v.size(), rows = static_cast<std::size_t>(c.cw.rows.count());
    std::vector<double> vdot(n), force(rows), tau(n), row(n);
    ASSERT_TRUE(calc_closed_forward_dynamics_by_unit_vectors(*c.m, c.cw, c.s.tau, gravity, c.s.external, vdot));
    calc_loop_forces(*c.m, c.cw, c.s.tau, gravity, c.s.external, vdot, force);
    // If the loop forces act on the links as external wrenches, inverse dynamics of the open system gives the joint forces tau
    std::vector<Vec6> external = c.s.external;
    const Vec3 p0 = c.cw.open.p0;
    for (std::size_t i = 0; i < c.closed.size(); ++i)
      for (int r = 0; r < c.closed[i].rows() && c.closed[i].type != LoopType::gear; ++r) {
        const auto k = static_cast<std::size_t>(c.cw.rows.first[i] + r);
        const Vec6 w = c.cw.rows.W[k] * force[k], about_world{w.w + cross(p0, w.v), w.v};
        if (c.closed[i].link_b >= 0) external[static_cast<std::size_t>(c.closed[i].link_b)] += about_world;
        if (c.closed[i].link_a >= 0) external[static_cast<std::size_t>(c.closed[i].link_a)] -= about_world;
      }
    calc_inverse_dynamics(*c.m, c.cw.open, vdot, gravity, external, tau);
    for (std::size_t i = 0; i < c.closed.size(); ++i)
      if (c.closed[i].type == LoopType::gear) {
        const auto k = static_cast<std::size_t>(c.cw.rows.first[i]);
        tau[static_cast<std::size_t>(c.closed[i].dof_a)] -= force[k];
        tau[static_cast<std::size_t>(c.closed[i].dof_b)] += force[k] * c.cw.rows.slope[i];
      }
    for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(tau[i], c.s.tau[i], 1e-9 * std::max({1.0, maximum(force), maximum(c.s.tau)}));
  }
}

// Two identical pins close the same four-bar: each carries half of the force.
TEST(ClosedReference, RedundantLoopsShareTheirForcesEqually) {
  ClosedCase one = four_bar({}, 0.7, 2);
  MechanismSpec spec = one.mechanism->spec();
  spec.loops.push_back(spec.loops[0]);
  spec.loops[1].name = "second pin";
  const MechanismPtr m = Mechanism::make(spec).value();
  std::vector<double> single(5), both(10);
  for (const MechanismPtr& mechanism : {one.mechanism, m}) {
    ClosedWorkspace cw(*mechanism);
    update_closed(*mechanism, one.q, one.v, cw);
    EXPECT_EQ(cw.dofs(), 1);
    std::vector<double> tau{1, 0.3, -0.2}, vdot(3);
    ASSERT_TRUE(calc_closed_forward_dynamics_by_unit_vectors(*mechanism, cw, tau, gravity_y, {}, vdot));
    calc_loop_forces(*mechanism, cw, tau, gravity_y, {}, vdot, mechanism == m ? both : single);
  }
  EXPECT_GT(maximum(single), 1);
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_NEAR(both[k], 0.5 * single[k], 1e-11);
    EXPECT_NEAR(both[k + 5], 0.5 * single[k], 1e-11);
  }
}

TEST(ClosedReference, AndrewsMechanismStartsWithThePublishedAccelerationsAndForces) {
  for (const LoopType type : {LoopType::revolute, LoopType::ball}) {
    const ClosedCase c = andrews(type);
    ClosedWorkspace cw(*c.mechanism);
    update_closed(*c.mechanism, c.q, c.v, cw);
    EXPECT_EQ(cw.dofs(), 1);
    std::vector<double> tau(7), vdot(7), force(static_cast<std::size_t>(cw.rows.count()));
    Andrews::forces(c.q, tau);
    ASSERT_TRUE(calc_closed_forward_dynamics_by_unit_vectors(*c.mechanism, cw, tau, {}, {}, vdot));
    EXPECT_NEAR(vdot[0], 14222.4439199541138705911625887, 1e-6);
    EXPECT_NEAR(vdot[1], -10666.8329399655854029433719415, 1e-6);
    for (std::size_t i = 2; i < 7; ++i) EXPECT_NEAR(vdot[i], 0, 1e-6);
    calc_loop_forces(*c.mechanism, cw, tau, {}, {}, vdot, force);
    Vec3 on_k2;
    for (int r = 0; r < 3; ++r) on_k2 += cw.rows.W[static_cast<std::size_t>(r)].v * force[static_cast<std::size_t>(r)];
    EXPECT_NEAR(on_k2.x, -98.5668703962410896057654982170, 1e-8);
    EXPECT_NEAR(on_k2.y, 6.12268834425566265503114393122, 1e-8);
  }
}

// A loop that is cut at a massless virtual link of the rocker has the same motion and force as the pin.
TEST(ClosedReference, VirtualLinkIsEquivalentToPin) {
  const ClosedCase c = four_bar({}, 0.7, 2);
  MechanismSpec spec = c.mechanism->spec();
  spec.loops.clear();
  LinkSpec twin = hinged("rocker's end", "coupler", 1.0, 0, {});
  twin.real = "rocker";
  twin.X_RV.p = {0.8, 0, 0};
  spec.links.push_back(twin);
  const MechanismPtr m = Mechanism::make(spec).value();
  std::vector<double> q = c.q, v = c.v, tau{1, 0.3, -0.2}, vdot(3), with_twin(4);
  ClosedWorkspace pinned(*c.mechanism), cut(*m);
  update_closed(*c.mechanism, q, v, pinned);
  ASSERT_TRUE(calc_closed_forward_dynamics_by_unit_vectors(*c.mechanism, pinned, tau, gravity_y, {}, vdot));
  const std::vector<double> force = loop_forces(*c.mechanism, pinned, tau, vdot);
  q.push_back(q[2] - q[0] - q[1]);
  v.push_back(v[2] - v[0] - v[1]);
  tau.push_back(0);
  update_closed(*m, q, v, cut);
  EXPECT_EQ(cut.dofs(), 1);
  ASSERT_TRUE(calc_closed_forward_dynamics_by_unit_vectors(*m, cut, tau, gravity_y, {}, with_twin));
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(with_twin[i], vdot[i], 1e-11 * maximum(vdot));
  const std::vector<double> twin_force = loop_forces(*m, cut, tau, with_twin);
  Vec3 on_rocker, on_twin;  // link b of the pin is the rocker; link b of the weld is the virtual link
  for (std::size_t r = 0; r < 3; ++r) {
    on_rocker += pinned.rows.W[r].v * force[r];
    on_twin += cut.rows.W[r].v * twin_force[r];
  }
  EXPECT_LT(norm(on_rocker + on_twin), 1e-10 * norm(on_rocker));
}

TEST(ClosedReference, RankDoesNotDependOnTheUnitOfLength) {
  for (const double scale : {1e-4, 1.0, 1e4}) {
    ClosedCase c = slider_crank(0.3 * scale, scale, 0.4, 1);
    ClosedWorkspace cw(*c.mechanism);
    EXPECT_EQ(find_full_rank(*c.mechanism, c.q, cw), 2) << scale;
    update_closed(*c.mechanism, c.q, c.v, cw);
    EXPECT_EQ(cw.dofs(), 1) << scale;
    EXPECT_LT(maximum(cw.K), 4) << scale;
  }
}

TEST(ClosedReference, NonFiniteInputIsRejectedWithoutLastingEffect) {
  const ClosedCase c = four_bar({}, 0.7, 2);
  ClosedWorkspace cw(*c.mechanism);
  const std::vector<double> tau(3);
  std::vector<double> vdot(3), q = c.q, first(3);
  ASSERT_TRUE(calc_closed_acceleration(*c.mechanism, cw, c.q, c.v, tau, gravity_y, {}, first));
  for (std::size_t i = 0; i < 3; ++i) {
    q = c.q;
    q[i] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(calc_closed_acceleration(*c.mechanism, cw, q, c.v, tau, gravity_y, {}, vdot));
  }
  ASSERT_TRUE(calc_closed_acceleration(*c.mechanism, cw, c.q, c.v, tau, gravity_y, {}, vdot));
  EXPECT_EQ(vdot, first);
}

TEST(ClosedReference, StepsAllocateNothing) {
  for (const ClosedCase& c : {four_bar({}, 0.5, 3), n_four_bar(2), bricard(), four_bars_in_series(3)}) {
    ClosedMotion motion(c, 1e-3);
    ASSERT_TRUE(motion.advance(0.01));
    const long before = allocations_so_far();
    ASSERT_TRUE(motion.advance(0.8));  // the N-four-bar passes a change point
    EXPECT_EQ(allocations_so_far(), before) << c.mechanism->name();
  }
}

TEST(ClosedReference, RunsAreBitwiseRepeatable) {
  const auto run = [] {
    ClosedMotion motion(four_bar({}, 0.5, 3), 1e-3);
    EXPECT_TRUE(motion.advance(0.2));
    return std::vector<double>(motion.integrator.q().begin(), motion.integrator.q().end());
  };
  EXPECT_EQ(run(), run());
}

}  // namespace
}  // namespace ugoki::dynamics
