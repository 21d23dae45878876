#pragma once
// Writer of mechanisms as UsdPhysics. Internal to publish.

#include <set>
#include <span>
#include <string>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki::publish {

/// Returns a name that USD allows (letters, digits and _; no digit first) and that is not yet in `used`.
[[nodiscard]] std::string usd_name(const std::string& name, std::set<std::string>& used);

/// Returns a prim of type Xform below </Content> with an articulation root, a rigid body for each link (mass, inertia, collision shapes),
/// and a joint for each joint and loop; floating roots have no joint. Of the limits, those of revolute and prismatic joints are written.
/// Not written: springs, dampers, gear and distance loops, meshes, height fields, coupling of rotation and translation of helical joints.
/// @param poses [links] poses of the links in the world in the first frame, m @param name USD name of the prim
[[nodiscard]] std::string usda_physics(const Mechanism& mechanism, std::span<const Pose> poses, const std::string& name);

}  // namespace ugoki::publish
