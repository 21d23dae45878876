// Forward dynamics of closed link systems (articulated bodies with multipliers) compared with a dense solution in joint space.

#include "ugoki/dynamics/closed_links.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "allocation_count.h"
#include "dense_loops.h"
#include "random_loops.h"
#include "ugoki/dynamics/kernels.h"
#include "varied_mechanism.h"

namespace ugoki::dynamics {
namespace {

using testing::RandomLoops;
using testing::RandomSource;

using testing::Dense;
using testing::max_difference;
using testing::solve_by_kkt;

constexpr Vec3 gravity{0, 0, -9.81};

// Up to five links are attached to the world by ball or weld loops, as feet and hands are.
TEST(ClosedLinks, LinksFixedToTheWorldMatchDenseSolution) {
  int full = 0;
  std::size_t pairs = 0;
  for (unsigned seed = 1; seed < 120; ++seed) {
    RandomSource random(seed + 900);
    constexpr JointType types[] = {JointType::revolute, JointType::revolute, JointType::prismatic, JointType::helical,
                                   JointType::spherical};
    const MechanismPtr m = *Mechanism::make(seed % 2 == 0 ? testing::random_spec(random, 20, types, seed % 3 != 0)
                                                          : testing::twins_spec(random, seed % 3 != 0, types));
    if (m->nv() > 50) continue;  // the dense elimination becomes inaccurate
    State s(*m);
    testing::randomize(random, *m, s);
    Workspace ws(*m);
    update_kinematics(*m, s.q, s.v, ws);
    pairs += ws.twins.pairs.size();
    if (seed % 4 != 0) std::ranges::fill(s.external, Vec6{});  // without external wrenches, equal subtrees are computed in SIMD lanes
    std::vector<Loop> loops;
    for (int i = 0, n = 1 + random.below(5); i < n; ++i) {
      Loop l{.type = random.below(2) == 0 ? LoopType::weld : LoopType::ball, .link_b = random.below(m->link_count())};
      l.X_BJ = {random.rotation(), random.vec(0.3)};
      l.X_AJ = ws.X_WB[static_cast<std::size_t>(l.link_b)] * l.X_BJ;
      loops.push_back(l);
    }
    const std::vector<char> closed(loops.size(), 1);
    ClosedLinks links(*m, loops, closed);
    ASSERT_EQ(factor_closed_links(*m, ws, links, s.q, s.v), ClosedStatus::ok);
    project_velocity(*m, ws, links, s.v);
    const Dense dense = solve_by_kkt(*m, s, loops, closed);
    std::vector<double> vdot(s.v.size());
    ASSERT_EQ(calc_closed_forward_dynamics(*m, links, s.q, s.v, s.tau, gravity, s.external, vdot), ClosedStatus::ok);
    EXPECT_EQ(links.rank(), dense.rank) << "seed " << seed;
    EXPECT_LT(max_difference(vdot, dense.vdot), 1e-8) << "seed " << seed;
    if (links.rank() < links.rows().count()) continue;
    ++full;  // full rank: the multipliers are unique. Apply them to link b as wrenches along the loop's axes
    std::vector<Vec6> external = s.external;
    for (std::size_t i = 0; i < loops.size(); ++i)
      for (int r = 0; r < loops[i].rows(); ++r) {
        const double lambda = links.multipliers()[static_cast<std::size_t>(links.rows().first[i] + r)];
        const Vec3 along = loops[i].X_AJ.R.column(r % 3) * lambda;
        external[static_cast<std::size_t>(loops[i].link_b)] += r < 3 ? Vec6{cross(loops[i].X_AJ.p, along), along} : Vec6{along, {}};
      }
    std::vector<double> open(s.v.size());
    ASSERT_TRUE(calc_forward_dynamics(*m, ws, s.q, s.v, s.tau, gravity, external, open));
    EXPECT_LT(max_difference(open, vdot), 1e-8) << "multipliers, seed " << seed;
  }
  EXPECT_GT(full, 10);
  EXPECT_GT(pairs, 20U);
}

TEST(ClosedLinks, ForwardDynamicsMatchesDenseSolution) {
  for (unsigned seed = 1; seed < 200; ++seed) {
    RandomLoops c(seed);
    RandomSource random(seed + 5000);
    for (double& t : c.state.tau) t = random.uniform(-20, 20);
    for (Vec6& w : c.state.external) w = {random.vec(3), random.vec(10)};
    std::vector<char> closed(c.loops.size());
    const int count = 1 + random.below(4);
    for (int i = 0; i < count; ++i) closed[static_cast<std::size_t>(random.below(static_cast<int>(closed.size())))] = 1;
    Workspace ws(*c.m);
    ClosedLinks links(*c.m, c.loops, closed);
    // Project the velocities to J v = 0, as in a closed system
    update_kinematics(*c.m, c.state.q, c.state.v, ws);
    ASSERT_EQ(factor_closed_links(*c.m, ws, links, c.state.q, c.state.v), ClosedStatus::ok);
    project_velocity(*c.m, ws, links, c.state.v);
    update_kinematics(*c.m, c.state.q, c.state.v, ws);
    ASSERT_EQ(factor_closed_links(*c.m, ws, links, c.state.q, c.state.v), ClosedStatus::ok);
    std::vector<double> vdot(c.state.v.size());
    calc_closed_forward_dynamics(*c.m, ws, links, c.state.tau, gravity, c.state.external, vdot);
    const Dense dense = solve_by_kkt(*c.m, c.state, c.loops, closed);
    EXPECT_EQ(links.rank(), dense.rank) << "seed " << seed;
    EXPECT_LT(max_difference(vdot, dense.vdot), 1e-8) << "seed " << seed;
    std::vector<double> direct(vdot.size());
    ASSERT_EQ(calc_closed_forward_dynamics(*c.m, links, c.state.q, c.state.v, c.state.tau, gravity, c.state.external, direct),
              ClosedStatus::ok);
    EXPECT_EQ(links.rank(), dense.rank) << "from the state, seed " << seed;
    EXPECT_LT(max_difference(direct, dense.vdot), 1e-8) << "from the state, seed " << seed;
  }
}

TEST(ClosedLinks, MultipliersAreLoopForces) {
  // The open tree under tau + J^T lambda has the same acceleration as the closed system.
  for (unsigned seed = 1; seed < 100; ++seed) {
    RandomLoops c(seed);
    Workspace ws(*c.m);
    std::vector<char> closed(c.loops.size(), 1);
    closed[seed % closed.size()] = 0;
    ClosedLinks links(*c.m, c.loops, closed);
    update_kinematics(*c.m, c.state.q, c.state.v, ws);
    ASSERT_EQ(factor_closed_links(*c.m, ws, links, c.state.q, c.state.v), ClosedStatus::ok);
    project_velocity(*c.m, ws, links, c.state.v);
    update_kinematics(*c.m, c.state.q, c.state.v, ws);
    ASSERT_EQ(factor_closed_links(*c.m, ws, links, c.state.q, c.state.v), ClosedStatus::ok);
    std::vector<double> vdot(c.state.v.size()), open(c.state.v.size()), tau = c.state.tau, J(c.state.v.size());
    calc_closed_forward_dynamics(*c.m, ws, links, c.state.tau, gravity, c.state.external, vdot);
    double size = 1;
    for (std::size_t i = 0; i < c.loops.size(); ++i)
      for (int r = 0; r < c.loops[i].rows(); ++r) {
        const double lambda = links.multipliers()[static_cast<std::size_t>(links.rows().first[i] + r)];
        if (!closed[i]) {
          EXPECT_EQ(lambda, 0);
        }
        calc_loop_jacobian_row(*c.m, ws, c.loops[i], links.rows(), static_cast<int>(i), r, J);
        for (std::size_t f = 0; f < J.size(); ++f) tau[f] += J[f] * lambda;
        size = std::max(size, std::fabs(lambda));
      }
    ASSERT_TRUE(calc_forward_dynamics(*c.m, ws, tau, gravity, c.state.external, open));
    EXPECT_LT(max_difference(vdot, open), 1e-10 * size) << "seed " << seed;
  }
}

TEST(ClosedLinks, VelocityProjectionIsADissipativeImpulseAndKeepsLoopsClosed) {
  for (unsigned seed = 1; seed < 100; ++seed) {
    RandomLoops c(seed);
    Workspace ws(*c.m);
    const std::vector<char> closed(c.loops.size(), 1);
    ClosedLinks links(*c.m, c.loops, closed);
    const std::vector<double> before = c.state.v;
    update_kinematics(*c.m, c.state.q, c.state.v, ws);
    std::vector<double> M(before.size() * before.size()), J(before.size());
    calc_inertia_matrix(*c.m, ws, M);
    const auto energy = [&](std::span<const double> v) {  // including the armatures
      double twice = 0;
      for (std::size_t i = 0; i < v.size(); ++i)
        for (std::size_t j = 0; j < v.size(); ++j) twice += v[i] * M[i * v.size() + j] * v[j];
      return twice / 2;
    };
    ASSERT_EQ(factor_closed_links(*c.m, ws, links, c.state.q, c.state.v), ClosedStatus::ok);
    project_velocity(*c.m, ws, links, c.state.v);
    // Check M (v' - v) = J^T impulse and J v' = 0; the energy lost is the kinetic energy of the velocity change
    std::vector<double> momentum(before.size());
    double lost = 0, rate = 0, size = 1;
    for (std::size_t i = 0; i < before.size(); ++i) {
      for (std::size_t j = 0; j < before.size(); ++j) momentum[i] += M[i * before.size() + j] * (c.state.v[j] - before[j]);
      lost += 0.5 * momentum[i] * (c.state.v[i] - before[i]);
      size = std::max(size, std::fabs(momentum[i]));
    }
    for (std::size_t i = 0; i < c.loops.size(); ++i)
      for (int r = 0; r < c.loops[i].rows(); ++r) {
        calc_loop_jacobian_row(*c.m, ws, c.loops[i], links.rows(), static_cast<int>(i), r, J);
        const double impulse = links.multipliers()[static_cast<std::size_t>(links.rows().first[i] + r)];
        double now = 0;
        for (std::size_t f = 0; f < J.size(); ++f) {
          momentum[f] -= J[f] * impulse;
          now += J[f] * c.state.v[f];
        }
        rate = std::max(rate, std::fabs(now));
      }
    for (const double p : momentum) EXPECT_NEAR(p, 0, 1e-9 * size) << "seed " << seed;
    EXPECT_LT(rate, 1e-9) << "seed " << seed;
    EXPECT_NEAR(energy(before) - energy(c.state.v), lost, 1e-9 * (1 + energy(before))) << "seed " << seed;
  }
}

TEST(ClosedLinks, PositionProjectionClosesLoopsToRounding) {
  int hard = 0;
  for (unsigned seed = 1; seed < 200; ++seed) {
    RandomLoops c(seed);
    RandomSource random(seed + 7);
    std::vector<char> closed(c.loops.size());
    for (int i = 0; i < 2; ++i) closed[static_cast<std::size_t>(random.below(static_cast<int>(closed.size())))] = 1;
    closed.back() = 0;
    ClosedLinks links(*c.m, c.loops, closed);
    Workspace ws(*c.m);
    std::vector<double> away(c.state.v.size());
    for (double& x : away) x = random.uniform(-0.02, 0.02);
    integrate(*c.m, c.state.q, away, 1, c.state.q);
    double gap = 0;
    const ClosedStatus status = project_position(*c.m, ws, links, c.state.q, c.state.v, gap);
    if (status != ClosedStatus::ok)
      ++hard;
    else
      EXPECT_LT(gap, 1e-13) << "seed " << seed;
  }
  EXPECT_LE(hard, 4) << "near a singular configuration Newton's method may not converge";
}

// project_position() is the second method: it factors the closed system at the final position as well.
TEST(ClosedLinks, ClosingWithoutTheFinalFactorGivesTheSamePosition) {
  int closed_loops = 0;
  for (unsigned seed = 1; seed < 60; ++seed) {
    RandomLoops c(seed);
    RandomSource random(seed + 7);
    std::vector<double> away(c.state.v.size());
    for (double& x : away) x = random.uniform(-0.02, 0.02);
    integrate(*c.m, c.state.q, away, 1, c.state.q);
    std::vector<char> closed(c.loops.size());  // two loops: with all of them, rounding leaves gaps of 1e-12
    for (int i = 0; i < 2; ++i) closed[static_cast<std::size_t>(random.below(static_cast<int>(closed.size())))] = 1;
    closed.back() = 0;
    ClosedLinks with_factor(*c.m, c.loops, closed), without(*c.m, c.loops, closed);
    Workspace ws(*c.m), other(*c.m);
    std::vector<double> q(c.state.q.begin(), c.state.q.end());
    double gap = 0, other_gap = 0;
    const ClosedStatus status = project_position(*c.m, ws, with_factor, c.state.q, c.state.v, gap);
    if (status != ClosedStatus::ok) continue;
    ++closed_loops;
    EXPECT_EQ(close_position(*c.m, other, without, q, c.state.v, other_gap), status);
    EXPECT_LT(other_gap, 1e-13) << "seed " << seed;
    for (std::size_t i = 0; i < q.size(); ++i) EXPECT_NEAR(q[i], c.state.q[i], 1e-13) << "seed " << seed;
    // The gaps at the returned position, from new kinematics.
    update_kinematics(*c.m, q, c.state.v, other);
    ASSERT_EQ(factor_closed_links(*c.m, other, without, q, c.state.v), ClosedStatus::ok);
    EXPECT_LT(max_gap(without), 1e-13) << "seed " << seed;
  }
  EXPECT_GT(closed_loops, 20);
}

/// A planar four-bar linkage, cut at its last pin. The cut is closed by a virtual link or by a loop.
MechanismSpec four_bar(bool virtual_link) {
  MechanismSpec spec;
  spec.name = "four-bar";
  const auto bar = [&](const char* name, const char* parent, Vec3 at, double length) {
    LinkSpec l;
    l.name = name;
    l.parent = parent;
    l.joint.type = JointType::revolute;
    l.joint.axis = {0, 1, 0};
    l.joint.X_PJ.p = at;
    l.inertia = Inertia::from_centre(length, {length / 2, 0, 0}, {0.001, length * length / 12, length * length / 12, 0, 0, 0});
    spec.links.push_back(l);
  };
  bar("crank", "", {0, 0, 0}, 0.3);
  bar("coupler", "crank", {0.3, 0, 0}, 1.0);
  if (virtual_link) {
    bar("rocker", "", {0.9, 0, 0}, 0.8);
    bar("rocker again", "coupler", {1.0, 0, 0}, 1);
    spec.links.back().inertia = {};
    spec.links.back().real = "rocker";
    spec.links.back().X_RV.p = {0.8, 0, 0};
  } else {
    bar("rocker", "", {0.9, 0, 0}, 0.8);
    spec.loops.push_back({.name = "pin",
                          .type = LoopType::revolute,
                          .link_a = "rocker",
                          .link_b = "coupler",
                          .X_AJ = {Mat3::identity(), {0.8, 0, 0}},
                          .X_BJ = {Mat3::identity(), {1.0, 0, 0}},
                          .axis = {0, 1, 0}});
  }
  return spec;
}

TEST(ClosedLinks, MasslessVirtualLinkIsEquivalentToLoop) {
  const MechanismPtr cut = *Mechanism::make(four_bar(true)), loop = *Mechanism::make(four_bar(false));
  Workspace ws_cut(*cut), ws_loop(*loop);
  ClosedLinks links_cut(*cut), links_loop(*loop);
  State s(*loop);
  s.q = {0.7, -0.4, -1.2};
  s.v = {2, -0.5, 0.3};
  double gap = 0;
  ASSERT_EQ(project_position(*loop, ws_loop, links_loop, s.q, s.v, gap), ClosedStatus::ok);
  EXPECT_EQ(links_loop.rank(), 2) << "three of the five rows of a planar loop are redundant";
  project_velocity(*loop, ws_loop, links_loop, s.v);
  State t(*cut);
  std::ranges::copy(s.q, t.q.begin());
  std::ranges::copy(s.v, t.v.begin());
  t.q[3] = s.q[2] - s.q[0] - s.q[1];
  t.v[3] = s.v[2] - s.v[0] - s.v[1];
  ASSERT_EQ(project_position(*cut, ws_cut, links_cut, t.q, t.v, gap), ClosedStatus::ok);
  EXPECT_EQ(links_cut.rank(), 3);
  update_kinematics(*cut, t.q, t.v, ws_cut);
  update_kinematics(*loop, s.q, s.v, ws_loop);
  ASSERT_EQ(factor_closed_links(*cut, ws_cut, links_cut, t.q, t.v), ClosedStatus::ok);
  ASSERT_EQ(factor_closed_links(*loop, ws_loop, links_loop, s.q, s.v), ClosedStatus::ok);
  s.tau[0] = 3;
  t.tau[0] = 3;
  std::vector<double> a(3), b(4);
  calc_closed_forward_dynamics(*loop, ws_loop, links_loop, s.tau, gravity, {}, a);
  calc_closed_forward_dynamics(*cut, ws_cut, links_cut, t.tau, gravity, {}, b);
  std::vector<double> direct(3), direct_cut(4);
  ASSERT_EQ(calc_closed_forward_dynamics(*loop, links_loop, s.q, s.v, s.tau, gravity, {}, direct), ClosedStatus::ok);
  ASSERT_EQ(calc_closed_forward_dynamics(*cut, links_cut, t.q, t.v, t.tau, gravity, {}, direct_cut), ClosedStatus::ok);
  EXPECT_EQ(links_loop.rank(), 2);
  EXPECT_EQ(links_cut.rank(), 3);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(a[i], b[i], 1e-10 * (1 + std::fabs(a[i])));
    EXPECT_NEAR(a[i], direct[i], 1e-10 * (1 + std::fabs(a[i])));
    EXPECT_NEAR(a[i], direct_cut[i], 1e-10 * (1 + std::fabs(a[i])));
  }
}

TEST(ClosedLinks, ResultsAreBitIdenticalForAllSimdWidths) {
  const SimdWidth widest = widest_simd();
  for (unsigned seed = 1; seed < 20; ++seed) {
    RandomLoops c(seed);
    const std::vector<char> closed(c.loops.size(), 1);
    ClosedLinks links(*c.m, c.loops, closed);
    std::vector<double> first(c.state.v.size()), again(c.state.v.size());
    ASSERT_TRUE(use_simd(SimdWidth::plain));
    ASSERT_EQ(calc_closed_forward_dynamics(*c.m, links, c.state.q, c.state.v, c.state.tau, gravity, {}, first), ClosedStatus::ok);
    const std::vector<double> multipliers(links.multipliers().begin(), links.multipliers().end());
    for (const SimdWidth width : {SimdWidth::avx2, SimdWidth::avx512}) {
      if (!use_simd(width)) continue;
      ASSERT_EQ(calc_closed_forward_dynamics(*c.m, links, c.state.q, c.state.v, c.state.tau, gravity, {}, again), ClosedStatus::ok);
      EXPECT_EQ(std::memcmp(first.data(), again.data(), first.size() * sizeof(double)), 0) << "seed " << seed;
      EXPECT_EQ(std::memcmp(multipliers.data(), links.multipliers().data(), multipliers.size() * sizeof(double)), 0) << "seed " << seed;
    }
    use_simd(widest);
  }
}

TEST(ClosedLinks, StepsAllocateNothing) {
  RandomLoops c(3);
  const std::vector<char> closed(c.loops.size(), 1);
  ClosedLinks links(*c.m, c.loops, closed);
  Workspace ws(*c.m);
  std::vector<double> vdot(c.state.v.size());
  double gap = 0;
  const auto step = [&] {
    const ClosedStatus near = project_position(*c.m, ws, links, c.state.q, c.state.v, gap);
    project_velocity(*c.m, ws, links, c.state.v);
    const ClosedStatus direct = calc_closed_forward_dynamics(*c.m, links, c.state.q, c.state.v, c.state.tau, gravity, {}, vdot);
    update_kinematics(*c.m, c.state.q, c.state.v, ws);
    const ClosedStatus factor = factor_closed_links(*c.m, ws, links, c.state.q, c.state.v);
    calc_closed_forward_dynamics(*c.m, ws, links, c.state.tau, gravity, {}, vdot);
    return near == ClosedStatus::ok && direct == ClosedStatus::ok && factor == ClosedStatus::ok;
  };
  ASSERT_TRUE(step());
  const auto before = allocations_so_far();
  ASSERT_TRUE(step());
  EXPECT_EQ(allocations_so_far(), before);
}

TEST(ClosedLinks, DofWithoutInertiaIsReported) {
  MechanismSpec spec = four_bar(false);
  spec.links[1].inertia = {};  // the coupler: its joint moves (almost) no mass
  spec.links.push_back(spec.links[2]);
  spec.links.back().name = "weight";
  spec.links.back().parent = "coupler";
  spec.links.back().joint.type = JointType::fixed;
  spec.links.back().inertia = {1e-320, {}, {}};
  const auto made = Mechanism::make(std::move(spec));
  ASSERT_TRUE(made.has_value()) << made.error().text();
  ClosedLinks links(**made);
  Workspace ws(**made);
  std::vector<double> q = {0.7, -0.4, -1.2}, v(3), vdot(3);
  EXPECT_EQ(calc_closed_forward_dynamics(**made, links, q, v, {}, gravity, {}, vdot), ClosedStatus::singular_inertia);
  update_kinematics(**made, q, v, ws);
  EXPECT_EQ(factor_closed_links(**made, ws, links, q, v), ClosedStatus::singular_inertia);
  EXPECT_GE(links.singular_dof(), 0);
}

}  // namespace
}  // namespace ugoki::dynamics
