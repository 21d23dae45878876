#pragma once
// Clipping of the touching faces of two bodies, and the reduction of many contact points to a few. Internal to collision.

#include <span>
#include <vector>

#include "ugoki/collision/manifold.h"
#include "ugoki/collision/patch.h"

namespace ugoki::collision {

/// A corner of the clipped incident patch.
struct Candidate {
  Vec3 p;                     ///< m: on the surface of the incident body
  double h = 0;               ///< m: height above the surface of the reference body
  std::uint32_t feature = 0;  ///< < 2^24: see ManifoldPoint::feature
};
/// Fixed-capacity list of candidates.
struct Candidates {
  std::array<Candidate, 2 * Patch::max_corners> list;
  int count = 0;
  /// Ignored when the list is full.
  void add(const Candidate& c) {
    if (count < static_cast<int>(list.size())) list[static_cast<std::size_t>(count++)] = c;
  }
  [[nodiscard]] const Candidate& at(int i) const { return list[static_cast<std::size_t>(i)]; }
};

/// Clips the incident patch to the prism above the reference polygon, or to the slab between the end planes of the reference segment.
/// @param n unit: outward normal of the reference
/// @param side constant that makes the features of this kind of cut differ from those of other kinds
/// @param out replaced by the corners of the clipped patch
void cut(const Patch& reference, const Patch& incident, const Vec3& n, std::uint32_t side, Candidates& out);

/// Minimum height [m] of the candidates; 1e300 if there are none.
[[nodiscard]] double min_height(const Candidates& c);

/// Hash of four values, below 2^24: the identifier of a contact feature.
[[nodiscard]] std::uint32_t feature_hash(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d);

/// Reduces many contact points to a few and adds them to `out`. Points whose normals differ by less than 18 degrees form a group. Each
/// group adds its four outermost points, and its deepest point if that is deeper than these by more than `slack`. The group of the deepest
/// point is added first. Reorders `points`.
/// @param slack m: smaller differences of depth are ignored
void add_spanning(std::span<ManifoldPoint> points, double slack, Manifold& out);

}  // namespace ugoki::collision
