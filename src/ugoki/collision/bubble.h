#pragma once
// Exact distances of non-convex meshes: the search of two trees of spheres, warm-started from the last nearest triangles.
// Source: Quinlan, Efficient distance computation between non-convex objects (1994).
//
// A mesh is its SURFACE: a body inside a closed one has a distance from it. Where surfaces pierce each other the distance is 0;
// how deep is told by find_penetration (mesh_penetration.h).

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "ugoki/collision/bubble_kernel.h"
#include "ugoki/collision/sphere_tree.h"
#include "ugoki/spatial/spatial.h"

namespace ugoki::collision {

/// Indices into SphereTree::triangles; the warm start of a pair of bodies. Wrong or foreign indices cost time, never truth.
struct TrianglePair {
  std::int32_t a = -1, b = -1;
  friend bool operator==(const TrianglePair&, const TrianglePair&) = default;
};

enum class BubbleStatus : std::uint8_t {
  separated,   ///< distance > 0
  touching,    ///< the surfaces pierce each other, or touch to within 1e-14 of the bodies' size: distance 0, no direction
  beyond,      ///< not closer than options.farthest; distance and lower are that, and there are no points
  not_finite,  ///< a pose is not finite or farther away than 1e9 m, or a tree is empty: nothing is known
};

struct BubbleOptions {
  double relative_error = 0;                                  ///< e >= 0: the true distance is not below distance / (1 + e). 0: exact
  double farthest = std::numeric_limits<double>::infinity();  ///< m: pairs not closer than this are of no interest
};

/// distance is that of the points; pa - pb = n * distance.
struct BubbleDistance {
  BubbleStatus status = BubbleStatus::not_finite;
  double distance = 0;  ///< m: an upper bound, attained by pa and pb
  double lower = 0;     ///< m: a lower bound, proved
  Vec3 pa, pb;          ///< m, world: a nearest pair of points on a and b
  Vec3 n;               ///< unit, world: from b towards a; zero where touching
  TrianglePair nearest;
  int bound_tests = 0, triangle_tests = 0;  ///< pairs of bounds and of triangles that were looked at
};

/// Two triangles closer than a margin, and their nearest points (world).
struct TriangleContact {
  TrianglePair pair;
  double distance = 0;  ///< m, 0 where they pierce each other
  Vec3 pa, pb;          ///< m, world
};

struct PairsFound {
  BubbleStatus status = BubbleStatus::separated;  ///< separated, or not_finite
  std::size_t count = 0;                          ///< of `out` that were filled
  bool complete = true;                           ///< false: there were more than `out` holds
};

/// Scratch memory of the searches; one for each thread, any trees may use it. Grows with the depth of the trees, then stays.
struct BubbleWorkspace {
  std::vector<KernelEntry> stack, stack_of_points, penetration;
  std::vector<KernelPair> pairs;
};

/// A pose that searches take: finite, and not farther away than 1e9 m.
[[nodiscard]] bool can_be_placed(const Pose& X);

/// Distance of mesh a at pose X_WA and mesh b at pose X_WB.
/// @param warm the nearest triangles of the last query of this pair, in and out; {} at the start
/// No allocation once the workspace has grown; the same bits on every machine for the same warm start.
[[nodiscard]] BubbleDistance find_distance(const SphereTree& a, const Pose& X_WA, const SphereTree& b, const Pose& X_WB, TrianglePair& warm,
                                           BubbleWorkspace& workspace, const BubbleOptions& options = {});

/// All pairs of triangles closer than `margin` [m], in the order of the search (the same in every run), as many as `out` holds.
[[nodiscard]] PairsFound find_pairs_within(const SphereTree& a, const Pose& X_WA, const SphereTree& b, const Pose& X_WB, double margin,
                                           std::span<TriangleContact> out, BubbleWorkspace& workspace);

}  // namespace ugoki::collision
