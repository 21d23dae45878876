#pragma once
// Joint of each link: type from the measured DOFs and motion, limits, passive properties. Internal to body.

#include <optional>
#include <string>
#include <vector>

#include "ugoki/body/anatomy.h"
#include "ugoki/body/body.h"

namespace ugoki::body {

/// Returns the simplest joint that reproduces the measured rotation of joint `i`: fixed, revolute, universal or spherical; floating for
/// roots. Limits and passive properties are not set.
/// @param strict true: a hinge must preserve the positions of all its descendants; false: only of its children, because joints further
///               down compensate the error
/// @param zero rotation of the joint's frame in its parent's at which the DOFs of the file are zero; identity if the file's rest pose is
/// used
/// @param report receives a sentence if the joint's position shifts
[[nodiscard]] Joint fit_joint(const MeasuredMotion& motion, int i, const BodyOptions& options, bool strict, const Mat3& zero,
                              std::vector<std::string>& report);

/// Computes the coordinates with which the joint rotates its link by R_PB relative to the parent link; for hinges and universal joints
/// the closest rotation they allow.
/// @param previous [nq] coordinates of the previous frame or null; angles and quaternion signs are chosen close to them
/// @param q [nq, out]
void find_coordinates(const Joint& joint, const Mat3& R_PB, const double* previous, double* q);

/// Sets limits (the file's, otherwise human ranges), damping, stiffness, armature and effort of a movable joint from its body part.
/// @param source the skeleton's joint `i` @param mass kg, of the whole body
void set_joint_properties(Joint& joint, const Anatomy& anatomy, const SkeletonJoint& source, int i, double mass);

/// The motion with the offsets of its skeleton corrected where they contradict its frames: a joint with a bone to its parent that all
/// frames hold at one place of the parent, far from its offset, gets that place as its offset. (The rest pose of a skin can have ends of
/// bones elsewhere than the motion. A joint at its parent has no bone, as the footsteps of 3ds Max under the hips.)
/// @return nothing if no offset changes
[[nodiscard]] std::optional<MeasuredMotion> with_measured_offsets(const MeasuredMotion& motion);

}  // namespace ugoki::body
