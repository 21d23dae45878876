#pragma once
// Operations on the motion of a clip, as a page asks for them (docs/studio-protocol.md, "motion"): from options and motions to a new
// motion, how the clip plays it, and what was done in words. Knows neither project nor library.

#include <atomic>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/content/scenario.h"
#include "ugoki/json/json.h"
#include "ugoki/motion/motion.h"

namespace ugoki::studio {

/// A clip with its motion.
struct ClipMotion {
  content::ScenarioClip clip;
  MotionPtr motion;
};

struct MotionEdit {
  std::string operation;
  json::Json options = json::Json::object();
  MechanismPtr mechanism;  ///< whose motion it is
  ClipMotion of;
  ClipMotion next;  ///< `join`: the clip after it; motion null: there is none
  MotionPtr other;  ///< `mix`, `layer`, `blend`: the second motion
  MechanismPtr other_mechanism;
  MechanismPtr body;                             ///< `retarget`: for whom
  const std::atomic<bool>* cancelled = nullptr;  ///< may be set by another thread: long work then ends soon, with an error
};

struct EditedMotion {
  std::string label;  ///< "Mirror motion"
  Motion motion;
  content::ScenarioClip clip;       ///< how the clip plays it; its motion's id is still the old one
  std::vector<std::string> report;  ///< what was done, in sentences
};

/// What an operation needs beside the clip.
enum class Needs { nothing, next_clip, other_motion, body };
/// Errors: there is no such operation.
[[nodiscard]] Result<Needs> needs_of(std::string_view operation);

/// Errors: options out of range; whatever the operation itself refuses.
[[nodiscard]] Result<EditedMotion> edit_motion(const MotionEdit& edit);

/// What the clip shows as a motion of its own, at the motion's frame rate: rounds of a loop and the clip's speed are in it. The root stands
/// where the motion was recorded.
[[nodiscard]] Result<Motion> bake_clip(const Mechanism& mechanism, const ClipMotion& shown);

}  // namespace ugoki::studio
