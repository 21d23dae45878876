#pragma once
// Gilbert distance: the true distance of two convex shapes, with its own certificate, cheap in coherent motion.
// Sources: Gilbert, Johnson, Keerthi, A fast procedure for computing the distance between complex objects in three-dimensional
// space (1988); Cameron, Enhancing GJK (1997): the walk on the hull; Montanari, Petrinic, Barbieri, Improving the GJK algorithm
// (2017): signed volumes.

#include <array>
#include <cstdint>
#include <limits>

#include "ugoki/collision/support.h"
#include "ugoki/spatial/spatial.h"

namespace ugoki::collision {

/// Where the direction between two hulls goes while their motion passes vertices at nearly every query (hull_leap.h); all zero at the
/// start.
struct GilbertTrend {
  std::int32_t pace = 0;                   ///< smoothed: 1024 for each vertex that a query passes
  double inverse_distance = 0;             ///< 1/m, of the last query
  std::array<double, 4> next{}, change{};  ///< world: from b towards a, about 1 long: as foretold; what is added to it from query to query
};

/// What a pair remembers from one query to the next; all zero at the start. Wrong or foreign content costs time, never truth,
/// but one cache belongs to one pair of supports (vertices are indices into their hulls).
struct GilbertCache {
  std::array<std::int32_t, 3> a{}, b{};  ///< vertices of the nearest features
  std::int32_t count = 0;                ///< how many of them; 0: nothing known
  Vec3 n;                                ///< unit or zero, shape a's frame, from b towards a: last separating direction
  GilbertTrend trend;
};

enum class GilbertStatus : std::uint8_t {
  separated,      ///< distance > 0, certified: distance - lower <= the tolerance
  touching,       ///< the cores overlap or touch (within 1e-14 of their size): no separating direction; see penetration.h
  beyond,         ///< farther apart than options.farthest; `lower` proves it, the rest is an estimate
  not_converged,  ///< stopped at the bound of iterations or of rounding: `distance` and `lower` still hold
  not_finite,     ///< a pose or size is NaN or infinite: nothing is known
  not_bounded,    ///< two half-spaces
};

struct GilbertOptions {
  double tolerance = 1e-10;                                   ///< of the sum of both bounding radii: greatest duality gap accepted
  double farthest = std::numeric_limits<double>::infinity();  ///< m: stop as soon as the distance is known to be greater
  int max_iterations = 200;                                   ///< penetration: twice as many
};

/// Separated: distance = |pa - pb| (cores' distance less the radii, which may be negative where inflated shapes overlap while
/// their cores do not), pa - pb = n * distance.
struct GilbertResult {
  GilbertStatus status = GilbertStatus::not_finite;
  double distance = 0;  ///< m, between the surfaces: an upper bound, reached by pa and pb. touching: minus both radii
  double lower = 0;     ///< m: no two points of the shapes are closer (proved by the direction n)
  Vec3 pa, pb;          ///< m, world: a nearest pair of points on a and b
  Vec3 n;               ///< unit, world: from b towards a
  int iterations = 0;   ///< support points computed in each shape
};

/// Distance of a at pose X_WA and b at pose X_WB. No allocation; the same bits on every machine for the same cache.
[[nodiscard]] GilbertResult gilbert_distance(const Support& a, const Pose& X_WA, const Support& b, const Pose& X_WB, GilbertCache& cache,
                                             const GilbertOptions& options = {});

}  // namespace ugoki::collision
