#pragma once
// Operations on the motion of a clip, as requested by a page (docs/studio-protocol.md, "motion"). From options and motions they compute a
// new motion, the clip's new settings and a report as text. Independent of project and library.

#include <atomic>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/content/scenario.h"
#include "ugoki/json/json.h"
#include "ugoki/motion/motion.h"

namespace ugoki::studio {

/// A clip of the scenario with the motion that it plays.
struct ClipMotion {
  content::ScenarioClip clip;
  MotionPtr motion;
};

/// An operation on a motion, with its inputs.
struct MotionEdit {
  std::string operation;  ///< name of the operation, for example "mirror"
  json::Json options = json::Json::object();
  MechanismPtr mechanism;                        ///< mechanism that the edited motion moves
  ClipMotion target;                             ///< the clip whose motion is edited
  ClipMotion next;                               ///< `join`: the next clip on the track; motion null: there is none
  MotionPtr other;                               ///< `mix`, `layer`, `blend`: the second motion
  MechanismPtr other_mechanism;                  ///< mechanism of `other`
  MechanismPtr body;                             ///< `retarget`: mechanism of the new motion
  const std::atomic<bool>* cancelled = nullptr;  ///< if another thread sets it, long operations end soon with an error; may be null
};

/// The result of an operation on a motion.
struct EditedMotion {
  std::string label;  ///< label of the undo step, for example "Mirror motion"
  Motion motion;
  content::ScenarioClip clip;       ///< the clip with new settings; its motion id is still that of the old motion
  std::vector<std::string> report;  ///< sentences for the user about what was done
};

/// The additional input that an operation needs.
enum class Needs { nothing, next_clip, other_motion, body };
/// The additional input that `operation` needs. Errors: there is no such operation.
[[nodiscard]] Result<Needs> needs_of(std::string_view operation);

/// Runs an operation. Errors: unknown operation, invalid options, or an error of the operation itself.
[[nodiscard]] Result<EditedMotion> edit_motion(const MotionEdit& edit);

/// The section of the motion that the clip shows, as a separate motion at the same frame rate. It contains the repetitions of a loop and
/// plays at the clip's speed. The root keeps the position at which the motion was recorded.
[[nodiscard]] Result<Motion> bake_clip(const Mechanism& mechanism, const ClipMotion& shown);

}  // namespace ugoki::studio
