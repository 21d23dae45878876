#pragma once
// Loops of a closed link system: constraints between two links, or between two DOFs, in addition to the tree of joints.
//
// Frame J_A is fixed in link a, J_B in link b; p, R: position and rotation of J_B in J_A. Axis of A (of B): LoopSpec::axis in J_A (in J_B).
//
//   type         rows  constraint
//   weld           6   p = 0, R = 1
//   ball           3   p = 0
//   revolute       5   p = 0, axis of A parallel to axis of B
//   prismatic      5   p parallel to the axis, R = 1
//   cylindrical    4   p parallel to the axis, axis of A parallel to axis of B
//   planar         3   p perpendicular to the axis, axis of A parallel to axis of B
//   universal      4   p = 0, axis of A perpendicular to axis2 of B
//   distance       1   |p| = length
//   gear           1   x_a = c0 + c1 x_b + ... + c4 x_b^4 for the coordinates x_a, x_b of two DOFs (not of spherical or floating joints)

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "ugoki/spatial/spatial.h"

namespace ugoki {

enum class LoopType : std::uint8_t { weld, ball, revolute, prismatic, cylindrical, planar, universal, distance, gear };

[[nodiscard]] int row_count(LoopType type);
/// Number of rows that constrain positions. These rows come first; the other rows constrain rotations.
[[nodiscard]] int position_row_count(LoopType type);
[[nodiscard]] std::string_view name_of(LoopType type);
[[nodiscard]] std::optional<LoopType> loop_type_named(std::string_view name);

/// A loop in the editable description: refers to links by name. (`Loop` is the run-time form.)
struct LoopSpec {
  std::string name = {};
  LoopType type = LoopType::weld;
  std::string link_a = {};                             ///< empty: the world
  std::string link_b = {};                             ///< empty: the world
  Pose X_AJ = {};                                      ///< pose of J_A in link a
  Pose X_BJ = {};                                      ///< pose of J_B in link b
  Vec3 axis = {0, 0, 1};                               ///< unit, same components in J_A and in J_B
  Vec3 axis2 = {0, 1, 0};                              ///< unit, in J_B; only for the type universal
  double length = 0;                                   ///< m, above zero; only for the type distance
  int dof_a = 0, dof_b = 0;                            ///< gear: index of the DOF (from 0) within the joint of link a, link b
  std::array<double, 5> polynomial = {0, 1, 0, 0, 0};  ///< gear: c0 ... c4, in the units of the two DOFs
  bool closed = true;                                  ///< false: inactive at the start; can be closed at run time
};

/// A loop in the run-time form. A link index of -1 is the world. The other fields have the same meaning as in LoopSpec.
struct Loop {
  std::string name = {};
  LoopType type = LoopType::weld;
  int link_a = -1, link_b = -1;
  Pose X_AJ = {}, X_BJ = {};
  Vec3 axis = {}, axis2 = {};
  double length = 0;
  int dof_a = 0, dof_b = 0;  ///< gear: velocity indices (in v) of the two DOFs
  std::array<double, 5> polynomial{};
  bool closed = true;
  bool of_virtual_link = false;  ///< true: generated from a virtual link (link b) and its real link (link a)

  [[nodiscard]] int rows() const { return row_count(type); }
};

}  // namespace ugoki
