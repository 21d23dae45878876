#include "ugoki/studio/recorded_joints.h"

#include <gtest/gtest.h>

#include <random>

namespace ugoki::studio {
namespace {

/// The kinematics of each type of joint, and the displacement computed from its pose, are inverse.
TEST(RecordedJoints, DisplacementOfAPoseIsThatOfTheCoordinates) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-1.4, 1.4);
  for (const JointType type : {JointType::fixed, JointType::revolute, JointType::prismatic, JointType::helical, JointType::cylindrical,
                               JointType::planar, JointType::universal, JointType::spherical}) {
    for (int round = 0; round < 20; ++round) {
      Joint joint;
      joint.type = type;
      joint.X_PJ = {rotation_about({0.6, 0, 0.8}, number(random)), {number(random), number(random), number(random)}};
      joint.axis = rotation_about({1, 0, 0}, number(random)) * Vec3{0, 0, 1};
      joint.axis2 = rotation_about({1, 0, 0}, number(random)) * Vec3{0, 1, 0};
      joint.pitch = 0.1;
      double q[7] = {}, v[6], expected[6] = {};
      joint_neutral(joint, q);
      for (double& x : v) x = number(random);
      joint_integrate(joint, q, v, 1, q);
      joint_displacement(joint, q, expected);
      const std::array<double, 6> found = displacement_of(joint, joint.X_PJ * joint_pose(joint, q));
      for (std::size_t k = 0; k < static_cast<std::size_t>(joint.nv()); ++k) EXPECT_NEAR(found[k], expected[k], 1e-9) << name_of(type);
    }
  }
}

TEST(RecordedJoints, UnwrapRemovesJumpsOfAFullTurn) {
  std::vector<double> angles = {3.0, -3.1, -2.9, 3.1, 0.5};
  unwrap(angles);
  const double turn = 6.283185307179586;
  EXPECT_NEAR(angles[1], turn - 3.1, 1e-12);
  EXPECT_NEAR(angles[2], turn - 2.9, 1e-12);
  EXPECT_NEAR(angles[3], 3.1, 1e-12);
  EXPECT_NEAR(angles[4], 0.5, 1e-12);
}

}  // namespace
}  // namespace ugoki::studio
