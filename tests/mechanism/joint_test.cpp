#include "ugoki/mechanism/joint.h"

#include <gtest/gtest.h>

#include "random_joints.h"

namespace ugoki {
namespace {

using test::all_joint_types;
using test::Random;

double size(const Vec6& v) { return norm(v.w) + norm(v.v); }
Vec3 unskew(const Mat3& m) { return Vec3{m.zy - m.yz, m.xz - m.zx, m.yx - m.xy} * 0.5; }
double difference(const Pose& a, const Pose& b) {
  const Mat3 e = a.R - b.R;
  return norm(e.row(0)) + norm(e.row(1)) + norm(e.row(2)) + norm(a.p - b.p);
}

/// Velocity of the moving frame B relative to the joint frame J, in B's axes, by central differences of the poses at t - dt, t and t + dt.
Vec6 velocity(const Pose& before, const Pose& now, const Pose& after, double dt) {
  const Mat3 dR = (after.R - before.R) * (0.5 / dt);
  const Vec3 dp = (after.p - before.p) * (0.5 / dt);
  return {unskew(now.R.transposed() * dR), transpose_times(now.R, dp)};
}

TEST(Joint, CountsAndNames) {
  const int nq[] = {0, 1, 1, 1, 2, 3, 2, 4, 7}, nv[] = {0, 1, 1, 1, 2, 3, 2, 3, 6};
  for (std::size_t i = 0; i < all_joint_types.size(); ++i) {
    EXPECT_EQ(position_count(all_joint_types[i]), nq[i]);
    EXPECT_EQ(velocity_count(all_joint_types[i]), nv[i]);
    EXPECT_EQ(joint_type_named(name_of(all_joint_types[i])), all_joint_types[i]);
  }
  EXPECT_EQ(joint_type_named("hinge"), std::nullopt);
  EXPECT_EQ(joint_type_named(""), std::nullopt);
}

TEST(Joint, KnownPoses) {
  Joint j;
  j.type = JointType::revolute;
  const double quarter = pi / 2;
  EXPECT_LT(norm(joint_pose(j, &quarter) * Vec3{1, 0, 0} - Vec3{0, 1, 0}), 1e-15);
  j.type = JointType::prismatic;
  EXPECT_EQ(joint_pose(j, &quarter).p, (Vec3{0, 0, quarter}));
  j.type = JointType::helical;
  j.pitch = 0.1;
  EXPECT_LT(norm(joint_pose(j, &quarter) * Vec3{1, 0, 0} - Vec3{0, 1, 0.1 * quarter}), 1e-15);
  j.type = JointType::cylindrical;
  const double turn_and_slide[] = {quarter, 0.7};
  EXPECT_LT(norm(joint_pose(j, turn_and_slide) * Vec3{1, 0, 0} - Vec3{0, 1, 0.7}), 1e-15);
  j.type = JointType::planar;
  const double plane[] = {3, 4, quarter};
  EXPECT_LT(norm(joint_pose(j, plane) * Vec3{1, 0, 0} - Vec3{3, 5, 0}), 1e-15);
  j.type = JointType::universal;
  const double two[] = {quarter, quarter};  // about z, then about the rotated y
  EXPECT_LT(norm(joint_pose(j, two) * Vec3{1, 0, 0} - Vec3{0, 0, -1}), 1e-15);
  EXPECT_LT(norm(joint_pose(j, two) * Vec3{0, 0, 1} - Vec3{0, 1, 0}), 1e-15);
  j.type = JointType::floating;
  const double h = std::sqrt(0.5), free[] = {1, 2, 3, h, 0, 0, h};
  EXPECT_LT(norm(joint_pose(j, free) * Vec3{1, 0, 0} - Vec3{1, 3, 3}), 1e-15);
}

TEST(Joint, NeutralIsTheIdentity) {
  Random random;
  for (const JointType type : all_joint_types) {
    const Joint j = random.joint(type);
    double q[7] = {9, 9, 9, 9, 9, 9, 9};
    joint_neutral(j, q);
    EXPECT_EQ(difference(joint_pose(j, q), {}), 0) << name_of(type);
    double x[6] = {9, 9, 9, 9, 9, 9};
    joint_displacement(j, q, x);
    for (int i = 0; i < j.nv(); ++i) EXPECT_EQ(x[i], 0) << name_of(type);
  }
}

// Compares S(q) v (S: motion subspace) with the finite difference of the pose while q moves with velocity v.
TEST(Joint, SubspaceIsTheDerivativeOfThePose) {
  Random random;
  const double dt = 1e-5;
  for (const JointType type : all_joint_types) {
    for (int trial = 0; trial < 200; ++trial) {
      const Joint j = random.joint(type);
      double q[7], v[6], before[7], after[7];
      random.coordinates(j, q);
      for (double& x : v) x = random.in(-1, 1);
      joint_integrate(j, q, v, -dt, before);
      joint_integrate(j, q, v, dt, after);
      Vec6 S[6];
      ASSERT_EQ(joint_subspace(j, q, S), j.nv());
      Vec6 V;
      for (int i = 0; i < j.nv(); ++i) V += S[i] * v[i];
      ASSERT_LT(size(V - velocity(joint_pose(j, before), joint_pose(j, q), joint_pose(j, after), dt)), 1e-8) << name_of(type);
    }
  }
}

// Compares the bias (dS/dt) v (S: motion subspace) with the finite difference of S v while q moves with constant v.
TEST(Joint, BiasIsTheDerivativeOfTheSubspace) {
  Random random;
  const double dt = 1e-5;
  for (const JointType type : all_joint_types) {
    for (int trial = 0; trial < 200; ++trial) {
      const Joint j = random.joint(type);
      double q[7], v[6];
      random.coordinates(j, q);
      for (double& x : v) x = random.in(-2, 2);
      const auto velocity_at = [&](double t) {
        double moved[7];
        joint_integrate(j, q, v, t, moved);
        Vec6 S[6], V;
        const int n = joint_subspace(j, moved, S);
        for (int i = 0; i < n; ++i) V += S[i] * v[i];
        return V;
      };
      const Vec6 expected = (velocity_at(dt) - velocity_at(-dt)) * (0.5 / dt);
      ASSERT_LT(size(joint_bias(j, q, v) - expected), 1e-8) << name_of(type);
    }
  }
}

TEST(Joint, DifferenceIsTheInverseOfIntegrate) {
  Random random;
  for (const JointType type : all_joint_types) {
    for (int trial = 0; trial < 500; ++trial) {
      const Joint j = random.joint(type);
      double q0[7], q1[7], v[6], back[7];
      random.coordinates(j, q0);
      random.coordinates(j, q1);
      joint_difference(j, q0, q1, v);
      joint_integrate(j, q0, v, 1, back);
      ASSERT_LT(difference(joint_pose(j, back), joint_pose(j, q1)), 1e-13) << name_of(type);
      // Conversely, joint_difference() recovers the step of joint_integrate() for rotations of less than half a turn.
      double w[6], q2[7], again[6];
      for (double& x : w) x = random.in(-1.7, 1.7);
      joint_integrate(j, q0, w, 1, q2);
      joint_difference(j, q0, q2, again);
      for (int i = 0; i < j.nv(); ++i) ASSERT_NEAR(again[i], w[i], 1e-13) << name_of(type);
    }
  }
}

TEST(Joint, IntegrateIsExactAlongAConstantVelocity) {
  Random random;
  for (const JointType type : all_joint_types) {
    const Joint j = random.joint(type);
    double q[7], v[6], once[7], many[7];
    random.coordinates(j, q);
    for (double& x : v) x = random.in(-1, 1);
    joint_integrate(j, q, v, 1, once);
    std::copy(q, q + 7, many);
    for (int i = 0; i < 1000; ++i) joint_integrate(j, many, v, 1e-3, many);  // output aliases the input
    EXPECT_LT(difference(joint_pose(j, once), joint_pose(j, many)), 1e-12) << name_of(type);
  }
}

TEST(Joint, QuaternionsStayUnit) {
  Random random;
  const Joint j = random.joint(JointType::spherical);
  double q[4] = {1, 0, 0, 0};
  for (int i = 0; i < 100000; ++i) {
    const double v[3] = {random.in(-50, 50), random.in(-50, 50), random.in(-50, 50)};
    joint_integrate(j, q, v, 0.01, q);
  }
  EXPECT_NEAR(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 1, 1e-15);
}

TEST(Joint, DisplacementIsARotationVector) {
  Random random;
  const Joint j = random.joint(JointType::spherical);
  const Vec3 r{0.3, -0.8, 0.5};
  const Quat a = exp_map(r);
  const double q[] = {a.w, a.x, a.y, a.z}, minus[] = {-a.w, -a.x, -a.y, -a.z};
  double x[3], y[3];
  joint_displacement(j, q, x);
  joint_displacement(j, minus, y);  // -q is the same rotation as q
  EXPECT_LT(norm(Vec3{x[0], x[1], x[2]} - r), 1e-15);
  EXPECT_LT(norm(Vec3{y[0], y[1], y[2]} - r), 1e-15);
}

}  // namespace
}  // namespace ugoki
