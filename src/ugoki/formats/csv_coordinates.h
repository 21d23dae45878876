#pragma once
// Names of the coordinates of a mechanism as columns; internal to formats.

#include <string>
#include <vector>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki::formats {

struct CsvCoordinate {
  enum class Kind { angle, length, quaternion } kind = Kind::angle;
  std::string name;
};

/// One for each place of q, in its order: "link" for a joint with one coordinate; "link.angle" and "link.distance" of cylindrical,
/// "link.x", "link.y", "link.angle" of planar, "link.angle1", "link.angle2" of universal joints, "link.x" ... "link.qw", "link.qx" ... of
/// floating ones.
[[nodiscard]] std::vector<CsvCoordinate> csv_coordinates(const Mechanism& mechanism);

}  // namespace ugoki::formats
