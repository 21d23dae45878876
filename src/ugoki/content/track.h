#pragma once
// From the clips of a scenario's track to clips that are laid on the floor.

#include <vector>

#include "ugoki/content/generate.h"
#include "ugoki/content/scenario.h"
#include "ugoki/motion/clip.h"

namespace ugoki::content {

/// A clip's timing, not yet placed.
[[nodiscard]] Clip to_clip(const ScenarioClip& clip);

/// Where a character stands at the start; heading in rad.
[[nodiscard]] Placement to_placement(const ScenarioPlace& place);

/// The clips of the track in order of start: the first where the character stands, each other one where the one before
/// leaves off. The motions must be there and fit the mechanism.
[[nodiscard]] std::vector<Clip> lay_track(const ScenarioCharacter& character, const Mechanism& mechanism, const Resources& resources);

/// How fast the track still moves the figure where it ends, m/s of the root link; 0 where it stands, or has no track. After its end a
/// track holds its last pose, so a figure that arrives there quickly cannot help falling. Missing motions count as standing.
[[nodiscard]] double calc_end_speed(const ScenarioCharacter& character, const Mechanism& mechanism, const Resources& resources);

/// Position at time 0: of the first clip at its start, or neutral where the character stands. @param track as laid
[[nodiscard]] std::vector<double> start_position(const ScenarioCharacter& character, const Mechanism& mechanism,
                                                 const std::vector<Clip>& track, const Resources& resources);

}  // namespace ugoki::content
