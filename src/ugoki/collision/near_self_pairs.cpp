#include "ugoki/collision/near_self_pairs.h"

#include <algorithm>

namespace ugoki::collision {
namespace {

// Systems with fewer pairs: testing all of them takes as long as testing the displacements of all shapes.
constexpr std::size_t min_pairs = 64;
// Slack relative to the mean radius of the bounding spheres. With 1, the list of a falling humanoid is made again every 10 to 30 steps of
// 2 ms, and contains a third of all pairs.
constexpr double relative_slack = 1;
constexpr double rounding = 1e-9;  // relative: error of distances and sums

/// m: slack of a list
double slack_of(std::span<const Workspace::Ball> balls) {
  double sum = 0;
  for (const Workspace::Ball& b : balls) sum += b.r;
  return relative_slack * sum / static_cast<double>(balls.size());
}

/// Whether the list holds for the present spheres. False for centres that are not finite.
bool holds(const Workspace::NearPairs& known, std::span<const Workspace::Ball> balls, double margin, double slack) {
  if (known.at.size() != balls.size() || !(margin <= known.margin)) return false;
  const Vec3 common = balls[0].c - known.at[0];
  const double limit = 0.5 * (1 - rounding) * slack;
  bool near = true;
  for (std::size_t i = 0; i < balls.size(); ++i) {
    const Vec3 d = balls[i].c - known.at[i] - common;
    near = near && dot(d, d) <= limit * limit;
  }
  return near;
}

}  // namespace

std::span<const ShapePair> near_self_pairs(std::span<const ShapePair> all, std::span<const Workspace::Ball> balls, std::size_t first,
                                           double margin, Workspace::NearPairs& known) {
  if (all.size() < min_pairs) return all;
  const double slack = slack_of(balls);
  if (holds(known, balls, margin, slack)) return known.pairs;
  known.margin = std::max({margin, known.margin, 0.0});
  known.at.clear();
  for (const Workspace::Ball& b : balls) known.at.push_back(b.c);
  known.pairs.clear();
  known.pairs.reserve(all.size());  // so that later lists allocate nothing
  for (const ShapePair& p : all) {
    const Workspace::Ball &a = balls[static_cast<std::size_t>(p.a) - first], &b = balls[static_cast<std::size_t>(p.b) - first];
    const Vec3 gap = a.c - b.c;
    const double reach = (1 + rounding) * (a.r + b.r + known.margin + slack);
    if (dot(gap, gap) < reach * reach) known.pairs.push_back(p);
  }
  return known.pairs;
}

}  // namespace ugoki::collision
