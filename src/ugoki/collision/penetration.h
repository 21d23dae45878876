#pragma once
// Penetration of two convex shapes, and the signed distance that joins it with Gilbert's.
// Source: van den Bergen, Proximity queries and penetration depth computation on 3D game objects (2001).

#include "ugoki/collision/gilbert.h"

namespace ugoki::collision {

class Polytope;

/// Scratch memory of penetration and signed_distance; one for each thread, any pair may use it. Grows to what is needed, then stays.
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
  beyond,         ///< farther apart than options.farthest
  not_converged,  ///< stopped at the bound of iterations or of rounding: the true value is between `lower` and `upper`
  not_finite,     ///< a pose or size is NaN or infinite: nothing is known
  not_bounded,    ///< two half-spaces
};

/// pa - pb = n * distance: pushing a by n * (-distance), when they penetrate, makes them touch.
struct SignedDistance {
  DistanceStatus status = DistanceStatus::not_finite;
  double distance = 0;          ///< m, between the surfaces: positive apart, negative the depth (the shortest translation that separates)
  double lower = 0, upper = 0;  ///< m: the true value is between them; they differ by rounding and options.tolerance
  Vec3 pa, pb;                  ///< m, world: nearest (deepest) points on a and b
  Vec3 n;                       ///< unit, world: from b towards a
  int iterations = 0;
};

/// Distance, or depth where they overlap. Polytopes: exact to rounding; curved shapes: to options.tolerance.
/// No allocation after the workspace has grown.
[[nodiscard]] SignedDistance signed_distance(const Support& a, const Pose& X_WA, const Support& b, const Pose& X_WB, GilbertCache& cache,
                                             PenetrationWorkspace& workspace, const GilbertOptions& options = {});

}  // namespace ugoki::collision
