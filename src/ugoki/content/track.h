#pragma once
// Converts the clips of a scenario's track to clips that are placed in the world.

#include <vector>

#include "ugoki/content/generate.h"
#include "ugoki/content/scenario.h"
#include "ugoki/motion/clip.h"

namespace ugoki::content {

/// Converts the timing and blending of a clip; does not set its placement in the world.
[[nodiscard]] Clip to_clip(const ScenarioClip& clip);

/// Returns the planar pose of a character at the start; the heading is converted from degrees to rad.
[[nodiscard]] Placement to_placement(const ScenarioPlace& place);

/// Returns a mechanism whose root is neither floating nor planar, for example a robot that is bolted to the floor, at this place in the
/// world; other mechanisms, which their coordinates place, as they are.
[[nodiscard]] MechanismPtr place_root(const MechanismPtr& mechanism, const Placement& place);

/// Returns the placed clips of the track, sorted by start. The first clip begins where the character is placed at the start, each later
/// clip at the planar pose that the previous clip has at this time. `resources` must contain the motions, and they must fit the mechanism.
[[nodiscard]] std::vector<Clip> lay_track(const ScenarioCharacter& character, const Mechanism& mechanism, const Resources& resources);

/// Returns the speed [m/s] of the root link at the end of the track. After its end, a track holds its last pose, so a character that
/// reaches the end at high speed falls. 0 if the track is empty, a motion is missing, or the root joint is not floating.
[[nodiscard]] double calc_end_speed(const ScenarioCharacter& character, const Mechanism& mechanism, const Resources& resources);

/// Returns position coordinates [nq] at time 0: the pose of the first clip or, without a track, the neutral pose at the character's place.
/// @param track result of lay_track()
[[nodiscard]] std::vector<double> start_position(const ScenarioCharacter& character, const Mechanism& mechanism,
                                                 const std::vector<Clip>& track, const Resources& resources);

}  // namespace ugoki::content
