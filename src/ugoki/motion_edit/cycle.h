#pragma once
// Makes a cyclic motion from a measured one: one stride of a gait, or one period of another repeating motion.

#include "ugoki/motion_edit/foot_lock.h"

namespace ugoki::motion_edit {

struct CycleOptions {
  int first = -1, last = -1;  ///< first and last frame of the cycle; -1: found by find_cycle
  double shortest = 0.35;     ///< s, minimum duration in the search
  double longest = 3;         ///< s, maximum duration in the search
  double ease = 0.15;         ///< s before and after the seam (last to first frame) over which the velocity difference is removed
  bool lock_feet = true;      ///< lock the feet (motion_edit::lock_feet) after the motion is made cyclic
  double level = 0.06;        ///< m for a leg of 0.9 m, scaled with leg length: if the feet are at most this far above or below the ground,
                              ///< the motion is moved vertically onto the ground
  FootContactOptions contacts;
  FootLockOptions lock;
};

struct CycleReport {
  int first = 0, last = 0;   ///< first and last frame of the cycle in the source motion
  double seam = 0;           ///< rad (1 m counts as 1 rad), RMS over the DOFs of the difference between first and last frame
  bool by_contacts = false;  ///< true: the cycle is a stride (touch-down to touch-down); false: from one frame to a similar one
  double raised = 0;         ///< m, upward displacement that put the feet on the ground
  FootLockReport feet;
};

/// Finds the best cycle of the motion: the stride whose first and last frame are most similar in position and velocity. A stride lasts from
/// one touch-down of a foot to its next, with one touch-down of each other foot in between. In a motion without strides, the cycle lasts
/// from one frame to the most similar later frame.
/// @return first and last frame of the cycle
/// Errors: the motion is too short, or no cycle is between options.shortest and options.longest.
[[nodiscard]] Result<Stance> find_cycle(const Mechanism& mechanism, const Motion& motion, const FootContacts& contacts,
                                        const CycleOptions& options, CycleReport* report = nullptr);

/// Returns one cycle of the motion, in which the last frame equals the first frame displaced over the ground by the root's displacement.
/// The pose difference between first and last frame is spread evenly over the cycle; the velocity difference is spread over the time
/// CycleOptions::ease before and after the seam. If the motion is already cyclic, only the feet are locked.
/// Errors: the motion does not fit the mechanism; no cycle is found; given frames are not in the motion.
[[nodiscard]] Result<Motion> make_cyclic(const Mechanism& mechanism, const Motion& motion, const CycleOptions& options = {},
                                         CycleReport* report = nullptr);

}  // namespace ugoki::motion_edit
