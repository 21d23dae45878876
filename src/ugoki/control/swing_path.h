#pragma once
// Path of a swing foot over uneven ground: the height that the controller adds to the height of the foot in the reference.

#include <array>

#include "ugoki/control/balance_model.h"

namespace ugoki::control {

/// Obstacles on the way of a foot: a height above the line between both places that is zero at both ends. At the share s of the way, with
/// u = 1 - 2 s and the exponent m of this half of the way, it is height * (1 - |u|^(2 m)): a parabola for m = 1; steeper at its end of the
/// way and flatter in the middle for larger m.
struct Hump {
  static constexpr std::size_t samples = 7;
  double height = 0;         ///< m: in the middle of the way
  double sharp[2] = {1, 1};  ///< exponents m of the first and the second half
  /// Share of the way at which sample k is.
  [[nodiscard]] static constexpr double place(std::size_t k) { return static_cast<double>(k + 1) / (samples + 1); }
};

/// The hump that is not lower than the obstacles. An obstacle near one end of the way makes the hump steep there, instead of high in the
/// middle: the height exceeds the highest obstacle by at most 15 %, unless an exponent reaches its maximum, 6.
/// @param needed m: heights of the obstacles above the line between both places; at most 0: none
[[nodiscard]] Hump hump_over(const std::array<double, Hump::samples>& needed);

/// m: for a shorter step, the height of the path follows the phase of the swing.
constexpr double min_way = 0.05;

/// Ground below a swing foot: a straight line from the place that the foot left to its foothold, with the hump on it.
struct SwingPath {
  double height = 0;  ///< m, world
  double rate = 0;    ///< m/s
};
/// @param p, v m, m/s, world: position and velocity of the sole @param phase 0 to 1: phase of the swing
[[nodiscard]] SwingPath swing_path(const BalanceState::FootState& foot, const Vec3& p, const Vec3& v, double phase);

/// A point and its velocity.
struct MovingPoint {
  Vec3 p, v;  ///< m, m/s, world
};
/// The path at the goal of the sole or at the sole itself, whichever is higher, where the path has a hump: a foot that lags behind its goal
/// on the way down from an edge would touch the edge with its heel.
[[nodiscard]] SwingPath path_over_obstacles(const BalanceState::FootState& foot, const MovingPoint& goal, const MovingPoint& sole,
                                            double phase);

}  // namespace ugoki::control
