#pragma once
// A jump made by hand as keys of the height. The keys ignore dynamics.

#include "../motion_edit/characters.h"

namespace ugoki::correction {

/// A jump of an animator: smooth keys of the height of a standing person, with gravity and forces as they happen to be. Limbs follow.
/// @param take_off, landing s  @param apex m above the standing posture
[[nodiscard]] Motion keyed_jump(const motion_edit::Character& standing, double take_off, double landing, double apex);

}  // namespace ugoki::correction
