#pragma once
// The two halves of make_sphere_tree(). Internal to collision/.

#include <cstdint>
#include <span>
#include <vector>

#include "ugoki/collision/sphere_tree.h"

namespace ugoki::collision::build {

/// The triangles so that neighbours in space are neighbours in the list; fit_bounds() cuts it at the same places.
[[nodiscard]] std::vector<std::int32_t> order_triangles(std::span<const Vec3> vertices, std::span<const Triangle> triangles,
                                                        const Vec3& centre);

/// Blocks over triangles that are in order.
void fit_bounds(SphereTree& tree);

}  // namespace ugoki::collision::build
