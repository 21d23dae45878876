#pragma once
// Feet that stand stay where they are: goals for the feet, and inverse kinematics of the limbs that reaches them.

#include <vector>

#include "ugoki/motion_edit/foot_contacts.h"

namespace ugoki::motion_edit {

/// Where a foot is to be, frame by frame.
struct FootPath {
  std::vector<Pose> X_WF;            ///< [frames] pose of the foot's link in the world
  std::vector<std::uint8_t> bears;   ///< [frames] 1 while it stands
  std::vector<SupportPoint> points;  ///< [frames][points of the limb] in the foot's frame: toes move
};

struct FootLockOptions {
  double ease = 0.12;       ///< s in which a correction sets in and ends beside a stance
  double sole = 0.012;      ///< m (leg of 0.9 m): places of a sole this much above its lowest one bear nothing
  double stretch = 0.995;   ///< of the limb's length: it is not straightened beyond this (or beyond what it was), the pelvis sinks instead
  double drop_time = 0.12;  ///< s in which the pelvis sinks and rises
  bool keep_on_ground = true;  ///< the lowest place of a standing foot is brought to the ground, and no foot is left below it
};

/// What was done, for people.
struct FootLockReport {
  SkateReport before, after;
  double greatest_move = 0;  ///< m, by which a foot was moved
  double greatest_drop = 0;  ///< m, by which the pelvis was lowered
  double greatest_miss = 0;  ///< m, by which a standing foot misses its goal: the limb is too short or stopped by a limit
  int miss_frame = -1;       ///< frame of that
  std::string miss_link;     ///< and foot
};

/// The feet's paths as the motion has them. [feet]
[[nodiscard]] std::vector<FootPath> foot_paths(const Mechanism& mechanism, const Motion& motion, const FootContacts& contacts);

/// Paths on which standing feet neither slide nor twist: in each stance the foot rolls, without slipping, over the places of its sole that
/// bear (from heel to toe); the stance as a whole stays where the path had it, and the correction passes evenly into the next one.
/// @param rate frames a second  @param ground m  @param leg m, mean_leg_length
void pin_stances(std::vector<FootPath>& paths, double rate, double ground, double leg, const FootLockOptions& options);

/// Moves the limbs so that the feet are on their paths. Where a limb cannot reach, the root sinks, smoothly. Joint limits of hinges are
/// kept. The mechanism's root must be floating for that. Contacts are labelled as the paths have them.
[[nodiscard]] Motion follow_paths(const Mechanism& mechanism, const Motion& motion, std::span<const FootLimb> feet,
                                  const std::vector<FootPath>& paths, const FootLockOptions& options, FootLockReport* report = nullptr);

/// All three steps. In a cyclic motion stances run on over the seam, and the result is cyclic.
/// Errors: the motion does not fit the mechanism; it has no feet; options that make no sense.
[[nodiscard]] Result<Motion> lock_feet(const Mechanism& mechanism, const Motion& motion, const FootContacts& contacts,
                                       const FootLockOptions& options = {}, FootLockReport* report = nullptr);

}  // namespace ugoki::motion_edit
