#pragma once
// Between the axes, units and rates of measured-data files and those of Ugoki. Internal to formats.

#include <string>
#include <string_view>

#include "ugoki/motion/skeleton.h"

namespace ugoki::formats {

/// Axes of a file. With Y up: file Z forward -> our X, file X left -> our Y, file Y up -> our Z, a rotation of the
/// axes, so that handedness and the order of rotations stay. With Z up: taken as they are.
struct FileAxes {
  bool z_up = false;

  /// Index of our axis along which file axis i (0 x, 1 y, 2 z) points.
  [[nodiscard]] int ours(int i) const { return z_up ? i : (i + 1) % 3; }
  [[nodiscard]] Vec3 unit(int i) const {
    Vec3 e;
    e[ours(i)] = 1;
    return e;
  }
  [[nodiscard]] Vec3 from_file(const Vec3& v) const { return z_up ? v : Vec3{v.z, v.x, v.y}; }
  [[nodiscard]] Vec3 to_file(const Vec3& v) const { return z_up ? v : Vec3{v.y, v.z, v.x}; }
};

/// The unit that makes `extent` (the largest size of a skeleton at rest, in file units) most like a person's.
struct UnitGuess {
  double metres = 1;
  std::string name;
  bool plausible = false;  ///< the size comes out between 1 m and 2.5 m
};
[[nodiscard]] UnitGuess guess_unit(double extent);

/// Largest side of the box around all joints and end sites at rest.
[[nodiscard]] double rest_extent(const Skeleton& skeleton);

/// Frames a second of a file that writes its frame time as `text` = `frame_time` [s]: the usual rate (24, 25, 30, 60,
/// 120, 29.97 ...) or else whole number whose frame time the text may be a rounding or cut of, otherwise 1 / frame_time.
[[nodiscard]] double rate_of(double frame_time, std::string_view text);

}  // namespace ugoki::formats
