#pragma once
// Gilbert distance: the true distance between two convex shapes with proved upper and lower bounds. Fast in coherent motion, as each query
// starts from the closest features of the previous one.
//
// Design: docs/design/convex-distance.md.
// Sources: Gilbert, Johnson, Keerthi, A fast procedure for computing the distance between complex objects in three-dimensional
// space (1988); Cameron, Enhancing GJK (1997): hill climbing on the hull; Montanari, Petrinic, Barbieri, Improving the GJK algorithm
// (2017): signed volumes.

#include <array>
#include <cstdint>
#include <limits>

#include "ugoki/collision/support.h"
#include "ugoki/spatial/spatial.h"

namespace ugoki::collision {

/// Predicted direction between two hulls, used in fast motion, when the closest vertices change at nearly every query (hull_leap.h). All
/// zero at the start.
struct GilbertTrend {
  std::int32_t pace = 0;                   ///< 1024 times the smoothed count of closest vertices (0 ... 2) that change per query
  double inverse_distance = 0;             ///< 1/m: inverse of the distance found by the previous query; 0: no prediction yet
  std::array<double, 4> next{}, change{};  ///< world: predicted direction from b towards a (length about 1), and its change per query
};

/// Warm start of a pair of shapes, kept from one query to the next; all zero at the first query. Use one cache per pair, as vertices are
/// indices into the hulls of that pair. Content from another pair makes a query slower but not wrong.
struct GilbertCache {
  std::array<std::int32_t, 3> a{}, b{};  ///< indices of the vertices that span the closest features of a and b
  std::int32_t count = 0;                ///< count of entries of a and b in use; 0: none
  Vec3 n;                                ///< separating direction of the previous query, from b towards a: unit or zero, a's frame
  GilbertTrend trend;
};

enum class GilbertStatus : std::uint8_t {
  separated,      ///< the cores (support.h) are apart, and distance - lower <= the tolerance
  touching,       ///< the cores overlap, or touch to 1e-14 of the coordinates: no separating direction; see penetration.h
  beyond,         ///< lower > options.farthest; the other results are estimates
  not_converged,  ///< stopped by max_iterations or by rounding: `distance` and `lower` are valid bounds, but not within the tolerance
  not_finite,     ///< a pose or size is NaN or infinite: the result is undefined
  not_bounded,    ///< both shapes are half-spaces
};

struct GilbertOptions {
  double tolerance = 1e-10;  ///< accepted duality gap (distance - lower), relative to the sum of both bounding radii
  double farthest = std::numeric_limits<double>::infinity();  ///< m: stop as soon as the distance is proved to be larger
  int max_iterations = 200;                                   ///< limit of GilbertResult::iterations; penetration.h allows twice as many
};

/// Result of gilbert_distance(). If separated: pa - pb = n * distance. `distance` is the distance between the cores less both radii;
/// negative if the shapes overlap but their cores do not.
struct GilbertResult {
  GilbertStatus status = GilbertStatus::not_finite;
  double distance = 0;  ///< m, between pa and pb: upper bound of the true distance. touching: minus the sum of the radii
  double lower = 0;     ///< m: lower bound of the true distance, proved by the direction n
  Vec3 pa, pb;          ///< m, world: closest points on a and b
  Vec3 n;               ///< unit, world: from b towards a
  int iterations = 0;   ///< count of support points computed per shape
};

/// Distance between a at pose X_WA and b at pose X_WB. No allocation. Same bits on every machine for the same cache.
/// @param cache [in, out] warm start of this pair
[[nodiscard]] GilbertResult gilbert_distance(const Support& a, const Pose& X_WA, const Support& b, const Pose& X_WB, GilbertCache& cache,
                                             const GilbertOptions& options = {});

}  // namespace ugoki::collision
