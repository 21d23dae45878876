#pragma once
// The two stages of make_sphere_tree(): ordering of the triangles, then fitting of the bounds. Internal to collision/.

#include <cstdint>
#include <span>
#include <vector>

#include "ugoki/collision/sphere_tree.h"

namespace ugoki::collision::build {

/// Returns the indices of the triangles, ordered so that triangles near each other in space are near each other in the list. Both stages
/// split the list at the same indices.
[[nodiscard]] std::vector<std::int32_t> order_triangles(std::span<const Vec3> vertices, std::span<const Triangle> triangles,
                                                        const Vec3& centre);

/// Fills tree.blocks. The triangles must be in the order of order_triangles().
void fit_bounds(SphereTree& tree);

}  // namespace ugoki::collision::build
