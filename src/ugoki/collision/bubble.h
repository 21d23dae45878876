#pragma once
// Exact distances between non-convex meshes (the "bubble" method of Nagashima (1999)): a search of two sphere trees, warm-started from the
// closest triangles of the previous query.
// Source: Quinlan, Efficient distance computation between non-convex objects (1994).
//
// A mesh means its SURFACE: a body inside a closed mesh has a positive distance from it. Surfaces that intersect have distance 0; their
// penetration depth is computed by find_penetration (mesh_point.h).

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "ugoki/collision/bubble_kernel.h"
#include "ugoki/collision/sphere_tree.h"
#include "ugoki/spatial/spatial.h"

namespace ugoki::collision {

/// A triangle of mesh a and a triangle of mesh b, as indices into SphereTree::triangles; -1: none. As the warm start of a query, indices
/// of other triangles or indices out of range make the query slower but not wrong.
struct TrianglePair {
  std::int32_t a = -1, b = -1;
  friend bool operator==(const TrianglePair&, const TrianglePair&) = default;
};

enum class BubbleStatus : std::uint8_t {
  separated,   ///< distance > 0
  touching,    ///< the surfaces intersect or are closer than 1e-14 of the summed bounding radii; distance = 0, n = 0
  beyond,      ///< the distance is at least options.farthest: distance = lower = farthest, points and n are not set
  not_finite,  ///< a pose is not finite or farther away than 1e9 m, or a tree is empty: the result is undefined
};

struct BubbleOptions {
  double relative_error = 0;                                  ///< e >= 0: true distance >= distance / (1 + e); 0: exact
  double farthest = std::numeric_limits<double>::infinity();  ///< m: search radius; bodies at this distance or farther give `beyond`
};

/// Result of find_distance(). pa - pb = n * distance.
struct BubbleDistance {
  BubbleStatus status = BubbleStatus::not_finite;
  double distance = 0;                      ///< m: distance between pa and pb, an upper bound of the true distance
  double lower = 0;                         ///< m: proved lower bound of the true distance
  Vec3 pa, pb;                              ///< m, world: closest points on a and b
  Vec3 n;                                   ///< unit, world: from b towards a; zero if touching
  TrianglePair nearest;                     ///< the triangles that contain pa and pb
  int bound_tests = 0, triangle_tests = 0;  ///< counts of tested pairs of bounds and of triangles
};

/// Two triangles closer than a margin, with their closest points.
struct TriangleContact {
  TrianglePair pair;
  double distance = 0;  ///< m; 0: the triangles intersect
  Vec3 pa, pb;          ///< m, world: points on the triangles of a and b
};

/// Result of find_pairs_within().
struct PairsFound {
  BubbleStatus status = BubbleStatus::separated;  ///< always `separated` or `not_finite`
  std::size_t count = 0;                          ///< count of entries of `out` that were filled
  bool complete = true;                           ///< false: there are more pairs than `out` has entries
};

/// Scratch memory of the searches; one object per thread, for any trees. Grows with the depth of the trees and is then reused.
struct BubbleWorkspace {
  std::vector<KernelEntry> stack, stack_of_points, penetration;
  std::vector<KernelPair> pairs;
};

/// True if the searches accept this pose: all values are finite and their magnitudes sum to less than 1e9.
[[nodiscard]] bool can_be_placed(const Pose& X);

/// Distance between mesh a at pose X_WA and mesh b at pose X_WB.
/// @param warm [in, out] the closest triangles of the previous query of this pair; {} at the first query
/// No allocation once the workspace has grown. Same bits on every machine for the same warm start.
[[nodiscard]] BubbleDistance find_distance(const SphereTree& a, const Pose& X_WA, const SphereTree& b, const Pose& X_WB, TrianglePair& warm,
                                           BubbleWorkspace& workspace, const BubbleOptions& options = {});

/// Writes the pairs of triangles closer than `margin` [m] to `out`, in the order of the search (the same in every run). If `out` has too
/// few entries, the remaining pairs are omitted and PairsFound::complete is false.
[[nodiscard]] PairsFound find_pairs_within(const SphereTree& a, const Pose& X_WA, const SphereTree& b, const Pose& X_WB, double margin,
                                           std::span<TriangleContact> out, BubbleWorkspace& workspace);

}  // namespace ugoki::collision
