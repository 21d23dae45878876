#pragma once
// Turns the clips of a scenario's track into clips that are placed in the world.

#include <vector>

#include "ugoki/content/generate.h"
#include "ugoki/content/scenario.h"
#include "ugoki/motion/clip.h"

namespace ugoki::content {

/// Converts the timing and blending of a clip; its placement in the world is not set.
[[nodiscard]] Clip to_clip(const ScenarioClip& clip);

/// The planar pose of a character at the start; heading converted from degrees to rad.
[[nodiscard]] Placement to_placement(const ScenarioPlace& place);

/// The placed clips of the track, sorted by start. The first is placed where the character is at the start, each later clip at the planar
/// pose that the previous clip has when the later clip starts. `resources` must contain the motions, and they must fit the mechanism.
[[nodiscard]] std::vector<Clip> lay_track(const ScenarioCharacter& character, const Mechanism& mechanism, const Resources& resources);

/// Speed of the root link at the end of the track, m/s. After its end, a track holds its last pose; a character that reaches the end at
/// high speed therefore falls. 0 if the track is empty, a motion is missing, or the root joint is not floating.
[[nodiscard]] double calc_end_speed(const ScenarioCharacter& character, const Mechanism& mechanism, const Resources& resources);

/// [nq] Position coordinates at time 0: the first clip's pose, or without a track the neutral pose at the character's place.
/// @param track result of lay_track()
[[nodiscard]] std::vector<double> start_position(const ScenarioCharacter& character, const Mechanism& mechanism,
                                                 const std::vector<Clip>& track, const Resources& resources);

}  // namespace ugoki::content
