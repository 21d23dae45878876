#pragma once
// Mechanisms and motions as the page lists and draws them.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/mechanism/mechanism.h"
#include "ugoki/motion/motion.h"

namespace ugoki::studio {

/// Links with shapes for display: the answer of GET /api/mechanism/ID.
[[nodiscard]] std::string mechanism_json(std::string_view id, const Mechanism& mechanism);

/// From the lowest to the highest point of the visible shapes in the neutral position, m; 0 without shapes.
[[nodiscard]] double shown_height(const Mechanism& mechanism);

/// At most 48 numbers between 0 and 1: the coordinate that moves most, over the motion's time. The root's travel does not
/// count where anything else moves. Empty if nothing does.
[[nodiscard]] std::vector<double> thumbnail_curve(const Motion& motion, const Mechanism& mechanism);

}  // namespace ugoki::studio
