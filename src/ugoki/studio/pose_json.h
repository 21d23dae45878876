#pragma once
// JSON of single poses for the web page.

#include <cmath>
#include <span>

#include "ugoki/json/json.h"
#include "ugoki/mechanism/mechanism.h"

namespace ugoki::studio {

/// The multiple of `unit` that is nearest to `x`, never -0: fewer digits in a message.
inline double rounded(double x, double unit) {
  const double value = std::round(x / unit) * unit;
  return value == 0 ? 0 : value;
}

/// Poses of all links in the world: one array with x y z qw qx qy qz (m) for each link. @param q [nq] position coordinates @param unit of
/// rounding
[[nodiscard]] json::Json poses_json(const Mechanism& m, std::span<const double> q, double unit);

}  // namespace ugoki::studio
