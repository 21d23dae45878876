#pragma once
// Joints and inertias of a mechanism, changed one field at a time.

#include <span>
#include <string>
#include <string_view>

#include "ugoki/mechanism_edit/edited.h"

namespace ugoki {

/// A field of a link and its new value, as text. Fields, in SI units (rad, m, kg), several numbers separated by commas:
///   name, label
///   joint.type, joint.axis, joint.axis2, joint.pitch, joint.position, joint.rotation (w,x,y,z)
///   joint.lower, upper, damping, stiffness, rest, armature, friction, effort: of all freedoms, or joint.lower.1 of one, counted from 0;
///     "none" takes a limit or the effort's bound away
///   inertia.mass (moments follow, so that the density's distribution is kept), inertia.centre (moments about it are kept),
///   inertia.about_centre (xx,yy,zz,xy,xz,yz), inertia.density (mass, centre and moments of its shapes filled with kg/m^3)
///   shapes.friction, shapes.restitution, shapes.collides, shapes.visible (true, false): of all its shapes
struct Assignment {
  std::string link, field, value;
};

/// "shank left:joint.upper=2.4"; the link's name may hold colons. An Error where there is no ':' before '='.
[[nodiscard]] Result<Assignment> parse_assignment(std::string_view text);

/// Does all or none; reports every assignment that cannot be done, and whatever makes the result impossible (Mechanism::make).
[[nodiscard]] Result<Edited> edit(const Mechanism& mechanism, std::span<const Assignment> assignments);

}  // namespace ugoki
