#pragma once
// Loops of a closed link system: conditions between two links, or between two freedoms, beyond the tree of joints.
//
// Frame J_A is fixed in link a, frame J_B in link b. Rows of the condition, with p = the position of J_B in J_A and R its rotation:
//
//   type         rows  condition
//   weld           6   p = 0, R = 1
//   ball           3   p = 0
//   revolute       5   p = 0, axis of A along axis of B
//   prismatic      5   p along the axis, R = 1
//   cylindrical    4   p along the axis, axis of A along axis of B
//   planar         3   p at a right angle to the axis, axis of A along axis of B
//   universal      4   p = 0, axis of A at a right angle to axis2 of B
//   distance       1   |p| = length
//   gear           1   x_a = c0 + c1 x_b + ... + c4 x_b^4 of the coordinates of two freedoms (not of spherical or floating joints)

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "ugoki/spatial/spatial.h"

namespace ugoki {

enum class LoopType : std::uint8_t { weld, ball, revolute, prismatic, cylindrical, planar, universal, distance, gear };

[[nodiscard]] int row_count(LoopType type);
/// How many of the rows are about positions; they come first, the others are about rotations.
[[nodiscard]] int position_row_count(LoopType type);
[[nodiscard]] std::string_view name_of(LoopType type);
[[nodiscard]] std::optional<LoopType> loop_type_named(std::string_view name);

/// A loop as people write it: it names its links. (As it runs: `Loop`.)
struct LoopSpec {
  std::string name = {};
  LoopType type = LoopType::weld;
  std::string link_a = {};                             ///< empty: the world
  std::string link_b = {};                             ///< empty: the world
  Pose X_AJ = {};                                      ///< J_A in link a
  Pose X_BJ = {};                                      ///< J_B in link b
  Vec3 axis = {0, 0, 1};                               ///< unit, the same numbers in J_A and in J_B
  Vec3 axis2 = {0, 1, 0};                              ///< unit, in J_B (universal)
  double length = 0;                                   ///< m (distance), above zero
  int freedom_a = 0, freedom_b = 0;                    ///< gear: which freedom of the joint of link a, of link b
  std::array<double, 5> polynomial = {0, 1, 0, 0, 0};  ///< gear: c0 ... c4, in the units of the two freedoms
  bool closed = true;                                  ///< false: open at the start, to be closed while running
};

/// A loop as it runs. Link indices are -1 for the world.
struct Loop {
  std::string name = {};
  LoopType type = LoopType::weld;
  int link_a = -1, link_b = -1;
  Pose X_AJ = {}, X_BJ = {};
  Vec3 axis = {}, axis2 = {};
  double length = 0;
  int freedom_a = 0, freedom_b = 0;  ///< gear: indices into v
  std::array<double, 5> polynomial{};
  bool closed = true;
  bool of_virtual_link = false;  ///< made from link b, a virtual link, and its real link a

  [[nodiscard]] int rows() const { return row_count(type); }
};

}  // namespace ugoki
