#pragma once
// Curves for composing motions, and inverse kinematics of a limb with two bones.

#include "ugoki/spatial/spatial.h"

namespace ugoki::samples {

inline constexpr double degree = pi / 180;

/// Value, first and second derivative of a curve at one point.
struct Jet {
  double x = 0, v = 0, a = 0;
};

/// Quintic polynomial from `from` at s = 0 to `to` at s = 1. The derivatives are with respect to s.
[[nodiscard]] double quintic(const Jet& from, const Jet& to, double s);

/// Smooth step from 0 (s <= 0) to 1 (s >= 1) with continuous first and second derivatives.
[[nodiscard]] double smooth_step(double s);

/// Returns 64 s^3 (1 - s)^3. It is 1 at s = 0.5; at s = 0 and s = 1 it is 0, with zero first and second derivatives.
[[nodiscard]] double bump(double s);

/// Returns x - floor(x).
[[nodiscard]] double fraction(double x);

/// Posture of a limb with two bones. At rest the bones point down (-z); the middle joint is a hinge about y.
struct LimbPosture {
  Mat3 R_upper;        ///< rotation of the upper bone in the world
  double flexion = 0;  ///< rad, angle of the middle joint: rotation of the lower bone about the upper bone's y
  double reach = 0;    ///< distance from root to target, divided by the sum of both bone lengths; above 1 the target is out of reach
};

/// Computes the posture of a limb from `root` to `end` (m, world). If `end` is out of reach, the limb is stretched towards it.
/// @param upper, lower m, lengths of the bones
/// @param side the hinge axis is the component of this direction (approximately y) perpendicular to the line from root to end
/// @param bend +1: the middle joint bends like a knee (flexion > 0, the joint in front of the line), -1: like an elbow
[[nodiscard]] LimbPosture reach(const Vec3& root, const Vec3& end, double upper, double lower, const Vec3& side, int bend);

}  // namespace ugoki::samples
