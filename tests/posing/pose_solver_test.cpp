#include "ugoki/posing/pose_solver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "ugoki/mechanism/state.h"
#include "ugoki/posing/pose_goals.h"
#include "ugoki/samples/samples.h"

namespace ugoki::posing {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

int labelled(const Mechanism& m, const std::string& label) {
  for (int i = 0; i < m.link_count(); ++i)
    if (m.link(i).label == label || m.link(i).name == label) return i;
  ADD_FAILURE() << "no link " << label;
  return 0;
}

/// A planar arm: `count` hinges about y, links of 1 m along x.
MechanismPtr make_arm(int count, double limit = 10) {
  MechanismSpec spec;
  spec.name = "arm";
  for (int i = 0; i < count; ++i) {
    LinkSpec link;
    link.name = "link" + std::to_string(i);
    if (i > 0) link.parent = "link" + std::to_string(i - 1);
    link.joint.type = JointType::revolute;
    link.joint.axis = {0, 1, 0};
    if (i > 0) link.joint.X_PJ.p = {1, 0, 0};
    link.joint.dofs[0].lower = -limit;
    link.joint.dofs[0].upper = limit;
    link.inertia = Inertia::from_centre(1, {0.5, 0, 0}, {0.1, 0.1, 0.1, 0, 0, 0});
    spec.links.push_back(link);
  }
  return Mechanism::make(spec).value();
}

Vec3 point_at(const Mechanism& m, std::span<const double> q, int link, const Vec3& p) {
  std::vector<Pose> X(at(m.link_count()));
  calc_poses(m, q, X);
  return X[at(link)] * p;
}

TEST(PoseSolver, TwoLinkArmHasTheAnglesOfTheLawOfCosines) {
  const MechanismPtr arm = make_arm(2);
  std::vector<double> q = {0.3, 0.5};
  for (const double reach : {0.6, 1.0, 1.4, 1.9}) {
    const std::vector<PoseGoal> goals = {{1, {1, 0, 0}, {reach, 0, 0}, false, {}}};
    EXPECT_LT(solve_pose(*arm, goals, {}, q), 2e-3) << reach;
    EXPECT_NEAR(std::fabs(q[1]), pi - std::acos((1 + 1 - reach * reach) / 2), 2e-2) << reach;
  }
}

TEST(PoseSolver, UnreachableTargetStretchesTheArmTowardsIt) {
  const MechanismPtr arm = make_arm(3);
  std::vector<double> q = {0.4, -0.6, 0.5};
  const std::vector<PoseGoal> goals = {{2, {1, 0, 0}, {3, 0, -4}, false, {}}};
  EXPECT_NEAR(solve_pose(*arm, goals, {}, q), 2, 1e-3);  // 5 m away, the arm is 3 m long
  const Vec3 end = point_at(*arm, q, 2, {1, 0, 0});
  EXPECT_NEAR(end.x, 1.8, 5e-3);
  EXPECT_NEAR(end.z, -2.4, 5e-3);
}

TEST(PoseSolver, KeepsLimitsExactlyAndLeavesFixedJoints) {
  const MechanismPtr arm = make_arm(4, 0.3);
  std::vector<double> q = {0, 0, 0, 0};
  const std::vector<PoseGoal> goals = {{3, {1, 0, 0}, {0, 0, -2}, false, {}}};
  solve_pose(*arm, goals, {}, q);
  for (const double x : q) EXPECT_LE(std::fabs(x), 0.3);
  EXPECT_DOUBLE_EQ(q[0], 0.3);
  q = {0, 0, 0, 0};
  solve_pose(*arm, goals, {.moves = {0, 1, 1, 1}}, q);
  EXPECT_EQ(q[0], 0);
  EXPECT_GT(q[1], 0.29);
  q = {0, 0, 0, 0};
  solve_pose(*arm, goals, {.limits = false}, q);
  EXPECT_GT(*std::max_element(q.begin(), q.end()), 0.31) << "without limits";
}

TEST(PoseSolver, ReachedTargetOfAHumanHandDoesNotMoveTheRest) {
  const MechanismPtr person = samples::make_person(1.75).value();
  const Mechanism& m = *person;
  const int hand = labelled(m, "hand right");
  std::vector<double> q = m.neutral();
  const std::vector<double> before = q;
  const Vec3 start = point_at(m, q, hand, {});
  std::vector<PoseGoal> goals = {{hand, {}, start, false, {}}};
  EXPECT_LT(solve_pose(m, goals, {}, q), 1e-9);
  EXPECT_EQ(q, before);
  goals[0].target = start + Vec3{0.1, 0.25, -0.2};
  EXPECT_LT(solve_pose(m, goals, {}, q), 5e-3);
}

TEST(PoseSolver, PinnedFeetStayWhileThePelvisGoesDown) {
  const MechanismPtr person = samples::make_person(1.75).value();
  const Mechanism& m = *person;
  std::vector<double> q = m.neutral();
  std::vector<Pose> X(at(m.link_count()));
  calc_poses(m, q, X);
  std::vector<PoseGoal> goals = {{0, {}, X[0].p + Vec3{-0.05, 0, -0.12}, false, {}}};
  std::vector<int> feet = {labelled(m, "foot left"), labelled(m, "foot right")};
  for (const int foot : feet) goals.push_back({foot, {}, X[at(foot)].p, true, X[at(foot)].R});
  EXPECT_LT(solve_pose(m, goals, {}, q), 4e-3);
  std::vector<Pose> now(X.size());
  calc_poses(m, q, now);
  for (const int foot : feet) {
    EXPECT_LT(norm(now[at(foot)].p - X[at(foot)].p), 4e-3);
    EXPECT_LT(norm(log_map(to_quat(now[at(foot)].R * X[at(foot)].R.transposed()))), 0.02);
  }
  // knees are hinges that bend in one direction only
  for (int i = 0; i < m.link_count(); ++i)
    for (int k = 0; k < m.link(i).joint.nv() && m.link(i).joint.type != JointType::floating; ++k) {
      double x[6];
      joint_displacement(m.link(i).joint, q.data() + m.link(i).q_index, x);
      EXPECT_GE(x[k], m.link(i).joint.dofs[at(k)].lower - 1e-9) << m.link(i).name;
      EXPECT_LE(x[k], m.link(i).joint.dofs[at(k)].upper + 1e-9) << m.link(i).name;
    }
}

/// J^T r is the gradient of half the sum of squared residuals, for goals and all types of loops. (Single rows may differ from the
/// derivative of their residual, because the residual of a loop is a vector that turns with the links.)
TEST(PoseGoals, GradientEqualsFiniteDifferences) {
  using enum LoopType;
  for (const LoopType type : {weld, ball, revolute, prismatic, cylindrical, planar, universal, distance, gear}) {
    MechanismSpec spec = make_arm(4)->spec();
    spec.links[2].joint.type = JointType::spherical;
    spec.links[3].joint.type = JointType::universal;
    spec.links[3].joint.axis2 = {0, 0, 1};
    spec.links[0].joint.type = JointType::floating;
    LoopSpec loop;
    loop.name = "loop";
    loop.type = type;
    loop.link_a = "link1";
    loop.link_b = "link3";
    loop.X_AJ = {to_matrix(exp_map({0.2, 0.1, -0.3})), {0.1, 0.2, 0.3}};
    loop.X_BJ = {to_matrix(exp_map({-0.1, 0.3, 0.2})), {0.5, -0.1, 0.2}};
    loop.axis = Vec3{1, 2, 2} / 3;
    loop.axis2 = Vec3{2, 1, -2} / 3;
    loop.length = 0.7;
    loop.dof_b = 1;
    loop.polynomial = {0.1, 0.5, 0.2, -0.1, 0.05};
    spec.loops = {loop};
    const auto made = Mechanism::make(spec);
    ASSERT_TRUE(made) << made.error().text();
    const Mechanism& m = **made;
    std::mt19937 random(20261126);
    std::uniform_real_distribution<double> uniform(-0.4, 0.4);
    std::vector<double> q = m.neutral(), v(at(m.nv()));
    for (double& x : v) x = uniform(random);
    integrate(m, q, v, 1, q);
    const std::vector<PoseGoal> goals = {{2, {0.3, 0.1, 0}, {1, 0.5, 0.2}, true, to_matrix(exp_map({0.3, -0.5, 0.2}))}};
    std::vector<Pose> X(at(m.link_count()));
    const auto equations_at = [&](std::span<const double> coordinates) {
      calc_poses(m, coordinates, X);
      std::vector<Variable> variables;
      for (int i = 0; i < m.link_count(); ++i) {
        Vec6 S[6];
        const int n = joint_subspace(m.link(i).joint, coordinates.data() + m.link(i).q_index, S);
        for (int k = 0; k < n; ++k) {
          const Vec3 w = X[at(i)].R * S[k].w;
          variables.push_back({i, k, {w, X[at(i)].R * S[k].v - cross(w, X[at(i)].p)}});
        }
      }
      Equations out;
      write_equations(m, goals, variables, coordinates, X, out);
      return out;
    };
    const auto cost_at = [&](std::span<const double> coordinates) {
      double sum = 0;
      for (const double r : equations_at(coordinates).residual) sum += 0.5 * r * r;
      return sum;
    };
    const Equations here = equations_at(q);
    const double h = 1e-6;
    for (int k = 0; k < m.nv(); ++k) {
      double gradient = 0;
      for (int r = 0; r < here.count; ++r) gradient += here.J[at(r) * at(m.nv()) + at(k)] * here.residual[at(r)];
      std::vector<double> step(at(m.nv()), 0.0), plus(q.size()), minus(q.size());
      step[at(k)] = h;
      integrate(m, q, step, 1, plus);
      integrate(m, q, step, -1, minus);
      EXPECT_NEAR(gradient, (cost_at(plus) - cost_at(minus)) / (2 * h), 1e-8) << name_of(type) << " DOF " << k;
    }
  }
}

/// A four-bar linkage: a turned crank moves the other links, and the loop stays closed.
TEST(PoseSolver, LoopOfAFourBarLinkageStaysClosed) {
  MechanismSpec spec = make_arm(3)->spec();
  LoopSpec loop;
  loop.name = "pivot";
  loop.type = LoopType::revolute;
  loop.link_b = "link2";
  loop.X_AJ.p = {1, 0, 0};
  loop.X_BJ.p = {1, 0, 0};
  loop.axis = {0, 1, 0};
  spec.loops = {loop};
  const MechanismPtr bars = Mechanism::make(spec).value();
  std::vector<double> q = {-pi / 2, pi / 2, pi / 2};  // a square
  ASSERT_LT(norm(point_at(*bars, q, 2, {1, 0, 0}) - Vec3{1, 0, 0}), 1e-12);
  for (const double crank : {-1.2, -0.9, -1.9}) {
    std::vector<double> turned = q;
    turned[0] = crank;
    solve_pose(*bars, {}, {.moves = {0, 1, 1}}, turned);
    EXPECT_EQ(turned[0], crank);
    EXPECT_LT(norm(point_at(*bars, turned, 2, {1, 0, 0}) - Vec3{1, 0, 0}), 1e-3) << crank;
    EXPECT_NEAR(turned[1], -crank, 0.02) << "a parallelogram keeps its bars parallel";
  }
}

}  // namespace
}  // namespace ugoki::posing
