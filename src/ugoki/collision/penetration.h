#pragma once
// Signed distance between two convex shapes: Gilbert's distance where they are apart, penetration depth where they overlap.
// The depth is found by the expanding polytope algorithm (EPA).
// Source: van den Bergen, Proximity queries and penetration depth computation on 3D game objects (2001).

#include "ugoki/collision/gilbert.h"

namespace ugoki::collision {

class Polytope;

/// Scratch memory of signed_distance(); one for each thread, any pair may use it. It grows as needed and is then reused.
class PenetrationWorkspace {
 public:
  PenetrationWorkspace();
  ~PenetrationWorkspace();
  PenetrationWorkspace(PenetrationWorkspace&&) noexcept;
  PenetrationWorkspace& operator=(PenetrationWorkspace&&) noexcept;

  [[nodiscard]] Polytope& polytope() { return *polytope_; }

 private:
  Polytope* polytope_;
};

enum class DistanceStatus : std::uint8_t {
  separated,      ///< distance > 0
  penetrating,    ///< distance <= 0
  beyond,         ///< the shapes are farther apart than options.farthest
  not_converged,  ///< stopped by the iteration limit or by rounding: the true value is between `lower` and `upper`
  not_finite,     ///< a pose or size is NaN or infinite: the result is undefined
  not_bounded,    ///< two half-spaces: their distance is not defined
};

/// Signed distance between two convex shapes a and b. pa - pb = n * distance: if they penetrate, translating a by n * (-distance) makes
/// them touch.
struct SignedDistance {
  DistanceStatus status = DistanceStatus::not_finite;
  double distance = 0;          ///< m, between the surfaces; negative: minus the depth (length of the shortest separating translation)
  double lower = 0, upper = 0;  ///< m: bounds of the true value; they differ by rounding and options.tolerance
  Vec3 pa, pb;                  ///< m, world: closest (deepest) points on a and b
  Vec3 n;                       ///< unit, world: from b towards a
  int iterations = 0;           ///< count of support points computed in each shape
};

/// Signed distance between a at pose X_WA and b at pose X_WB. Polytopes: exact up to rounding; curved shapes: to options.tolerance (a
/// fraction of the sum of both bounding radii). No allocation after the workspace has grown.
/// @param cache [in, out] warm start of this pair
[[nodiscard]] SignedDistance signed_distance(const Support& a, const Pose& X_WA, const Support& b, const Pose& X_WB, GilbertCache& cache,
                                             PenetrationWorkspace& workspace, const GilbertOptions& options = {});

}  // namespace ugoki::collision
