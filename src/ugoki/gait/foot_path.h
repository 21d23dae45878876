#pragma once
// Poses of the feet: stances in which the foot rolls from heel to toe without slipping, and swings between them. Internal to gait.

#include "ugoki/gait/course.h"

namespace ugoki::gait {

struct FootPose {
  Pose X_WF;        ///< pose of the foot's link
  Vec3 pivot;       ///< m, in the frame of the foot: the point of a standing sole that does not move
  double toes = 0;  ///< rad: pitch of the toes relative to the foot, negative: up
  Vec3 pressure;    ///< m: wanted centre of pressure; used while the foot stands
};

/// Pose of the foot of a leg in a frame.
[[nodiscard]] FootPose foot_pose(const Walker& walker, const GaitOptions& options, const Course& course, std::size_t leg, int frame);

/// Phase of a leg, 0 (touch-down) to 1.
[[nodiscard]] inline double phase_of(const LegFrame& leg) {
  return leg.stands ? leg.share * leg.duty : leg.duty + leg.share * (1 - leg.duty);
}

}  // namespace ugoki::gait
