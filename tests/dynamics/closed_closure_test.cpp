// Closing of loops at position and velocity level, and the diagnosis of loops.

#include "ugoki/dynamics/loop_closure.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "closed_motion.h"
#include "random_loops.h"
#include "ugoki/dynamics/loop_diagnosis.h"

namespace ugoki::dynamics {
namespace {

using namespace ugoki::testing;

constexpr double held = std::numeric_limits<double>::infinity();  // weight of a DOF that must not move

double gap_at(const Mechanism& m, ClosedWorkspace& cw, const std::vector<double>& q) {
  const std::vector<double> v(static_cast<std::size_t>(m.nv()));
  update_kinematics(m, q, v, cw.open);
  update_loop_rows(m, cw.open, cw.loops, q, v, cw.rows);
  return measure_gap(cw).gap;
}

TEST(LoopClosure, FourBarAssemblesFromDistantStartsToClosedFormSolution) {
  const FourBar bars;
  const MechanismPtr m = four_bar(bars, 0.5, 0).mechanism;
  ClosedWorkspace cw(*m);
  RandomSource random(11);
  for (int k = 0; k < 200; ++k) {
    SCOPED_TRACE(k);
    const double crank = random.uniform(-3, 3);
    std::vector<double> q{crank, random.uniform(-3, 3), random.uniform(-3, 3)};
    const std::vector<double> weights{held, 1, 1};
    ASSERT_TRUE(assemble(*m, q, cw, weights).closed);
    EXPECT_EQ(q[0], crank);  // a held DOF does not move
    EXPECT_LT(gap_at(*m, cw, q), 1e-13);
    // Freudenstein's equation relates crank and rocker of every closed four-bar
    const double k1 = bars.ground / bars.crank, k2 = bars.ground / bars.rocker;
    const double k3 = (bars.crank * bars.crank - bars.coupler * bars.coupler + bars.rocker * bars.rocker + bars.ground * bars.ground) /
                      (2 * bars.crank * bars.rocker);
    EXPECT_NEAR(k1 * std::cos(q[2]) - k2 * std::cos(q[0]) + k3, std::cos(q[0] - q[2]), 1e-12);
  }
}

TEST(LoopClosure, EveryLoopTypeAssemblesFromDistantStarts) {
  int closed_systems = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    RandomLoops c(seed);
    RandomSource random(seed);
    std::vector<Loop> loops;
    for (const Loop& loop : c.loops)
      if (loop.type != LoopType::gear && random.below(3) == 0 && loops.size() < 2) loops.push_back(loop);
    ClosedWorkspace cw(*c.m, loops);
    std::vector<double> away(c.state.v.size()), q(c.state.q.size());
    for (double& x : away) x = random.uniform(-0.4, 0.4);
    integrate(*c.m, c.state.q, away, 1, q);
    const std::vector<double> start = q;
    ASSERT_TRUE(assemble(*c.m, q, cw).closed);
    EXPECT_LT(gap_at(*c.m, cw, q), 1e-11);
    std::vector<double> moved(away.size());
    difference(*c.m, start, q, moved);
    for (const double x : moved) EXPECT_LT(std::fabs(x), 3);
    ++closed_systems;
  }
  EXPECT_EQ(closed_systems, 60);
}

// Two axes that are antiparallel leave no gap, but the intended configuration has parallel axes.
TEST(LoopClosure, AssembledAxesAreNotAntiparallel) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    RandomLoops c(seed);
    RandomSource random(seed);
    const LoopType type = std::array{LoopType::revolute, LoopType::cylindrical, LoopType::planar}[seed % 3];
    const Loop loop = *std::ranges::find(c.loops, type, &Loop::type);
    ClosedWorkspace cw(*c.m, std::span(&loop, 1));
    std::vector<double> away(c.state.v.size()), q(c.state.q.size());
    for (double& x : away) x = random.uniform(-2.5, 2.5);
    integrate(*c.m, c.state.q, away, 1, q);
    ASSERT_TRUE(assemble(*c.m, q, cw).closed);
    std::vector<Pose> X(static_cast<std::size_t>(c.m->link_count()));
    calc_poses(*c.m, q, X);
    const Mat3 R_WA = loop.link_a < 0 ? loop.X_AJ.R : X[static_cast<std::size_t>(loop.link_a)].R * loop.X_AJ.R;
    EXPECT_NEAR(dot(R_WA * loop.axis, X[static_cast<std::size_t>(loop.link_b)].R * (loop.X_BJ.R * loop.axis)), 1, 1e-9);
  }
}

