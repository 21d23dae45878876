#pragma once
// The pairs of shapes inside one system whose bounding spheres may be closer than the margin.
//
// A list of the pairs whose spheres are closer than margin + slack is kept. Spheres do not rotate, so that the gap between two of them
// changes by at most |d_a - t| + |d_b - t|, where d are the displacements of their centres since the list was made, and t is any vector.
// All other pairs are therefore farther apart than the margin as long as no |d - t| exceeds slack / 2; t is the displacement of the first
// shape. The list only leaves out pairs that cannot touch, so that the contacts do not depend on when it was made. Source: Verlet (1967),
// Computer "experiments" on classical fluids, section II.

#include <span>

#include "ugoki/collision/scene.h"

namespace ugoki::collision {

/// @param all    self-pairs of the system, indices into Scene::shapes()
/// @param balls  [shapes of the system] m, world: bounding spheres now
/// @param first  index in Scene::shapes() of the system's first shape
/// @param margin m, may be negative
/// @param known  the list, which is made again when it no longer holds
/// @return the pairs of `all`, in the same order, without some of those whose spheres are farther apart than the margin
[[nodiscard]] std::span<const ShapePair> near_self_pairs(std::span<const ShapePair> all, std::span<const Workspace::Ball> balls,
                                                         std::size_t first, double margin, Workspace::NearPairs& known);

}  // namespace ugoki::collision
