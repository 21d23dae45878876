#include "ugoki/posing/pose_edit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "ugoki/mechanism/state.h"
#include "ugoki/samples/samples.h"

namespace ugoki::posing {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

class PoseEditTest : public testing::Test {
 protected:
  int labelled(const std::string& label) const {
    for (int i = 0; i < m.link_count(); ++i)
      if (m.link(i).label == label) return i;
    ADD_FAILURE() << "no link " << label;
    return 0;
  }
  Pose pose(int link) const {
    std::vector<Pose> X(at(m.link_count()));
    calc_poses(m, q, X);
    return X[at(link)];
  }
  std::vector<double> angles(int link) const {
    double x[6];
    joint_displacement(m.link(link).joint, q.data() + m.link(link).q_index, x);
    return {x, x + m.link(link).joint.nv()};
  }
  /// Links whose joint coordinates differ from `before`.
  std::vector<int> moved(const std::vector<double>& before) const {
    std::vector<int> out;
    for (int i = 0; i < m.link_count(); ++i) {
      double v[6];
      joint_difference(m.link(i).joint, before.data() + m.link(i).q_index, q.data() + m.link(i).q_index, v);
      for (int k = 0; k < m.link(i).joint.nv(); ++k)
        if (std::fabs(v[k]) > 1e-9) {
          out.push_back(i);
          break;
        }
    }
    return out;
  }