// Near a closed configuration the correction has the minimum weighted norm: it is orthogonal to all motions that the loops permit.
TEST(LoopClosure, PositionCorrectionIsMinimalInWeightedNorm) {
  const ClosedCase c = four_bars_in_series(3);
  const Mechanism& m = *c.mechanism;
  ClosedWorkspace cw(m);
  RandomSource random(3);
  std::vector<double> weights, q = c.q, start;
  for (std::size_t i = 0; i < q.size(); ++i) {
    weights.push_back(random.uniform(0.2, 5));
    q[i] += random.uniform(-1e-5, 1e-5);
  }
  start = q;
  ASSERT_TRUE(close_positions(m, q, cw, weights).closed);
  update_closed(m, q, c.v, cw);
  const auto g = static_cast<std::size_t>(cw.dofs());
  ASSERT_EQ(g, 3U);
  for (std::size_t k = 0; k < g; ++k) {
    double along = 0;
    for (std::size_t i = 0; i < q.size(); ++i) along += cw.H[i * g + k] * weights[i] * (q[i] - start[i]);
    EXPECT_NEAR(along, 0, 1e-9);
  }
}

TEST(LoopClosure, VelocityCorrectionIsMinimalInWeightedNorm) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(seed);
    RandomLoops c(seed);
    std::vector<Loop> loops(c.loops.begin(), c.loops.begin() + 1 + seed % 4);
    ClosedWorkspace cw(*c.m, loops);
    RandomSource random(seed);
    std::vector<double> weights, v = c.state.v;
    for (std::size_t i = 0; i < v.size(); ++i) weights.push_back(random.uniform(0.2, 5));
    close_velocities(*c.m, c.state.q, v, cw, weights);
    const std::size_t n = v.size(), g = static_cast<std::size_t>(cw.dofs());
    for (std::size_t k = 0; k < cw.active.size(); ++k) {
      double rate = 0;
      for (std::size_t i = 0; i < n; ++i) rate += cw.J[k * n + i] / cw.dof_scale[i] * v[i];
      EXPECT_NEAR(rate, 0, 1e-11);
    }
    for (std::size_t a = 0; a < g; ++a) {
      double along = 0;
      for (std::size_t i = 0; i < n; ++i)
        along += cw.H[i * g + a] * weights[i] / (cw.dof_scale[i] * cw.dof_scale[i]) * (v[i] - c.state.v[i]);
      EXPECT_NEAR(along, 0, 1e-9);
    }
    const std::vector<double> once = v;
    close_velocities(*c.m, c.state.q, v, cw, weights);
    for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(v[i], once[i], 1e-11);
  }
}

TEST(LoopClosure, HeldVelocitiesDetermineTheOthers) {
  for (const double angle : {0.3, 1.7, 3.0, 5.0}) {
    const ClosedCase c = four_bar({}, angle, 3);
    ClosedWorkspace cw(*c.mechanism);
    for (std::size_t driver = 0; driver < 3; ++driver) {
      std::vector<double> weights(3, 1), v{0.4, -7, 2};
      weights[driver] = held;
      v[driver] = c.v[driver];
      close_velocities(*c.mechanism, c.q, v, cw, weights);
      for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(v[i], c.v[i], 1e-12) << angle << " " << driver;
    }
  }
}

