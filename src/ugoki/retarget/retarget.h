#pragma once
// Retargeting: transfers the motion of one character to another one with other proportions or of another kind (for example a quadruped).
// docs/design/retargeting.md describes the method.

#include <functional>
#include <string>
#include <vector>

#include "ugoki/motion/motion.h"
#include "ugoki/retarget/mapping.h"

namespace ugoki::retarget {

struct RetargetOptions {
  Mapping mapping;
  bool keep_contacts =
      true;                ///< standing feet neither slide nor sink; false: joints are mapped and the root's path is scaled, nothing else
  bool keep_holds = true;  ///< hands that hold each other or a fixed object keep holding it
  double path_scale = 0;   ///< scale of the root's horizontal path; 0: ratio of the leg lengths
  double gait_phase =
      0.5;                 ///< biped to quadruped: delay of each fore leg behind the hind leg of its side, fraction of a stride (0.5: trot)
  bool balance = false;    ///< shift the root sideways so that the centre of mass stays over the standing feet (slow robot motions)
  bool slow_down = false;  ///< slow the whole motion down until all joints keep the speed limits of the mapping
  std::function<bool()> cancelled;  ///< called before each frame; true ends the work with ErrorCode::cancelled
};

/// A limb whose end point did not reach its goal.
struct Miss {
  std::string link;
  double maximum = 0;  ///< m, largest distance from the goal
  int frame = -1;      ///< frame of the largest distance
  int frames = 0;      ///< number of frames in which the distance exceeds 1 mm
};

/// Measurements on a retargeted motion, and the assumptions that were made.
struct RetargetReport {
  double scale = 1;                          ///< ratio of lengths, target over source
  double skate_before = 0, skate_after = 0;  ///< m, longest path of a foot over the ground in one stance: without and with foot lock
  int stances = 0;                           ///< number of stances of all feet
  double max_shift = 0;                      ///< m, largest displacement of the root that was needed for the feet to reach the ground
  int shift_frame = -1;                      ///< frame of max_shift
  std::vector<Miss> misses;                  ///< standing feet and holding hands that miss their goal by more than 1 mm
  double min_margin = 0;                     ///< rad | m, smallest distance between a joint and its limit; infinite if no joint is limited
  std::string margin_link;                   ///< link of min_margin
  bool margin_turns = true;                  ///< min_margin is an angle, rad; else a length, m
  std::vector<std::pair<std::string, int>> at_limit;  ///< (link, number of frames at a limit), sorted by this number, largest first
  double max_speed = 0;                               ///< largest ratio of a joint's speed to its speed limit; 0: no limits
  std::string speed_link;                             ///< link of max_speed
  double slowed = 1;                                  ///< factor by which slow_down increased the duration; 1: not slowed down
  std::vector<std::string> holds;                     ///< sentences about the holds that were found
  std::vector<std::string> mapping;                   ///< which source link drives which target links, for display
  std::vector<std::string> notes;                     ///< sentences about assumptions and omissions
};

/// The report as sentences for display, without the mapping.
[[nodiscard]] std::vector<std::string> describe(const RetargetReport& report);

/// Result of retarget.
struct Retargeted {
  Motion motion;  ///< motion of the target, with contact labels
  RetargetReport report;
};

/// Transfers `motion` from mechanism `from` to mechanism `to`. Joint limits of the target are kept in every frame.
/// Errors: the motion does not fit its mechanism; one of the mechanisms has no recognizable legs; the target's root does not float;
/// the mapping names unknown links; cancelled.
/// O(frames * links).
[[nodiscard]] Result<Retargeted> retarget(MechanismPtr from, const Motion& motion, MechanismPtr to, const RetargetOptions& options = {});

}  // namespace ugoki::retarget