  MechanismPtr person = samples::make_person(1.75).value();
  const Mechanism& m = *person;
  std::vector<double> q = m.neutral();
};

TEST_F(PoseEditTest, TurnMovesOneJointAndStopsAtItsLimit) {
  const int knee = labelled("shank left");
  const std::vector<double> before = q;
  const Dof& dof = m.link(knee).joint.dofs[0];
  const Vec3 axis = m.link(knee).joint.axis;
  const double inside = 0.5 * (dof.lower + dof.upper);
  ASSERT_TRUE(edit_pose(m, TurnEdit{knee, axis, inside}, {}, q));
  EXPECT_EQ(moved(before), std::vector<int>{knee});
  EXPECT_NEAR(angles(knee)[0], inside, 1e-12);
  q = before;
  ASSERT_TRUE(edit_pose(m, TurnEdit{knee, axis, 3}, {}, q));
  EXPECT_DOUBLE_EQ(angles(knee)[0], std::min(3.0, dof.upper));
  q = before;
  ASSERT_TRUE(edit_pose(m, TurnEdit{knee, axis, 3}, {{}, false}, q));
  EXPECT_NEAR(angles(knee)[0], 3, 1e-12) << "without limits";
}

TEST_F(PoseEditTest, SetGivesTheAngleWithinTheLimits) {
  const int thigh = labelled("thigh right");
  for (int dof = 0; dof < m.link(thigh).joint.nv(); ++dof) {
    const Dof& limits = m.link(thigh).joint.dofs[at(dof)];
    ASSERT_TRUE(edit_pose(m, SetEdit{thigh, dof, 0.1}, {}, q));
    EXPECT_NEAR(angles(thigh)[at(dof)], 0.1, 1e-9);
    ASSERT_TRUE(edit_pose(m, SetEdit{thigh, dof, 99}, {}, q));
    EXPECT_NEAR(angles(thigh)[at(dof)], limits.upper, 1e-9);
  }
}

TEST_F(PoseEditTest, ReachOfALimbMovesOnlyThisLimb) {
  const int hand = labelled("hand left");
  const std::vector<double> before = q;
  const Vec3 target = pose(hand).p + Vec3{0.2, -0.15, -0.2};
  ASSERT_TRUE(edit_pose(m, ReachEdit{hand, {}, target, Reach::limb}, {}, q));
  EXPECT_LT(norm(pose(hand).p - target), 5e-3);
  const std::vector<int> limb = limb_of(m, hand);
  EXPECT_GE(limb.size(), 3u);
  EXPECT_EQ(limb.back(), hand);
  for (const int link : moved(before)) EXPECT_NE(std::find(limb.begin(), limb.end(), link), limb.end()) << m.link(link).name;
}

TEST_F(PoseEditTest, ReachOfTheBodyGoesFartherThanTheArm) {
  const int hand = labelled("hand left"), foot = labelled("foot left"), other = labelled("foot right");
  const Pose left = pose(foot), right = pose(other);
  const Vec3 target = pose(hand).p + Vec3{0.25, 0.12, -0.3};  // farther than the stretched arm reaches
  std::vector<double> arm = q;
  ASSERT_TRUE(edit_pose(m, ReachEdit{hand, {}, target, Reach::body}, {{foot, other}}, q));
  const double with_body = norm(pose(hand).p - target);
  EXPECT_LT(with_body, 0.01);
  EXPECT_LT(norm(pose(foot).p - left.p), 0.01);
  EXPECT_LT(norm(pose(other).p - right.p), 0.01);
  std::swap(arm, q);
  ASSERT_TRUE(edit_pose(m, ReachEdit{hand, {}, target, Reach::limb}, {}, q));
  EXPECT_GT(norm(pose(hand).p - target), with_body);
}

TEST_F(PoseEditTest, PinnedFeetStayWhileTheThighTurns) {
  const int thigh = labelled("thigh left"), left = labelled("foot left"), right = labelled("foot right");
  ASSERT_TRUE(edit_pose(m, ReachEdit{0, {}, pose(0).p + Vec3{-0.03, 0, -0.1}, Reach::body}, {{left, right}}, q));
  const Vec3 at_left = pose(left).p, at_right = pose(right).p;
  const std::vector<double> bent = q;
  const std::vector<double> before = angles(thigh);
  ASSERT_TRUE(edit_pose(m, TurnEdit{thigh, {0, 1, 0}, -0.12}, {{left, right}}, q));
  EXPECT_LT(norm(pose(left).p - at_left), 8e-3);
  EXPECT_LT(norm(pose(right).p - at_right), 8e-3);
  const std::vector<double> turned = angles(thigh);
  q = bent;
  ASSERT_TRUE(edit_pose(m, TurnEdit{thigh, {0, 1, 0}, -0.12}, {}, q));
  EXPECT_GT(norm(pose(left).p - at_left), 0.05) << "without pins the foot moves";
  EXPECT_EQ(angles(thigh), turned) << "the pins do not change the turned joint";
  EXPECT_NE(turned, before);
}

TEST_F(PoseEditTest, MirrorTwiceGivesTheSamePose) {
  ASSERT_TRUE(edit_pose(m, SetEdit{labelled("upper arm left"), 0, 0.4}, {}, q));
  ASSERT_TRUE(edit_pose(m, SetEdit{labelled("shank right"), 0, 0.5}, {}, q));
  const std::vector<double> before = q;
  ASSERT_TRUE(edit_pose(m, MirrorEdit{}, {}, q));
  EXPECT_NEAR(angles(labelled("shank left"))[0], angles(labelled("shank right"))[0] + 0.5, 0.5);
  EXPECT_FALSE(moved(before).empty());
  ASSERT_TRUE(edit_pose(m, MirrorEdit{}, {}, q));
  EXPECT_TRUE(moved(before).empty());
}

TEST_F(PoseEditTest, BlendMovesTheGivenLinksByItsShare) {
  const int knee = labelled("shank left");
  std::vector<double> other = q;
  std::swap(q, other);
  ASSERT_TRUE(edit_pose(m, SetEdit{knee, 0, 0.8}, {}, q));
  ASSERT_TRUE(edit_pose(m, SetEdit{labelled("shank right"), 0, 0.8}, {}, q));
  std::swap(q, other);
  ASSERT_TRUE(edit_pose(m, BlendEdit{other, {knee}, 0.25}, {}, q));
  EXPECT_NEAR(angles(knee)[0], 0.2, 1e-12);
  EXPECT_EQ(angles(labelled("shank right"))[0], 0);
}

TEST_F(PoseEditTest, RefusesLinksAndDofsThatDoNotExist) {
  const std::vector<double> before = q;
  for (const PoseEdit& edit :
       {PoseEdit(TurnEdit{-1, {1, 0, 0}, 1}), PoseEdit(SetEdit{999, 0, 1}), PoseEdit(SetEdit{labelled("shank left"), 1, 1}),
        PoseEdit(ReachEdit{m.link_count(), {}, {}, Reach::limb}), PoseEdit(BlendEdit{{1, 2}, {0}, 1})}) {
    const Result<void> done = edit_pose(m, edit, {}, q);
    ASSERT_FALSE(done);
    EXPECT_FALSE(done.error().problems[0].remedy.empty());
  }
  EXPECT_FALSE(edit_pose(m, MirrorEdit{}, {{-3}}, q));
  EXPECT_EQ(q, before);
}

}  // namespace
}  // namespace ugoki::posing