TEST(LoopClosure, ProjectionDoesNotMoveThetaG) {
  const ClosedCase c = four_bars_in_series(4);
  ClosedWorkspace cw(*c.mechanism);
  std::vector<double> q = c.q, v = c.v;
  ASSERT_TRUE(project_closed_state(*c.mechanism, q, v, cw).closed);
  EXPECT_EQ(q, c.q);  // the loops are already closed to rounding, so nothing moves
  const std::vector<int> G(cw.theta_G().begin(), cw.theta_G().end());
  for (std::size_t i = 0; i < q.size(); ++i) q[i] += 1e-3 * static_cast<double>(i % 3);
  const std::vector<double> before = q;
  ASSERT_TRUE(project_closed_state(*c.mechanism, q, v, cw).closed);
  EXPECT_LT(gap_at(*c.mechanism, cw, q), 1e-14);
  for (const int g : G) EXPECT_EQ(q[static_cast<std::size_t>(g)], before[static_cast<std::size_t>(g)]);
}

// Repeated loops give more than twice as many rows as DOFs; the step is then computed with a matrix of the size of the DOFs.
TEST(LoopClosure, RepeatedLoopsCloseAsOneDoes) {
  const ClosedCase c = four_bar({}, 0.5, 0);
  MechanismSpec spec = c.mechanism->spec();
  const LoopSpec loop = spec.loops[0];
  for (int i = 0; i < 4; ++i) {
    spec.loops.push_back(loop);
    spec.loops.back().name += std::to_string(i);
  }
  const MechanismPtr many = Mechanism::make(spec).value();
  ClosedWorkspace one_workspace(*c.mechanism), many_workspace(*many);
  ASSERT_GT(many_workspace.active.size(), 2 * static_cast<std::size_t>(many->nv()));
  std::vector<double> weights(static_cast<std::size_t>(many->nv()), 1.0);
  weights[0] = std::numeric_limits<double>::infinity();  // the crank stays, so that the closed configuration is unique
  weights[1] = 3;
  std::vector<double> one = c.q, repeated = c.q;
  for (std::size_t i = 1; i < one.size(); ++i) one[i] = repeated[i] += 0.1;
  ASSERT_TRUE(close_positions(*c.mechanism, one, one_workspace, weights).closed);
  ASSERT_TRUE(close_positions(*many, repeated, many_workspace, weights).closed);
  EXPECT_EQ(repeated[0], c.q[0]);
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_NEAR(repeated[i], one[i], 1e-11) << i;
}

TEST(LoopClosure, LoopThatCannotCloseIsExplained) {
  FourBar bars;
  ClosedCase c = four_bar(bars, 0.5, 0);
  MechanismSpec spec = c.mechanism->spec();
  spec.links[1].joint.X_PJ.p.x = 0.1;  // a crank of 0.1 m and a coupler of 0.2 m are too short
  spec.loops[0].X_AJ.p.x = 0.2;
  spec.links[2].joint.X_PJ.p.x = 1.5;
  const MechanismPtr m = Mechanism::make(spec).value();
  ClosedWorkspace cw(*m);
  const Closure closure = assemble(*m, c.q, cw);
  EXPECT_FALSE(closure.closed);
  EXPECT_NEAR(closure.gap, 1.5 - 0.8 - 0.3, 1e-6);
  const std::string text = explain_gap(*m, cw, closure).text();
  EXPECT_EQ(text,
            "loop pin: The loop cannot be closed: a gap of 0.40 m remains in its translation along x. Lengths of its links, from joint to "
            "joint: coupler 0.2000 m, crank 0.1000 m, rocker 0.8000 m, the world 1.5000 m. "
            "The longest, the world, is 0.4000 m longer than all the others together. Shorten the longest, or lengthen the "
            "others.");
}

TEST(LoopDiagnosis, PlanarFourBarHasThreeRedundantRows) {
  const ClosedCase c = four_bar({}, 0.5, 0);
  ClosedWorkspace cw(*c.mechanism);
  const LoopDiagnosis d = diagnose_loops(*c.mechanism, c.q, cw);
  EXPECT_EQ(d.rows, 5);
  EXPECT_EQ(d.rank, 2);
  EXPECT_EQ(d.dofs, 1);
  EXPECT_FALSE(d.is_singular_here());
  const std::string text = describe(d, cw);
  for (const char* part :
       {"1 degree of freedom: 3 degrees of freedom of joints less 2 independent rows of 5.", "loop pin: translation along z"})
    EXPECT_NE(text.find(part), std::string::npos) << text;
  EXPECT_EQ(d.redundant, (std::vector<int>{2, 3, 4})) << text;
}

