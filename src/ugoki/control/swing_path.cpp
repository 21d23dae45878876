#include "ugoki/control/swing_path.h"

#include <algorithm>
#include <cmath>

#include "ugoki/spatial/elementary.h"

namespace ugoki::control {
namespace {

constexpr double spare = 1.15;   // height of the hump divided by that of the highest obstacle
constexpr double max_sharp = 6;  // of the exponents

/// Share of the height of a hump at s, and its derivative with respect to s.
SmoothStep shape(double s, const double (&sharp)[2]) {
  const double u = 1 - 2 * s, m = sharp[u > 0 ? 0 : 1];
  if (std::fabs(u) < 1e-9) return {1, 0, 0};
  const double power = exp(m * log(u * u));
  return {1 - power, 4 * m * power / u, 0};
}

}  // namespace

Hump hump_over(const std::array<double, Hump::samples>& needed) {
  Hump hump;
  const double highest = *std::ranges::max_element(needed);
  if (highest <= 0) return hump;
  for (std::size_t k = 0; k < Hump::samples; ++k) {
    const double u = 1 - 2 * Hump::place(k);
    if (needed[k] <= 0 || u == 0) continue;
    double& sharp = hump.sharp[u > 0 ? 0 : 1];  // 1 - |u|^(2 m) = needed / (spare * highest)
    sharp = std::clamp(log(1 - needed[k] / (spare * highest)) / log(u * u), sharp, max_sharp);
  }
  for (std::size_t k = 0; k < Hump::samples; ++k) hump.height = std::max(hump.height, needed[k] / shape(Hump::place(k), hump.sharp).value);
  return hump;
}

SwingPath swing_path(const BalanceState::FootState& foot, const Vec3& p, const Vec3& v, double phase) {
  const Vec3 from{foot.from[0], foot.from[1], 0}, way = Vec3{foot.to[0], foot.to[1], 0} - from;
  const double square = dot(way, way);
  const double s = square > min_way * min_way ? std::clamp(dot(horizontal(p) - from, way) / square, 0.0, 1.0) : smooth_step(phase).value;
  const double rate = square > min_way * min_way && s > 0 && s < 1 ? dot(v, way) / square : 0;
  const SmoothStep hump = shape(s, foot.sharp);
  const double rise = foot.to[2] - foot.from[2];
  return {foot.from[2] + rise * s + foot.bump * hump.value, (rise + foot.bump * hump.rate) * rate};
}

SwingPath path_over_obstacles(const BalanceState::FootState& foot, const MovingPoint& goal, const MovingPoint& sole, double phase) {
  constexpr double straight = 1e-3;  // m: a lower hump is none
  const SwingPath planned = swing_path(foot, goal.p, goal.v, phase);
  if (foot.bump < straight) return planned;
  const SwingPath present = swing_path(foot, sole.p, sole.v, phase);
  return present.height > planned.height ? present : planned;
}

}  // namespace ugoki::control
