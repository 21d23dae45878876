#pragma once
// Changes fields of a mechanism's links: names, joints, inertias, shapes.

#include <span>
#include <string>
#include <string_view>

#include "ugoki/mechanism_edit/edited.h"

namespace ugoki {

/// A field of a link and its new value as text. Values are in SI units (rad, m, kg); several values are separated by commas. Fields:
///   name, label
///   joint.type, joint.axis, joint.axis2, joint.pitch, joint.position, joint.rotation (w,x,y,z)
///   joint.lower, upper, damping, stiffness, rest, armature, friction, effort: of all DOFs, or joint.lower.1 of one DOF, counted from 0;
///     "none" removes a limit or the bound of the effort
///   inertia.mass (moments are scaled by the same factor), inertia.centre (moments about the centre are kept),
///   inertia.about_centre (xx,yy,zz,xy,xz,yz), inertia.density (mass, centre and moments of its shapes as solids of this density, kg/m^3)
///   shapes.friction, shapes.restitution, shapes.collides, shapes.visible (true, false): of all shapes of the link
struct Assignment {
  std::string link, field, value;
};

/// Parses LINK:FIELD=VALUE, for example "shank left:joint.upper=2.4". The link's name may contain colons. Error: no ':' before '='.
[[nodiscard]] Result<Assignment> parse_assignment(std::string_view text);

/// Applies all assignments or none. Errors: every assignment that is not possible, or the problems of the result (Mechanism::make).
[[nodiscard]] Result<Edited> edit(const Mechanism& mechanism, std::span<const Assignment> assignments);

}  // namespace ugoki