TEST(LoopDiagnosis, ChangePointsAreSingularAndOverConstraintIsNot) {
  // N-four-bar with all bars horizontal: N additional DOFs (IFToMM A02)
  for (const int n : {1, 2}) {
    ClosedCase c = n_four_bar(n);
    for (std::size_t i = 0; i < c.q.size(); ++i) c.q[i] = 0;
    ClosedWorkspace cw(*c.mechanism);
    const LoopDiagnosis d = diagnose_loops(*c.mechanism, c.q, cw);
    EXPECT_EQ(d.dofs, 1);
    EXPECT_EQ(d.dofs_here, n + 1);
    EXPECT_EQ(d.vanishing.size(), static_cast<std::size_t>(n));
    EXPECT_EQ(d.redundant.size(), static_cast<std::size_t>(3 * n));
    EXPECT_NE(describe(d, cw).find("Singular configuration: " + std::to_string(n + 1) + " degrees of freedom here"), std::string::npos);
  }
  // Bricard: the five rows of the last hinge act on five DOFs; one row is redundant everywhere
  const ClosedCase c = bricard();
  ClosedWorkspace cw(*c.mechanism);
  const LoopDiagnosis d = diagnose_loops(*c.mechanism, c.q, cw);
  EXPECT_EQ(d.rank, 4);
  EXPECT_EQ(d.dofs, 1);
  EXPECT_EQ(d.redundant.size(), 1U);
  EXPECT_FALSE(d.is_singular_here());
}

TEST(LoopDiagnosis, EqualLengthSliderCrankIsSingularAtItsChangePoint) {
  ClosedCase c = slider_crank(0.5, 0.5, 0.2, 0);
  c.q = {pi / 2, -pi, 0};
  ClosedWorkspace cw(*c.mechanism);
  const LoopDiagnosis d = diagnose_loops(*c.mechanism, c.q, cw);
  EXPECT_EQ(d.dofs, 1);
  EXPECT_EQ(d.dofs_here, 2);
}

TEST(LoopDiagnosis, BracedFourBarHasNoDof) {
  MechanismSpec spec = four_bar({}, 0.5, 0).mechanism->spec();
  LoopSpec brace = spec.loops[0];
  brace.name = "brace";
  brace.type = LoopType::distance;
  brace.link_a.clear();
  brace.X_AJ = {};
  brace.X_BJ.p = {0.4, 0, 0};
  const std::vector<double> q = four_bar({}, 0.5, 0).q;
  brace.length = norm(Vec3{0.9 + 0.4 * std::cos(q[2]), 0.4 * std::sin(q[2]), 0});
  spec.loops.push_back(brace);
  const MechanismPtr m = Mechanism::make(spec).value();
  ClosedWorkspace cw(*m);
  EXPECT_LT(gap_at(*m, cw, q), 1e-14);
  const LoopDiagnosis d = diagnose_loops(*m, q, cw);
  EXPECT_EQ(d.dofs, 0);
  EXPECT_NE(describe(d, cw).find("0 degrees of freedom"), std::string::npos);
}

// Opening one loop of the ladder restores two planar degrees of freedom.
TEST(LoopDiagnosis, OpeningLoopsRestoresDofs) {
  const ClosedCase c = n_four_bar(3);
  ClosedWorkspace cw(*c.mechanism);
  EXPECT_EQ(diagnose_loops(*c.mechanism, c.q, cw).dofs, 1);
  set_closed(*c.mechanism, cw, 1, false);
  EXPECT_EQ(diagnose_loops(*c.mechanism, c.q, cw).dofs, 3);
  for (int i : {0, 2}) set_closed(*c.mechanism, cw, i, false);
  EXPECT_EQ(diagnose_loops(*c.mechanism, c.q, cw).dofs, 7);
}

}  // namespace
}  // namespace ugoki::dynamics
