#include "ugoki/collision/gilbert_width.h"
#include "ugoki/collision/hull_leap.h"

namespace ugoki::collision {

GilbertResult hull_distance_avx2(const Support& a, const Pose& X_WA, const Support& b, const Pose& X_WB, GilbertCache& cache,
                                 const GilbertOptions& options) {
  return hull_distance(a, X_WA, b, X_WB, cache, options);
}

}  // namespace ugoki::collision
