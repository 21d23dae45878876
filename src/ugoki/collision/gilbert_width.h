#pragma once
// Gilbert's method for two hulls, compiled for AVX2 and AVX-512. The caller checks that the processor supports them.

#include <cstdint>

#include "ugoki/collision/gilbert.h"

namespace ugoki::collision {

[[nodiscard]] GilbertResult hull_distance_avx2(const Support& a, const Pose& X_WA, const Support& b, const Pose& X_WB, GilbertCache& cache,
                                               const GilbertOptions& options);
[[nodiscard]] GilbertResult hull_distance_avx512(const Support& a, const Pose& X_WA, const Support& b, const Pose& X_WB,
                                                 GilbertCache& cache, const GilbertOptions& options);

enum class GilbertWidth : std::uint8_t { plain, avx2, avx512 };
/// Selects the instruction set that computes distances between hulls, for tests. Call this function before other threads run.
/// @return false if the processor or the build does not support this width; the selection then does not change
bool use_gilbert_width(GilbertWidth width);

}  // namespace ugoki::collision
