#pragma once
// Curves that motions are composed of, and the leg that reaches a place.

#include "ugoki/spatial/spatial.h"

namespace ugoki::samples {

inline constexpr double degree = pi / 180;

/// Value and first two derivatives.
struct Jet {
  double x = 0, v = 0, a = 0;
};

/// Quintic from `from` at s = 0 to `to` at s = 1 (derivatives with respect to s).
[[nodiscard]] double quintic(const Jet& from, const Jet& to, double s);

/// 0 for s <= 0, 1 for s >= 1, in between with two continuous derivatives.
[[nodiscard]] double smooth_step(double s);

/// 64 s^3 (1 - s)^3: 1 in the middle, 0 with two derivatives at the ends.
[[nodiscard]] double bump(double s);

/// x - floor(x)
[[nodiscard]] double fraction(double x);

/// Posture of a limb of two bones that hang down (-z) at rest and whose middle joint is a hinge about y.
struct LimbPosture {
  Mat3 R_upper;        ///< of the upper bone, in the world
  double flexion = 0;  ///< rad, of the middle joint: turn of the lower bone about the upper bone's y
  double reach = 0;    ///< distance to the target over the length of both bones; above 1 the target is out of reach
};

/// Reaches from `root` to `end`. @param side the hinge axis is the part of this direction (about y) at a right angle to the line
/// root-end @param bend +1: the middle joint bends like a knee (flexion > 0, the joint in front of the line), -1: like an elbow
[[nodiscard]] LimbPosture reach(const Vec3& root, const Vec3& end, double upper, double lower, const Vec3& side, int bend);

}  // namespace ugoki::samples
