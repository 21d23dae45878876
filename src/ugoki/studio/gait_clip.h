#pragma once
// Clips whose motion is a gait that was made from a recipe (docs/studio-protocol.md, "gait"). Independent of project and library.

#include <atomic>

#include "ugoki/studio/motion_edits.h"

namespace ugoki::studio {

/// A gait that is to be made.
struct GaitRequest {
  MechanismPtr mechanism;
  content::ScenarioClip clip;  ///< the clip that plays the gait, with its recipe
  MotionPtr old;               ///< motion that the clip has played so far; null: a new clip
  double gravity = 9.81;       ///< m/s^2
  const std::atomic<bool>* cancelled = nullptr;
};

/// Makes the motion. In the result, the recipe of the clip has the speeds and the duration that were used. A clip that played its old
/// motion to the end plays the new one to the end; another keeps its length if the new motion is long enough. Errors: unknown kinds or
/// styles; those of gait::make_gait.
[[nodiscard]] Result<EditedMotion> make_gait_clip(const GaitRequest& request);

/// What can be made for a mechanism: {"legs", "kinds", "styles"}. Errors: as gait::kinds_of.
[[nodiscard]] Result<json::Json> describe_gaits(const MechanismPtr& mechanism);

}  // namespace ugoki::studio
