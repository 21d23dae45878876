#pragma once
// Memory layout of the bounds of a sphere tree. Plain data, so that the SIMD kernels can include this header.

#include <cstdint>

namespace ugoki::collision {

inline constexpr int block_lanes = 8;

/// Up to eight bounds (nodes of the tree) with the same parent, stored lane by lane so that one SIMD test covers all of them. A bound is a
/// sphere and an oriented box. Each of them contains all triangles of the node (values are rounded outwards). Frame: the axes of the mesh,
/// with SphereTree::centre as origin. Lengths in m.
struct BoundBlock {
  float sphere[3][block_lanes];     ///< x, y, z of the sphere's centre, a point of the mesh surface up to rounding
  float radius[block_lanes];        ///< radius of the sphere
  float box[3][block_lanes];        ///< x, y, z of the box's centre
  float axis[2][3][block_lanes];    ///< unit vectors: two of the box's axes; the third is their cross product
  float half[3][block_lanes];       ///< half extents of the box along its three axes
  std::int32_t child[block_lanes];  ///< index of the block that contains the children; a leaf: -1 - index of its triangle
  std::int32_t count;               ///< count of lanes in use
};

}  // namespace ugoki::collision
