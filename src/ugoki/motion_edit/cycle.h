#pragma once
// A cyclic motion made of a measured one: one stride of a gait, one round of whatever repeats.

#include "ugoki/motion_edit/foot_lock.h"

namespace ugoki::motion_edit {

struct CycleOptions {
  int first = -1, last = -1;  ///< frames of the cycle; -1: found
  double shortest = 0.35;     ///< s, of a cycle that is searched for
  double longest = 3;         ///< s
  double ease = 0.15;         ///< s beside the seam in which the difference of velocities goes
  bool lock_feet = true;      ///< feet are locked afterwards
  double level = 0.06;        ///< m (leg of 0.9 m): a motion whose feet stand at most this far above or below the ground is set down on it
  FootContactOptions contacts;
  FootLockOptions lock;
};

struct CycleReport {
  int first = 0, last = 0;   ///< frames of the source
  double seam = 0;           ///< rad, root mean square over the joints, of the difference between the two frames
  bool by_contacts = false;  ///< the cycle is a stride from one touch-down of a foot to the next; otherwise where the poses are most alike
  double raised = 0;         ///< m, by which the motion was raised to stand on the ground
  FootLockReport feet;
};

/// The best cycle of the motion: the stride (touch-down to touch-down of the same foot, each other foot landing once between) whose ends
/// are most alike in position and velocity; without strides the two frames that are. @return first and last frame
/// Errors: the motion is too short, or nothing in it repeats.
[[nodiscard]] Result<Stance> find_cycle(const Mechanism& mechanism, const Motion& motion, const FootContacts& contacts,
                                        const CycleOptions& options, CycleReport* report = nullptr);

/// One cycle of the motion: the last frame is the first one, moved over the ground by what the root moved in the cycle. The difference
/// between the ends is spread evenly over the cycle, that of their velocities over `ease` beside the seam. A motion that is cyclic
/// already is only locked.
/// Errors: the motion does not fit the mechanism; no cycle; frames that it does not have.
[[nodiscard]] Result<Motion> make_cyclic(const Mechanism& mechanism, const Motion& motion, const CycleOptions& options = {},
                                         CycleReport* report = nullptr);

}  // namespace ugoki::motion_edit
