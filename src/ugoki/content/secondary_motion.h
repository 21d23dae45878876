#pragma once
// Secondary motion of a character: tails, hair and other chains that swing on springs (dynamics/spring_chains.h). Internal to content.

#include "ugoki/content/scenario.h"
#include "ugoki/mechanism/mechanism.h"

namespace ugoki::content {

/// Returns the mechanism with the springs of the character's secondary motion; null if the character has none.
/// @param q0 [nq] pose of the character at time 0
[[nodiscard]] Result<MechanismPtr> with_secondary_motion(const ScenarioCharacter& c, const Mechanism& mechanism, std::span<const double> q0,
                                                         const Scenario& scenario);

}  // namespace ugoki::content
