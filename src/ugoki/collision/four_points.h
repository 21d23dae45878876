#pragma once
// Choice of up to four of the points in which two flat patches touch.

#include <algorithm>
#include <cmath>
#include <span>

namespace ugoki::collision {

/// A candidate for a contact point. x, y: m, coordinates in the plane of contact; h: m, height above the reference surface.
struct FlatPoint {
  double x, y, h;
};

/// Chooses the outermost of the deepest points, the point farthest from it, and the farthest points on both sides of the line between them.
/// Points count as deepest within 1e-4 of the patch's radius: a patch that rests on another one would otherwise choose other points in
/// every step, because rounding tilts it, and the solver could not begin with the impulses of the last step (test: ContactFeatures).
/// @param chosen [out] indices in ascending order, first -1 for each point that is missing (collinear or coincident points)
inline void choose_four(std::span<const FlatPoint> points, int (&chosen)[4]) {
  constexpr double same_depth = 1e-4, same_place = 1e-6;  // relative to the patch's radius; relative to a squared length
  std::fill_n(chosen, 4, -1);
  const int count = static_cast<int>(points.size());
  if (count == 0) return;
  const auto at = [&](int i) -> const FlatPoint& { return points[static_cast<std::size_t>(i)]; };
  double x = 0, y = 0, lowest = at(0).h, square = 0;
  for (const FlatPoint& p : points) {
    x += p.x / count;
    y += p.y / count;
    lowest = std::min(lowest, p.h);
  }
  const auto square_from = [&](int i, double u, double v) { return (at(i).x - u) * (at(i).x - u) + (at(i).y - v) * (at(i).y - v); };
  for (int i = 0; i < count; ++i) square = std::max(square, square_from(i, x, y));
  const double deepest = lowest + same_depth * std::sqrt(square), slack = same_place * square;
  const auto farthest = [&](double minimum, const auto& score) {
    int found = -1;
    for (int i = 0; i < count; ++i)
      if (const double s = score(i); s > minimum + slack) {
        minimum = s;
        found = i;
      }
    return found;
  };
  chosen[3] = farthest(-1 - slack, [&](int i) { return at(i).h <= deepest ? square_from(i, x, y) : -2; });
  const FlatPoint& o = at(chosen[3]);
  chosen[2] = farthest(1e-18, [&](int i) { return square_from(i, o.x, o.y); });
  if (chosen[2] >= 0) {
    const FlatPoint& e = at(chosen[2]);
    const auto side = [&](int i) { return (e.x - o.x) * (at(i).y - o.y) - (e.y - o.y) * (at(i).x - o.x); };
    chosen[1] = farthest(1e-12, side);
    chosen[0] = farthest(1e-12, [&](int i) { return -side(i); });
  }
  std::sort(chosen, chosen + 4);
}

}  // namespace ugoki::collision
