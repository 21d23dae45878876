#pragma once
// Motion for another structure: what one figure does, done by another one of other proportions or another kind.
// docs/design/retargeting.md says how.

#include <functional>
#include <string>
#include <vector>

#include "ugoki/motion/motion.h"
#include "ugoki/retarget/mapping.h"

namespace ugoki::retarget {

struct RetargetOptions {
  Mapping mapping;
  bool keep_contacts = true;  ///< standing feet neither slide nor sink; false: joints only, the root's path scaled
  bool keep_holds = true;     ///< hands that hold each other or something at rest go on holding it
  double path_scale = 0;      ///< of the root's way over the ground; 0: by the length of the legs
  double gait_phase = 0.5;    ///< two legs to four: fore legs follow the hind legs of their side by this share of a stride (0.5: trot)
  bool balance = false;       ///< the centre of mass is kept over the standing feet (for slow motions of robots)
  bool slow_down = false;     ///< the whole motion is slowed until no joint is faster than the mapping allows
  std::function<bool()> cancelled;  ///< asked before each frame; where it says yes, the work ends with an error
};

/// A limb that did not come where it should.
struct Miss {
  std::string link;
  double most = 0;  ///< m
  int frame = -1;   ///< frame of that
  int frames = 0;   ///< in how many it missed by more than 1 mm
};

struct RetargetReport {
  double scale = 1;                          ///< of lengths
  double skate_before = 0, skate_after = 0;  ///< m, longest path of a standing foot over the ground: without and with the feet's goals
  int stances = 0;
  double greatest_shift = 0;  ///< m, by which the root was moved so that the feet reach the ground
  int shift_frame = -1;
  std::vector<Miss> misses;  ///< standing feet and holding hands; only those that miss by more than 1 mm
  double least_margin = 0;   ///< rad | m, nearest that a joint comes to a limit; never negative
  std::string margin_link;
  std::vector<std::pair<std::string, int>> at_limit;  ///< links and in how many frames they are at a limit, most first
  double greatest_speed = 0;                          ///< greatest speed of a joint over what is allowed; 0: nothing is limited
  std::string speed_link;
  double slowed = 1;                 ///< factor by which the motion lasts longer
  std::vector<std::string> holds;    ///< what hands were found to hold, in words
  std::vector<std::string> mapping;  ///< which link drives which, in words
  std::vector<std::string> notes;    ///< what was assumed or left out
};

/// The report for people, a sentence each, without the mapping.
[[nodiscard]] std::vector<std::string> describe(const RetargetReport& report);

struct Retargeted {
  Motion motion;  ///< of the target, with its contacts labelled
  RetargetReport report;
};

/// The motion on another mechanism. Joint limits of the target are kept in every frame.
/// Errors: the motion does not fit its mechanism; no legs are found in one of the two; the target's root does not float; cancelled.
/// O(frames * links).
[[nodiscard]] Result<Retargeted> retarget(MechanismPtr from, const Motion& motion, MechanismPtr to, const RetargetOptions& options = {});

}  // namespace ugoki::retarget
