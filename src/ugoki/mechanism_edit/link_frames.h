#pragma once
// Other frames for links and another root for a tree; internal to mechanism_edit.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki {

/// Index of the link in spec.links; -1 if there is none. O(links)
[[nodiscard]] int find_link(const MechanismSpec& spec, std::string_view name);

/// Gives link `index` another frame: what is fixed in it (inertia, shapes, joints of its children, ends of loops) is written in the new
/// one. Its own joint is left as it is. @param X_LN new frame in the link's present one
void move_link_frame(MechanismSpec& spec, int index, const Pose& X_LN);

/// The joint that places the parent in the link, as its inverse: X'(q') = X_JB(q)^-1, with X_PJ = 1. The coordinates of all types but
/// planar, spherical and floating are q' = q, of universal joints in the opposite order. @return a sentence if something was lost
[[nodiscard]] Joint reversed(const Joint& joint, std::string& lost);

/// Turns the tree of the link round, so that the link is its root, with a fixed joint to the world; the joints between it and the old
/// root are reversed, and the old root's joint to the world is dropped. Links that get a parent that was their child get the
/// frame of the joint between them. Mass, shapes, loops and the set of relative poses stay.
void make_root(MechanismSpec& spec, int link, std::vector<std::string>& report);

/// Pose of every link of the spec in the world in the neutral position. Any order of links; no circle of parents.
[[nodiscard]] std::vector<Pose> neutral_poses(const MechanismSpec& spec);

}  // namespace ugoki
