#pragma once
// Weighted means on the configuration manifold of a mechanism.

#include <span>
#include <vector>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki::motion_edit {

/// Computes the Karcher mean: the position from which the weighted displacements to all given positions sum to zero. For angles and lengths
/// it is the arithmetic mean; for two rotations it is a rotation on the great arc between them.
/// @param q [motions] vectors of nq  @param weights [motions] with the sum 1  @param out [nq, out] must not alias q
void calc_mean(const Mechanism& mechanism, std::span<const std::vector<double>> q, std::span<const double> weights, std::span<double> out);

/// Karcher mean of rotations. @param weights with the sum 1
[[nodiscard]] Quat calc_mean(std::span<const Quat> rotations, std::span<const double> weights);

}  // namespace ugoki::motion_edit
