#pragma once
// Changes the frames of links and the root of a tree. Internal to mechanism_edit.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki {

/// Index of the link in spec.links; -1 if there is none. O(links)
[[nodiscard]] int find_link(const MechanismSpec& spec, std::string_view name);

/// Changes the frame of link `index`: converts its inertia, its shapes, the joint frames of its children and the loop frames on it to the
/// new frame. The link's own joint is not changed.
/// @param X_LN pose of the new frame in the present one
void move_link_frame(MechanismSpec& spec, int index, const Pose& X_LN);

/// Returns the inverse joint, which places the parent in the link: X'(q') = X_JB(q)^-1, with X_PJ = 1. Its coordinates are q' = q
/// (universal joints: in the opposite order). For planar, spherical and floating joints, q' describes the inverse displacement.
/// @param lost [out] describes properties that the inverse cannot have; unchanged if there are none
[[nodiscard]] Joint reversed(const Joint& joint, std::string& lost);

/// Reroots the tree at `link`, which gets a fixed joint to the world. The joints between the link and the old root are reversed, and the
/// joint of the old root to the world is dropped. A link whose former child becomes its parent gets the frame of the joint between them.
/// Mass, shapes, loops and the possible relative poses are kept. @param report [in and out] sentences about dropped parts
void make_root(MechanismSpec& spec, int link, std::vector<std::string>& report);

/// World pose of every link of the spec in the neutral position. Links may be in any order; parents must not form a cycle. [links]
[[nodiscard]] std::vector<Pose> neutral_poses(const MechanismSpec& spec);

}  // namespace ugoki
