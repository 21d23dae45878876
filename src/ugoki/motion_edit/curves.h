#pragma once
// Conversion of a motion to editable curves with few keys and tangents, and back.

#include <array>
#include <string>
#include <vector>

#include "ugoki/motion/motion.h"

namespace ugoki::motion_edit {

/// A key of a curve: time, value, and the slopes just before and just after this time. Unused components are 0.
struct Key {
  double time = 0;                                ///< s
  std::array<double, 3> value{};                  ///< m or rad; for rotations the rotation vector relative to Curve::reference
  std::array<double, 3> slope_in{}, slope_out{};  ///< m/s or rad/s
};

/// A curve of one joint: a scalar coordinate, the position (location) of a floating joint, or a rotation.
struct Curve {
  enum class Kind { coordinate, location, rotation };
  std::string link;
  Kind kind = Kind::coordinate;
  int coordinate = 0;     ///< index of the curve's first coordinate within the joint's coordinates
  int size = 1;           ///< number of components of a value: 1 or 3
  Quat reference;         ///< for rotations: the orientation to which the rotation vectors are relative
  std::vector<Key> keys;  ///< sorted by time; at least one

  /// Value and slope at time t [s]: cubic Hermite interpolation between keys, constant before the first and after the last key.
  [[nodiscard]] std::array<double, 3> value(double t) const;
  [[nodiscard]] std::array<double, 3> slope(double t) const;
};

struct MotionCurves {
  std::string name, source, mechanism;
  double rate = 120;  ///< frames per second of the source motion
  int frames = 0;
  bool cyclic = false;
  std::vector<Curve> curves;  ///< for each joint: one curve per scalar coordinate, one for a floating joint's position, one for a rotation
  std::vector<ContactTrack> contacts;

  [[nodiscard]] int key_count() const;
  [[nodiscard]] int find(const std::string& link, Curve::Kind kind) const;  ///< index of the first curve of this link and kind; -1: none
};

struct ReduceOptions {
  double degrees = 0.25;  ///< deg, maximum rotation error of any joint in any frame
  double metres = 0.001;  ///< m, maximum translation error of any joint, including the root, in any frame
};

/// Converts a motion to curves with few keys such that the errors in every frame are within the bounds of `options`. A piece of a curve
/// whose error is too large is split at its worst frame (Douglas-Peucker scheme; cubic Hermite pieces with the slopes of the motion).
/// O(frames log frames) for most motions. Errors: the motion does not fit the mechanism; a bound that is not above 0.
[[nodiscard]] Result<MotionCurves> reduce_keys(const Mechanism& mechanism, const Motion& motion, const ReduceOptions& options = {});

/// Samples the curves as a motion. @param rate frames per second; 0: the rate of the curves
/// Errors: a curve for a link or coordinate that the mechanism does not have; keys that are not sorted by time or not finite; no frames.
[[nodiscard]] Result<Motion> to_motion(const Mechanism& mechanism, const MotionCurves& curves, double rate = 0);

// Editing of keys. Errors name the curve's link and the allowed values.

/// Inserts a key at time t [s] without changing the curve's shape. @return index of the new key
[[nodiscard]] Result<int> add_key(Curve& curve, double t);
/// Sets time [s] and value of a key; the time must stay between the times of the neighbouring keys.
[[nodiscard]] Result<void> move_key(Curve& curve, int key, double t, const std::array<double, 3>& value);
[[nodiscard]] Result<void> set_slopes(Curve& curve, int key, const std::array<double, 3>& in, const std::array<double, 3>& out);
/// Deletes a key. The only remaining key of a curve cannot be deleted.
[[nodiscard]] Result<void> delete_key(Curve& curve, int key);

}  // namespace ugoki::motion_edit
