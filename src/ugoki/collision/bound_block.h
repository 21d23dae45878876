#pragma once
// The bounds of a sphere tree as they lie in memory. Plain data, so that kernels can include it.

#include <cstdint>

namespace ugoki::collision {

inline constexpr int block_lanes = 8;

/// Up to eight bounds that have the same parent, side by side, so that all are tested at once. Lengths in m about
/// SphereTree::centre, rounded outwards: each bound holds all its triangles.
struct BoundBlock {
  float sphere[3][block_lanes];     ///< centre, on the surface to within rounding
  float radius[block_lanes];        ///< of the sphere about it
  float box[3][block_lanes];        ///< centre of the box
  float axis[2][3][block_lanes];    ///< unit: two of the box's axes; the third is their cross product
  float half[3][block_lanes];       ///< half extents along the three axes
  std::int32_t child[block_lanes];  ///< the block of its children, or -1 - triangle
  std::int32_t count;               ///< lanes in use
};

}  // namespace ugoki::collision
