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
  motion_edit::FootPath raw;   ///< path that follows the source's foot; stances are not fixed to the ground
  motion_edit::FootPath path;  ///< `raw`, corrected so that the standing foot is fixed to the ground
  std::vector<Vec3> from_hip;  ///< [frames] m, end point relative to the hip, world axes
  std::vector<Mat3> turn;      ///< [frames] orientation of the end link in the world
  std::vector<double> miss;    ///< [frames] m, distance of the end point from the path after inverse kinematics
};

/// Returns the contacts of the source's limbs [limbs][frames]: from the motion's labels, otherwise detected. Empty for limbs that never
/// stand. @param ground [out] m, estimated height of the ground; exactly 0 if its absolute value is below 4 % of the hips' height
[[nodiscard]] std::vector<std::vector<std::uint8_t>> source_contacts(const Rig& rig, const Motion& motion, double& ground);

/// Levels a foot in stance and reduces its tilt in swing. Used if source and target feet are of different kinds.
/// @param F anatomical axes of the foot in the end link's frame @param rate frames/s
void flatten(FootPlan& plan, const Mat3& F, double rate);

/// Splits stances in which the foot would be dragged over more than 0.2 of the leg's length into several stances with steps between them.
/// Example: the fore paws of a character that turns on the spot.
/// @param length m, length of the leg
void step_where_dragged(FootPlan& plan, double rate, double length);

/// Delays the foot's plan and its contacts by `frames`; the first frame is repeated.
void delay(FootPlan& plan, std::vector<std::uint8_t>& bears, int frames);
/// Median time between successive landings of a foot, in frames; 0 if the foot lands less than twice.
[[nodiscard]] int stride_of(std::span<const std::uint8_t> bears);

/// Longest horizontal path [m] of the foot's lowest point in one stance. @param stances increased by the number of stances
[[nodiscard]] double path_skate(const motion_edit::FootPath& path, int& stances);

}  // namespace ugoki::retarget
