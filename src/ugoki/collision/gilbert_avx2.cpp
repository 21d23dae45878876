#include "ugoki/collision/gilbert_search.h"
#include "ugoki/collision/gilbert_width.h"

namespace ugoki::collision {

GilbertResult hull_distance_avx2(const Support& a, const Pose& X_WA, const Support& b, const Pose& X_WB, GilbertCache& cache,
                                 const GilbertOptions& options) {
  return Search<HullCore, HullCore>(a, X_WA, b, X_WB, cache, options).run();
}

}  // namespace ugoki::collision
