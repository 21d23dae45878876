#pragma once
// Gilbert's search of two hulls, compiled for wider registers.

#include "ugoki/collision/gilbert.h"

namespace ugoki::collision {

[[nodiscard]] GilbertResult hull_distance_avx2(const Support& a, const Pose& X_WA, const Support& b, const Pose& X_WB, GilbertCache& cache,
                                               const GilbertOptions& options);
[[nodiscard]] GilbertResult hull_distance_avx512(const Support& a, const Pose& X_WA, const Support& b, const Pose& X_WB,
                                                 GilbertCache& cache, const GilbertOptions& options);

}  // namespace ugoki::collision
