#pragma once
// Mirroring of a motion: exchanges left and right.

#include <string>
#include <vector>

#include "ugoki/motion/motion.h"

namespace ugoki::motion_edit {

/// Finds the mirrored partner of each link on the other side; a link in the middle is its own partner. Uses names and labels (left and
/// right, l and r in their usual spellings); otherwise the positions of the joints in the neutral position, mirrored at the x-z plane
/// through the root.
/// @return [links] index of the partner
[[nodiscard]] std::vector<int> find_mirror_links(const Mechanism& mechanism);

/// Returns the motion mirrored at the vertical plane through the root along its heading in the first frame, so that start position and
/// heading are kept. Mirroring twice gives the original motion within rounding. Errors: the motion does not fit the mechanism; a joint
/// whose partner has another type, or whose axis is not the mirror image of the partner's axis.
[[nodiscard]] Result<Motion> mirror(const Mechanism& mechanism, const Motion& motion);

}  // namespace ugoki::motion_edit
