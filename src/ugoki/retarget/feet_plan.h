#pragma once
// Where the feet of the target go: their ends' paths from the source's, stances pinned to the ground.

#include <span>
#include <vector>

#include "ugoki/motion_edit/foot_lock.h"
#include "ugoki/retarget/driver.h"

namespace ugoki::retarget {

/// One limb that stands.
struct FootPlan {
  int limb = -1;
  motion_edit::FootPath raw;   ///< as the source goes
  motion_edit::FootPath path;  ///< with standing feet that stay where they are
  std::vector<Vec3> from_hip;  ///< [frames] m, led place seen from the hip
  std::vector<Mat3> turn;      ///< [frames]
  std::vector<double> miss;    ///< [frames] m, after the solution
};

/// Contacts of the source's limbs [limbs][frames], empty where a limb does not stand: as the motion labels them, otherwise detected.
/// @param ground m, out: height on which it stands; 0 if it is near that
[[nodiscard]] std::vector<std::vector<std::uint8_t>> source_contacts(const Rig& rig, const Motion& motion, double& ground);

/// Feet of another kind: level while they stand, hanging a little while they swing.
void flatten(FootPlan& plan, const Mat3& F, double rate);

/// Feet that cannot stand as long as the source's do (fore paws while the figure turns on the spot): where a stance would be dragged over
/// more than a share of the leg's length, the foot steps instead.
/// @param length m, of the leg
void step_where_dragged(FootPlan& plan, double rate, double length);

/// Shifts a foot's part of the motion by a share of a stride. @param frames of delay; earlier frames are repeated
void delay(FootPlan& plan, std::vector<std::uint8_t>& bears, int frames);
/// Median time between a foot's landings, in frames; 0: it lands less than twice.
[[nodiscard]] int stride_of(std::span<const std::uint8_t> bears);

/// Longest horizontal path [m] of the lowest place in one stance. @param stances out: added to
[[nodiscard]] double path_skate(const motion_edit::FootPath& path, int& stances);

}  // namespace ugoki::retarget
