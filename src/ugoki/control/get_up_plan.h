#pragma once
// Postures through which a body with two arms and two legs gets up from the ground.
//
// The way up from lying on the front, seen from the side; the balls of the feet, the knees and the hands stay on the ground:
//   prone     hands beside the chest, toes tucked under
//   fours     the hands push the body backwards; knees and hips bend
//   kneel     the body sits on its heels, over knees and balls of the feet
//   gather    the hands move close to the knees; the trunk rises
//   rock      hands and hips move the centre of mass back over the balls of the feet; the knees leave the ground
//   squat     the heels land; the centre of mass is over the soles
//   stand     hips and knees stretch
// The support area contains the centre of mass in all of these postures, so that the way can be slow and can wait anywhere. Inverse
// kinematics (pose_finder.h) finds the postures from the dimensions of the body.

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "ugoki/control/body_plan.h"
#include "ugoki/control/foot_schedule.h"

namespace ugoki::control {

/// A posture on the way up.
struct GetUpPosture {
  std::vector<double> q;  ///< [nq] joints; the root is that of the inverse kinematics: balls of the feet at x = 0, facing x
  double time = 0;        ///< s: duration of the motion from the previous posture
  Vec3 centre;            ///< m: centre of mass; the balls of the feet are at x = 0, the ground is at z = 0
  Mat3 root;              ///< orientation of the root link
};

/// Goals of a posture that rolls the body to one side. Directions in the frame of the trunk: x forward, y towards the side to which the
/// body rolls, z towards the head. "Far": the limbs of the other side, which cross over.
struct RollGoals {
  Vec3 far_knee, far_foot, near_knee, near_foot;  ///< from the hip, in lengths of the thigh
  Vec3 far_hand, near_hand;                       ///< from the shoulder, in lengths of the arm
  double twist = 0;                               ///< rad: turn of the chest against the pelvis
  double time = 0.4;                              ///< s
};
inline constexpr int roll_parts = 3;
[[nodiscard]] std::array<RollGoals, roll_parts> usual_roll();

/// Postures of one body.
struct GetUpPlan {
  enum Stage : int { spread, prone, fours, kneel, gather, rock, squat, stand, stage_count };
  std::vector<GetUpPosture> way;      ///< from `prone` to `stand`
  std::vector<int> stage_end;         ///< [stage_count] index in `way` of the last posture of each stage
  std::vector<GetUpPosture> roll[2];  ///< postures that roll the body from its back to the left, the right
  Vec3 ball[2];                       ///< m: ball of each foot, in the frame of the foot's link
  std::vector<double> flat;           ///< [nq] stretched
};

/// Computes the postures. About 0.2 s of processor time. @return nothing if the root does not float or a part is missing
[[nodiscard]] std::optional<GetUpPlan> plan_get_up(const MechanismPtr& mechanism, const BodyPlan& body);
/// Postures of a roll with the given goals. @param from [nq] stretched posture
[[nodiscard]] std::vector<GetUpPosture> plan_roll(const MechanismPtr& mechanism, const BodyPlan& body, std::span<const double> from,
                                                  int side, std::span<const RollGoals> goals);

}  // namespace ugoki::control
