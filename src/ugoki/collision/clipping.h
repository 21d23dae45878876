#pragma once
// Clipping of the touching faces of two bodies, and the reduction of many contact points to a few. Internal to collision.

#include <span>
#include <vector>

#include "ugoki/collision/manifold.h"
#include "ugoki/collision/patch.h"

namespace ugoki::collision {

/// A corner of the incident patch after it was clipped to the reference patch by cut(); a candidate for a contact point.
struct Candidate {
  Vec3 p;                     ///< m: on the surface of the incident body, to which the incident patch belongs
  double h = 0;               ///< m: height above the surface of the reference body
  std::uint32_t feature = 0;  ///< < 2^24: see ManifoldPoint::feature
};
/// Fixed-capacity list of candidates.
struct Candidates {
  std::array<Candidate, 2 * Patch::max_corners> list;
  int count = 0;
  /// Appends a candidate; ignored when the list is full.
  void add(const Candidate& c) {
    if (count < static_cast<int>(list.size())) list[static_cast<std::size_t>(count++)] = c;
  }
  [[nodiscard]] const Candidate& at(int i) const { return list[static_cast<std::size_t>(i)]; }
};

/// Clips the incident patch to the prism above the reference patch. If the reference patch is a segment, clips to the slab between the
/// planes through its ends.
/// @param n unit: outward normal of the reference patch
/// @param side constant of the caller, hashed into Candidate::feature so that the features of different callers differ
/// @param out replaced by the corners of the clipped patch
void cut(const Patch& reference, const Patch& incident, const Vec3& n, std::uint32_t side, Candidates& out);

/// Minimum height h [m] of the candidates; 1e300 if there are none.
[[nodiscard]] double min_height(const Candidates& c);

/// Identifier of a contact feature: a hash of four values, less than 2^24.
[[nodiscard]] std::uint32_t feature_hash(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d);

/// Reduces many contact points to a few and adds them to `out`. Points whose normals differ by less than 18 degrees form a group. Each
/// group adds its four outermost points, and its deepest point if it is deeper than the four by more than `slack`. The group of the deepest
/// point is added first. Reorders `points`.
/// @param slack m: smaller differences of depth are ignored
void add_spanning(std::span<ManifoldPoint> points, double slack, Manifold& out);

}  // namespace ugoki::collision
