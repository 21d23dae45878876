#pragma once
// Column names of the coordinates q of a mechanism. Internal to formats.

#include <string>
#include <vector>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki::formats {

/// Column of one coordinate.
struct CsvCoordinate {
  enum class Kind { angle, length, quaternion } kind = Kind::angle;
  std::string name;
};

/// The columns of all coordinates, in the order of q [nq]. Names by joint type:
///   revolute, helical, prismatic   "link"
///   cylindrical                    "link.angle", "link.distance"
///   planar                         "link.x", "link.y", "link.angle"
///   universal                      "link.angle1", "link.angle2"
///   spherical                      "link.qw", "link.qx", "link.qy", "link.qz"
///   floating                       "link.x", "link.y", "link.z", "link.qw", "link.qx", "link.qy", "link.qz"
[[nodiscard]] std::vector<CsvCoordinate> csv_coordinates(const Mechanism& mechanism);

}  // namespace ugoki::formats
