#pragma once
// What is found in the finished motion: margins to the limits, speeds, sliding. Internal to retarget.

#include "ugoki/retarget/driver.h"
#include "ugoki/retarget/retarget.h"

namespace ugoki::retarget {

/// Fills the report's margins, speeds and skate, and slows the motion down if that is wished.
void find_facts(const Rig& target, const Driver& driver, const RetargetOptions& options, Retargeted& result);

}  // namespace ugoki::retarget
