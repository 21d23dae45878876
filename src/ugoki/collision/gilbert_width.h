#pragma once
// Gilbert's method for two hulls, compiled for AVX2 and AVX-512. The caller checks that the processor supports them.

#include "ugoki/collision/gilbert.h"

namespace ugoki::collision {

[[nodiscard]] GilbertResult hull_distance_avx2(const Support& a, const Pose& X_WA, const Support& b, const Pose& X_WB, GilbertCache& cache,
                                               const GilbertOptions& options);
[[nodiscard]] GilbertResult hull_distance_avx512(const Support& a, const Pose& X_WA, const Support& b, const Pose& X_WB,
                                                 GilbertCache& cache, const GilbertOptions& options);

}  // namespace ugoki::collision
