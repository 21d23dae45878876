#pragma once
// Minkowski difference a - b of the cores (support.h) of two shapes, in the frame of a. The penetration search grows its polytope inside
// this difference.

#include "ugoki/collision/simplex.h"
#include "ugoki/collision/support_point.h"
#include "ugoki/spatial/spatial.h"

namespace ugoki::collision {

struct Difference {
  const Support& a;
  const Support& b;
  Mat3 R;  ///< rotation of b in a
  Vec3 p;  ///< m: position of b in a

  Difference(const Support& one, const Pose& X_WA, const Support& two, const Pose& X_WB)
      : a(one), b(two), R(X_WA.R.transposed() * X_WB.R), p(transpose_times(X_WA.R, X_WB.p - X_WA.p)) {}

  /// The point of the difference that is farthest along d (frame of a), with the vertices of a and b whose difference it is.
  /// @param hint_a, hint_b vertices of a and b from which the searches start
  [[nodiscard]] Corner support(const Vec3& d, std::int32_t hint_a, std::int32_t hint_b) const {
    const SupportPoint on_a = support_point(a, d, hint_a), on_b = support_point(b, -transpose_times(R, d), hint_b);
    return {on_a.p - (R * on_b.p + p), on_a.p, on_a.vertex, on_b.vertex};
  }
};

}  // namespace ugoki::collision
