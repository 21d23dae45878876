#pragma once
// How a file's space and time are taken where its reader guessed wrong: axes, unit of length, frames a second.

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/motion/markers.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::intake {

/// An axis of a file's space, in one of its two directions.
struct FileAxis {
  int axis = 0;  ///< 0 x, 1 y, 2 z
  bool negative = false;
  friend bool operator==(const FileAxis&, const FileAxis&) = default;
};
/// "x", "-y" ...; nothing where it is none of the six.
[[nodiscard]] std::optional<FileAxis> file_axis_named(std::string_view name);
[[nodiscard]] std::string name_of(const FileAxis& axis);

/// Where up and forward are in a file's space, which is right-handed. Ours: Z up, X forward.
struct Orientation {
  FileAxis up{1, false}, forward{2, false};
  [[nodiscard]] bool valid() const { return up.axis != forward.axis; }
  friend bool operator==(const Orientation&, const Orientation&) = default;
};
/// Y up, Z forward; or Z up, X forward: what the readers take.
[[nodiscard]] Orientation usual_orientation(bool z_up);
/// Turns coordinates of the file's space into ours. Of a valid orientation.
[[nodiscard]] Mat3 rotation_to_ours(const Orientation& file);

/// The same motion in a world turned by R. Every joint's frame stays parallel to the world's at rest.
void turn(MeasuredMotion& motion, const Mat3& R);
void turn(MarkerMotion& motion, const Mat3& R);
/// Lengths times `factor`.
void scale(MeasuredMotion& motion, double factor);
/// Leaves out what only carries the joint that moves ("reference", "armature"): where the only root heads a chain without branches and a
/// joint along it is measured to shift against the one before, that joint becomes the root. World poses of all others stay.
/// @param motions on the same skeleton
/// @return names of what was left out
std::vector<std::string> leave_out_bearers(std::span<MeasuredMotion> motions);
/// The same frames at another rate; samples and marked events keep to their frames.
void set_rate(MarkerMotion& motion, double rate);

}  // namespace ugoki::intake
