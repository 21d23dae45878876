#pragma once
// Motions of clips with their keyed layers applied.

#include <string>

#include "ugoki/content/generate.h"
#include "ugoki/content/scenario.h"

namespace ugoki::content {

/// A document whose clips have no layers, with the motions that they play instead.
struct LayeredContent {
  Scenario scenario;
  Resources resources;
};

/// Replaces the motion of each clip that has active layers by a new motion, to which the layers are applied. The id of a new motion is "l-"
/// and a hash of the original id and the layers, so that equal clips share one motion. Clips whose motion or mechanism is unknown keep
/// their layers.
/// Errors: those of motion_edit::apply_layers().
/// O(frames * keyed joints)
[[nodiscard]] Result<LayeredContent> apply_layers(const Scenario& scenario, const Resources& resources);

/// The motion of one clip with its layers applied; the original if no layer is active.
[[nodiscard]] Result<MotionPtr> layered_motion(const ScenarioClip& clip, const Mechanism& mechanism, const MotionPtr& motion);

}  // namespace ugoki::content
