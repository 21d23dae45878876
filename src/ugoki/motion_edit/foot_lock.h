#pragma once
// Foot lock: removes the sliding of standing feet. It computes goal poses of the feet and reaches them by inverse kinematics of the limbs.

#include <vector>

#include "ugoki/motion_edit/foot_contacts.h"

namespace ugoki::motion_edit {

/// Goal poses of a foot, frame by frame.
struct FootPath {
  std::vector<Pose> X_WF;            ///< [frames] pose of the foot's link in the world
  std::vector<std::uint8_t> bears;   ///< [frames] 1 while the foot is in contact
  std::vector<SupportPoint> points;  ///< [frames][points of the limb] in the frame of the foot's link; toes can move these points
};

struct FootLockOptions {
  double ease = 0.12;       ///< s before and after a stance in which the correction fades in and out
  double sole = 0.012;      ///< m for a leg of 0.9 m: points this far above the lowest point of the sole carry no load
  double stretch = 0.995;   ///< maximum extension as a fraction of the limb's length (or the source's extension, if larger); beyond it the
                            ///< pelvis is lowered
  double drop_time = 0.12;  ///< s in which the pelvis is lowered, and in which it is raised again
  bool keep_on_ground = true;  ///< move the lowest point of a standing foot to the ground, and keep every foot above the ground
};

/// Summary of a foot lock, for display.
struct FootLockReport {
  SkateReport before, after;
  double max_move = 0;    ///< m, maximum displacement of a foot
  double max_drop = 0;    ///< m, maximum lowering of the pelvis
  double max_miss = 0;    ///< m, maximum distance of a standing foot from its goal: limb too short or joint limit reached
  int miss_frame = -1;    ///< frame of max_miss; -1: none
  std::string miss_link;  ///< name of the foot with the distance max_miss
};

/// Returns the paths of the feet in the motion, one for each foot.
[[nodiscard]] std::vector<FootPath> foot_paths(const Mechanism& mechanism, const Motion& motion, const FootContacts& contacts);

/// Frames in which a standing foot turns about a vertical axis (find_turns). @param rate frames per second
[[nodiscard]] std::vector<std::uint8_t> turning_frames(const FootPath& path, double rate);

/// Changes the paths so that standing feet neither slide nor twist. In each stance the foot rolls without slipping over the loaded points
/// of its sole, from heel to toe. The mean position and heading of each stance are kept. A foot that turns about a vertical axis
/// (find_turns) moves as before, because its pivot is not known. Between stances the correction is interpolated.
/// @param rate frames per second  @param ground m, height of the ground  @param leg m, mean_leg_length
void pin_stances(std::vector<FootPath>& paths, double rate, double ground, double leg, const FootLockOptions& options);

/// Distance [m] by which the root can rise before the limb of `foot`, whose end is at `goal` [m, world], is extended to `limit` [m];
/// negative: the root must be lowered by it. @param X [links] poses in the world
[[nodiscard]] double headroom(const FootLimb& foot, const Vec3& goal, std::span<const Pose> X, double limit);

/// Moves the limbs so that the feet follow their paths. If a limb is too short, the root is lowered smoothly; this needs a floating root.
/// Limits of hinges are respected. The result's contact labels come from the paths.
[[nodiscard]] Motion follow_paths(const Mechanism& mechanism, const Motion& motion, std::span<const FootLimb> feet,
                                  const std::vector<FootPath>& paths, const FootLockOptions& options, FootLockReport* report = nullptr);

/// Locks the standing feet: foot_paths, pin_stances, follow_paths. In a cyclic motion stances continue across the seam, and the result is
/// cyclic. Errors: the motion does not fit the mechanism; no feet; options out of range.
[[nodiscard]] Result<Motion> lock_feet(const Mechanism& mechanism, const Motion& motion, const FootContacts& contacts,
                                       const FootLockOptions& options = {}, FootLockReport* report = nullptr);

}  // namespace ugoki::motion_edit
