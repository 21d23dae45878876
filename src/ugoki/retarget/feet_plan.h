#pragma once
// Paths of the target's feet: derived from the source's feet, with stances fixed to the ground.

#include <span>
#include <vector>

#include "ugoki/motion_edit/foot_lock.h"
#include "ugoki/retarget/driver.h"

namespace ugoki::retarget {

/// Planned motion of one limb that can stand on the ground.
struct FootPlan {
  int limb = -1;
  motion_edit::FootPath raw;   ///< as the source moves
  motion_edit::FootPath path;  ///< the same with standing feet fixed to the ground
  std::vector<Vec3> from_hip;  ///< [frames] m, end point relative to the hip, world axes
  std::vector<Mat3> turn;      ///< [frames] orientation of the end link
  std::vector<double> miss;    ///< [frames] m, distance of the end point from the path after inverse kinematics
};

/// Contacts of the source's limbs [limbs][frames]: the motion's labels, otherwise detected. Empty for limbs that do not stand.
/// @param ground m, out: height of the ground; 0 if it is within 4 % of the hips' height of 0
[[nodiscard]] std::vector<std::vector<std::uint8_t>> source_contacts(const Rig& rig, const Motion& motion, double& ground);

/// For feet of another kind: levels the foot in stance and keeps a share of the source's tilt in swing.
/// @param F anatomical axes of the foot in its frame @param rate frames/s
void flatten(FootPlan& plan, const Mat3& F, double rate);

/// Splits stances in which the foot would be dragged over more than 0.2 of the leg's length into several stances with steps between them.
/// Example: fore paws of a character that turns on the spot.
/// @param length m, of the leg
void step_where_dragged(FootPlan& plan, double rate, double length);

/// Delays the foot's plan and its contacts. @param frames of delay; the first frame is repeated
void delay(FootPlan& plan, std::vector<std::uint8_t>& bears, int frames);
/// Median time between a foot's landings, in frames; 0 if it lands less than twice.
[[nodiscard]] int stride_of(std::span<const std::uint8_t> bears);

/// Longest horizontal path [m] of the foot's lowest point in one stance. @param stances incremented by the number of stances
[[nodiscard]] double path_skate(const motion_edit::FootPath& path, int& stances);

}  // namespace ugoki::retarget
