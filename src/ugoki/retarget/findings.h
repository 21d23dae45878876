#pragma once
// Measurements on the finished motion: margins to joint limits, speeds, sliding feet. Internal to retarget.

#include "ugoki/retarget/driver.h"
#include "ugoki/retarget/retarget.h"

namespace ugoki::retarget {

/// Fills the report's joint margins, speeds and foot sliding. With options.slow_down, also slows the motion to the allowed joint speeds.
void complete_report(const Rig& target, const Driver& driver, const RetargetOptions& options, Retargeted& result);

}  // namespace ugoki::retarget
