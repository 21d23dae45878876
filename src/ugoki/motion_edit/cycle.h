#pragma once
// Makes a cyclic motion from a measured one: one stride of a gait, or one period of another repeating motion.

#include "ugoki/motion_edit/foot_lock.h"

namespace ugoki::motion_edit {

struct CycleOptions {
  int first = -1, last = -1;  ///< first and last frame of the cycle; -1: searched for
  double shortest = 0.35;     ///< s, minimum duration in the search
  double longest = 3;         ///< s, maximum duration in the search
  double ease = 0.15;         ///< s before and after the seam over which the difference of velocities is removed
  bool lock_feet = true;      ///< lock the feet afterwards (lock_feet)
  double level = 0.06;        ///< m for a leg of 0.9 m, scaled with leg length: if the feet stand at most this far above or below the
                              ///< ground, the motion is moved vertically onto the ground
  FootContactOptions contacts;
  FootLockOptions lock;
};

struct CycleReport {
  int first = 0, last = 0;   ///< frames of the source motion
  double seam = 0;           ///< rad, root mean square over the DOFs of the difference between first and last frame
  bool by_contacts = false;  ///< true: a stride between two touch-downs of a foot; false: the two frames that are most alike
  double raised = 0;         ///< m, vertical displacement that put the feet on the ground
  FootLockReport feet;
};

/// Finds the best cycle of the motion: the stride whose ends are most alike in position and velocity. A stride lasts from one touch-down of
/// a foot to its next, with one touch-down of each other foot in between. Without strides: the two frames that are most alike.
/// @return first and last frame
/// Errors: the motion is too short, or no cycle is between options.shortest and options.longest.
[[nodiscard]] Result<Stance> find_cycle(const Mechanism& mechanism, const Motion& motion, const FootContacts& contacts,
                                        const CycleOptions& options, CycleReport* report = nullptr);

/// Returns one cycle of the motion, in which the last frame equals the first frame displaced over the ground by the root's displacement.
/// The pose difference between the ends is spread evenly over the cycle, the velocity difference over `ease` next to the seam. If the
/// motion is already cyclic, only the feet are locked.
/// Errors: the motion does not fit the mechanism; no cycle is found; given frames are not in the motion.
[[nodiscard]] Result<Motion> make_cyclic(const Mechanism& mechanism, const Motion& motion, const CycleOptions& options = {},
                                         CycleReport* report = nullptr);

}  // namespace ugoki::motion_edit
