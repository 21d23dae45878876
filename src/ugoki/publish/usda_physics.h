#pragma once
// Mechanisms as UsdPhysics. Internal to publish.

#include <set>
#include <span>
#include <string>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki::publish {

/// A name that USD allows (letters, digits and _; no digit first) and that is not in `used` yet.
[[nodiscard]] std::string usd_name(const std::string& name, std::set<std::string>& used);

/// A prim of type Xform below </Content>, with a rigid body for each link (mass, inertia, collision shapes), a joint for each joint and
/// loop, and an articulation root. Floating roots have no joint. Joint limits are written; springs, dampers, gears and distance loops are
/// not, nor the collision shapes of meshes and height fields. Helical joints lose the coupling of rotation and translation.
/// @param poses [links] m, world: poses of the links in the first frame @param name of the prim, a USD name
[[nodiscard]] std::string usda_physics(const Mechanism& mechanism, std::span<const Pose> poses, const std::string& name);

}  // namespace ugoki::publish
