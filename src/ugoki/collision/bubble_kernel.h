#pragma once
// Interface of the mesh search of bubble.h, which is compiled once per SIMD width (bubble_width.h). Plain data only, for the reason given
// in spatial/lanes.h.
//
// Bounds (spheres and boxes of the trees) are tested in float: a block of eight bounds against one bound, in the block's frame.
// KernelQuery::slack covers the rounding errors of these tests, so that no pair closer than the search radius is dropped. Triangles are
// tested in double.

#include <cstddef>
#include <cstdint>

#include "ugoki/collision/bound_block.h"

namespace ugoki::collision {

/// View of a SphereTree.
struct KernelTree {
  const BoundBlock* blocks;
  const double* vertices;         ///< [3 * vertices] m, x, y, z of each vertex
  const std::int32_t* triangles;  ///< [3 * triangles] indices of vertices
};

/// A pair of bounds on the stack of the search, one of each tree. a, b: index of a bound, block * block_lanes + lane; gap2: m^2, squared
/// lower bound of the distance between the bounds.
struct KernelEntry {
  std::int32_t a, b;
  float gap2;
};
/// Indices of two triangles.
struct KernelPair {
  std::int32_t a, b;
};

/// A pose: the rotation matrix by rows, and the translation [m].
template <class Real>
struct KernelPose {
  Real R[3][3], p[3];
};

/// Input, output and scratch memory of one search.
struct KernelQuery {
  KernelTree a, b;
  KernelPose<double> X_AB;           ///< pose of b in a; the frames' origins are the centres of the trees
  KernelPose<float> X_AB_f, X_BA_f;  ///< X_AB in float, and its inverse, for the tests of bounds
  float slack;                       ///< m: upper bound of the rounding errors in the tests of bounds
  float towards_b[3];  ///< unit, a's frame: estimated direction from a's closest point to b's; zero: unknown. A good estimate saves tests
  double best2;        ///< m^2 [in, out]: squared search radius; afterwards squared distance between the triangles in `nearest`
  double shrink;       ///< 1 / (1 + relative_error): factor of the search radius once `nearest` is set
  KernelPair nearest;  ///< [in, out] the pair of triangles with squared distance best2; -1, -1: none
  KernelEntry* stack;  ///< [stack_size()] scratch memory
  KernelPair* pairs;   ///< [out, room] all pairs of triangles closer than the initial search radius; null: find only the closest pair
  std::size_t room, found;                   ///< room: capacity of `pairs`; found: [out] count of pairs, room + 1 if they do not fit
  std::int32_t bound_tests, triangle_tests;  ///< [out] counts of tests
};

struct BubbleKernel {
  void (*search)(KernelQuery&);
};

/// The kernel for the widest SIMD registers of this processor.
[[nodiscard]] const BubbleKernel& bubble_kernel();

enum class BubbleWidth : std::uint8_t { plain, avx2, avx512 };
/// Selects a kernel, for tests and benchmarks. Call it before other threads run.
/// @return false if the processor or the build does not support this width
bool use_bubble_width(BubbleWidth width);

namespace plain {
extern const BubbleKernel bubble_table;
}
#ifdef UGOKI_X86_WIDTHS
namespace avx2 {
extern const BubbleKernel bubble_table;
}
namespace avx512 {
extern const BubbleKernel bubble_table;
}
#endif

}  // namespace ugoki::collision
