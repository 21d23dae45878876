#pragma once
// The joint of each link: its type from the measured freedoms and movement, its limits, its passive behaviour.

#include <string>
#include <vector>

#include "ugoki/body/anatomy.h"
#include "ugoki/body/body.h"

namespace ugoki::body {

/// The simplest joint that reproduces the measured movement of joint `i`: fixed, revolute, universal, spherical; floating
/// for roots. Limits and passive properties are not set.
/// @param strict a hinge must keep all positions below it; otherwise those of its children, because joints further on are
///               turned so as to undo what the hinge cannot do
[[nodiscard]] Joint fit_joint(const MeasuredMotion& motion, int i, const BodyOptions& options, bool strict,
                              std::vector<std::string>& report);

/// Coordinates of a joint that turns its link by R_PB against the parent link. For universal joints and hinges: the
/// nearest turn. @param previous [nq] coordinates of the frame before (or nullptr), to which angles and signs are kept close
/// @param q [nq, out]
void find_coordinates(const Joint& joint, const Mat3& R_PB, const double* previous, double* q);

/// Limits (the file's, or human ranges), damping, stiffness and effort of a joint that moves, by the part it carries.
/// @param mass kg of the whole body
void set_joint_properties(Joint& joint, const Anatomy& anatomy, const SkeletonJoint& source, int i, double mass);

}  // namespace ugoki::body
