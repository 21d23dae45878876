#pragma once
// A motion as few keys with tangents, which people can edit, and back.

#include <array>
#include <string>
#include <vector>

#include "ugoki/motion/motion.h"

namespace ugoki::motion_edit {

/// Value of a curve at a moment, and its slopes before and after it. Unused components are 0.
struct Key {
  double time = 0;                                ///< s
  std::array<double, 3> value{};                  ///< m or rad; rotations: rotation vector from the curve's reference
  std::array<double, 3> slope_in{}, slope_out{};  ///< per second
};

/// What one curve moves: a joint's coordinate, its place, or its rotation.
struct Curve {
  enum class Kind { coordinate, place, rotation };
  std::string link;
  Kind kind = Kind::coordinate;
  int coordinate = 0;     ///< of the joint's own q: the first one that it gives
  int size = 1;           ///< components: 1 or 3
  Quat reference;         ///< rotations: what its rotation vectors are counted from
  std::vector<Key> keys;  ///< by time; at least one

  /// Cubic Hermite between keys, constant outside.
  [[nodiscard]] std::array<double, 3> value(double t) const;
  [[nodiscard]] std::array<double, 3> slope(double t) const;
};

struct MotionCurves {
  std::string name, source, mechanism;
  double rate = 120;  ///< frames a second of the motion it came from
  int frames = 0;
  bool cyclic = false;
  std::vector<Curve> curves;  ///< one for each coordinate, place and rotation of the mechanism
  std::vector<ContactTrack> contacts;

  [[nodiscard]] int key_count() const;
  [[nodiscard]] int find(const std::string& link, Curve::Kind kind) const;  ///< -1: none
};

struct ReduceOptions {
  double degrees = 0.25;  ///< no joint is turned farther from where it was, in any frame
  double metres = 0.001;  ///< no joint slides farther from where it was, nor the root from its place
};

/// As few keys as keep every frame within the bounds: pieces are halved at their worst frame until none is outside (Douglas and Peucker's
/// scheme with cubic Hermite pieces whose slopes are those of the motion). O(frames log frames) for most motions. Errors: the motion does
/// not fit; bounds not positive.
[[nodiscard]] Result<MotionCurves> reduce_keys(const Mechanism& mechanism, const Motion& motion, const ReduceOptions& options = {});

/// The motion that the curves describe. @param rate frames a second; 0: theirs
/// Errors: a curve of a link or coordinate that the mechanism does not have, or with keys not by time or not finite; no frames.
[[nodiscard]] Result<Motion> to_motion(const Mechanism& mechanism, const MotionCurves& curves, double rate = 0);

// Editing. Errors name the curve's link and say what is possible.

/// A new key at time t that leaves the curve's shape as it is. @return its index
[[nodiscard]] Result<int> add_key(Curve& curve, double t);
/// Moves a key to another time (between its neighbours) and value.
[[nodiscard]] Result<void> move_key(Curve& curve, int key, double t, const std::array<double, 3>& value);
[[nodiscard]] Result<void> set_slopes(Curve& curve, int key, const std::array<double, 3>& in, const std::array<double, 3>& out);
/// The last key of a curve cannot be deleted.
[[nodiscard]] Result<void> delete_key(Curve& curve, int key);

}  // namespace ugoki::motion_edit
