#pragma once
// Conversion of axes, units and frame rates of motion-capture files to those of Ugoki, and back. Internal to formats.

#include <string>
#include <string_view>

#include "ugoki/motion/skeleton.h"

namespace ugoki::formats {

/// Axes of a file. Ugoki's axes ("ours") are X forward, Y left, Z up. Y up: file Z (forward) -> our X, file X (left) -> our Y, file Y (up)
/// -> our Z. This is a cyclic permutation: handedness and the order of rotations do not change. Z up: the file's axes equal ours.
struct FileAxes {
  bool z_up = false;  ///< true: Z up, X forward; false: Y up, Z forward

  /// Index of our axis along which file axis i (0 x, 1 y, 2 z) points.
  [[nodiscard]] int ours(int i) const { return z_up ? i : (i + 1) % 3; }
  /// Unit vector along file axis i, in our axes.
  [[nodiscard]] Vec3 unit(int i) const {
    Vec3 e;
    e[ours(i)] = 1;
    return e;
  }
  [[nodiscard]] Vec3 from_file(const Vec3& v) const { return z_up ? v : Vec3{v.z, v.x, v.y}; }
  [[nodiscard]] Vec3 to_file(const Vec3& v) const { return z_up ? v : Vec3{v.y, v.z, v.x}; }
};

/// A guessed unit of length.
struct UnitGuess {
  double metres = 1;  ///< m per file unit
  std::string name;
  bool plausible = false;  ///< true if the skeleton's size in this unit is between 1 m and 2.5 m
};
/// Guesses the unit in which `extent` is closest (in ratio) to the height of a person, 1.7 m.
/// @param extent largest size of a skeleton at rest, file units; 0 or not finite: the result is centimetres, not plausible
[[nodiscard]] UnitGuess guess_unit(double extent);

/// Largest side [the skeleton's unit] of the axis-aligned box around all joints and end sites at rest.
[[nodiscard]] double rest_extent(const Skeleton& skeleton);

/// Returns the frames per second of a file that gives its frame time as `text`, parsed as `frame_time` [s]. Files round or truncate the
/// frame time ("0.0083333" for 120 frames per second). Candidates are, in this order, the usual rates (24, 25, 30, 60 ...), the video rates
/// (29.97 ...) and the closest integer. The first candidate whose frame time agrees with the written digits is returned; if no candidate
/// agrees, 1 / frame_time.
[[nodiscard]] double rate_of(double frame_time, std::string_view text);

}  // namespace ugoki::formats
