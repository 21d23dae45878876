#pragma once
// Corrections of an imported file: axes, unit of length and frame rate, if the reader guessed wrong.

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/motion/markers.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::intake {

/// A signed coordinate axis of a file's space.
struct FileAxis {
  int axis = 0;  ///< 0 x, 1 y, 2 z
  bool negative = false;
  friend bool operator==(const FileAxis&, const FileAxis&) = default;
};
/// Parses "x", "-y" ...; std::nullopt for any other text.
[[nodiscard]] std::optional<FileAxis> file_axis_named(std::string_view name);
/// "x", "-y" ...
[[nodiscard]] std::string name_of(const FileAxis& axis);

/// Up and forward axes of a file's right-handed space. Ugoki's space has Z up and X forward.
struct Orientation {
  FileAxis up{1, false}, forward{2, false};
  /// Up and forward are different axes.
  [[nodiscard]] bool valid() const { return up.axis != forward.axis; }
  friend bool operator==(const Orientation&, const Orientation&) = default;
};
/// Orientation that the readers assume: Z up, X forward (z_up) or Y up, Z forward.
[[nodiscard]] Orientation usual_orientation(bool z_up);
/// Rotation from the file's space to Ugoki's (X forward, Z up). @param file must be valid()
[[nodiscard]] Mat3 rotation_to_ours(const Orientation& file);

/// Rotates the motion and its skeleton by R. At rest all joint frames stay parallel to the world.
void turn(MeasuredMotion& motion, const Mat3& R);
/// Rotates the markers and the corners of the force plates by R.
void turn(MarkerMotion& motion, const Mat3& R);
/// Multiplies all lengths by `factor`.
void scale(MeasuredMotion& motion, double factor);
/// Removes carrier roots: joints above the real root that only carry it ("reference", "armature"). If the only root begins a chain without
/// branches, and some joint of the chain is measured to translate relative to its parent, then that joint becomes the root. World poses of
/// the remaining joints do not change.
/// @param motions all on the same skeleton
/// @return names of the removed joints
std::vector<std::string> remove_carrier_roots(std::span<MeasuredMotion> motions);
/// Changes the frame rate [frames/s]. Analog samples and marked events keep the frames to which they belong.
void set_rate(MarkerMotion& motion, double rate);

}  // namespace ugoki::intake
