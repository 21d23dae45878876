#pragma once
// Weighted means on the manifold of a mechanism's positions.

#include <span>
#include <vector>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki::motion_edit {

/// The position from which the weighted ways to all given ones cancel (Karcher's mean): straight means of angles and lengths, for two
/// rotations the great arc. @param q [motions] of nq each  @param weights [motions] sum to 1  @param out [nq] may alias none
void calc_mean(const Mechanism& mechanism, std::span<const std::vector<double>> q, std::span<const double> weights, std::span<double> out);

/// The same for rotations.
[[nodiscard]] Quat calc_mean(std::span<const Quat> rotations, std::span<const double> weights);

}  // namespace ugoki::motion_edit
