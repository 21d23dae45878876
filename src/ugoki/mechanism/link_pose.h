#pragma once
// Pose of a link from that of its parent, X_WB = (X_WP X_PJ) X_JB(q). Parts of the product that do not change a number are left out: joint
// frames are mostly parallel to their link, and most joints either rotate or do not move. All functions that compute poses of links use
// these two, so that the poses have the same bits.

#include <cstring>

#include "ugoki/mechanism/joint.h"

namespace ugoki {

/// Pose X_WJ = X_WP X_PJ of a joint frame.
inline Pose joint_frame_pose(const Pose& X_WP, const Pose& X_PJ) {
  static constexpr Mat3 parallel = Mat3::identity();
  if (std::memcmp(&X_PJ.R, &parallel, sizeof parallel) == 0) return {X_WP.R, X_WP * X_PJ.p};
  return X_WP * X_PJ;
}

/// Pose X_WB = X_WJ X_JB(q) of a link. @param q [nq of the joint]
inline Pose link_pose(const Pose& X_WJ, const Joint& joint, const double* q) {
  switch (joint.type) {
    case JointType::fixed: return X_WJ;
    case JointType::revolute: return {X_WJ.R * rotation_about(joint.axis, q[0]), X_WJ.p};
    case JointType::spherical: return {X_WJ.R * to_matrix(Quat{q[0], q[1], q[2], q[3]}), X_WJ.p};
    default: return X_WJ * joint_pose(joint, q);
  }
}

}  // namespace ugoki
