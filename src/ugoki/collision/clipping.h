#pragma once
// Flat pieces of two bodies cut against each other, and few of many contact points; internal to collision.

#include <span>
#include <vector>

#include "ugoki/collision/manifold.h"
#include "ugoki/collision/patch.h"

namespace ugoki::collision {

/// A point of the cut patch: on its surface, and its height above the reference.
struct Candidate {
  Vec3 p;  ///< m
  double h = 0;
  std::uint32_t feature = 0;
};
struct Candidates {
  std::array<Candidate, 2 * Patch::most> list;
  int count = 0;
  void add(const Candidate& c) {
    if (count < static_cast<int>(list.size())) list[static_cast<std::size_t>(count++)] = c;
  }
  [[nodiscard]] const Candidate& at(int i) const { return list[static_cast<std::size_t>(i)]; }
};

/// The incident patch, cut to what lies above the reference polygon (or beside the reference segment).
/// @param n unit: of the reference, outwards
/// @param side a number that tells features of this cut from those of others
void cut(const Patch& reference, const Patch& incident, const Vec3& n, std::uint32_t side, Candidates& out);

[[nodiscard]] double least_height(const Candidates& c);

/// A number below 2^24 from four.
[[nodiscard]] std::uint32_t mixed(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d);

/// Adds few of many points that span the rest: for each direction of the normals (to 18 degrees) the outermost four of them and, if
/// it is clearly deeper, the deepest; the deepest direction first. Reorders `points`.
/// @param slack m: differences of depth below this do not count
void add_spanning(std::span<ManifoldPoint> points, double slack, Manifold& out);

}  // namespace ugoki::collision
