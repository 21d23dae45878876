#pragma once
// Left and right exchanged.

#include <string>
#include <vector>

#include "ugoki/motion/motion.h"

namespace ugoki::motion_edit {

/// For each link the one on the other side, itself in the middle. By names and labels (left and right, l and r in their usual spellings);
/// where these tell nothing, by the places of the joints in the neutral position against the plane of symmetry through the root.
/// @return [links]
[[nodiscard]] std::vector<int> find_mirror_links(const Mechanism& mechanism);

/// The motion mirrored at the vertical plane through the root along its heading in the first frame, so that it begins at the same place and
/// in the same direction. Mirrored twice it is the motion again, to rounding. Errors: the motion does not fit; a joint whose partner is of
/// another type or turns about an axis that is not its mirror image.
[[nodiscard]] Result<Motion> mirror(const Mechanism& mechanism, const Motion& motion);

}  // namespace ugoki::motion_edit
