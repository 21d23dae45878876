#pragma once
// Support area: the convex hull of points in the horizontal plane.

#include <vector>

#include "ugoki/spatial/vec3.h"

namespace ugoki::control {

/// Computes the distance of p from the edge of the convex hull of points. All vectors count as horizontal.
/// @param points [in, scratch] at least one point; the hull is stored behind them
/// @param closest [out] closest point of the hull @return m: signed distance, positive inside
double distance_to_edge(std::vector<Vec3>& points, const Vec3& p, Vec3& closest);

}  // namespace ugoki::control
