#pragma once
// The search of bubble.h, compiled for each width of registers (bubble_width.h). Plain data only: see spatial/lanes.h.
//
// Bounds are tested in float: a block of eight against one, in the block's frame. `slack` covers all rounding there, so that a
// pair is dropped only where its true distance is not below the limit. Triangles are tested in double.

#include <cstddef>
#include <cstdint>

#include "ugoki/collision/bound_block.h"

namespace ugoki::collision {

struct KernelTree {
  const BoundBlock* blocks;
  const double* vertices;         ///< [3 * vertices]
  const std::int32_t* triangles;  ///< [3 * triangles]
};

/// Two lanes of bounds (block * block_lanes + lane), and the square of a lower bound of their distance.
struct KernelEntry {
  std::int32_t a, b;
  float gap2;
};
struct KernelPair {
  std::int32_t a, b;
};

/// Row by row, and the translation.
template <class Real>
struct KernelPose {
  Real R[3][3], p[3];
};

struct KernelQuery {
  KernelTree a, b;
  KernelPose<double> X_AB;  ///< coordinates of b into a, each about the centre of its tree
  KernelPose<float> X_AB_f, X_BA_f;
  float slack;              ///< m
  float towards_b[3];       ///< unit, a's frame: about from a's nearest point to b's; zero where unknown. A good one saves tests
  double best2;             ///< m^2, in and out: what is not closer is of no interest
  double shrink;            ///< 1 / (1 + relative error), once there is a nearest pair
  KernelPair nearest;       ///< in and out: the pair whose distance best2 is, or -1, -1
  KernelEntry* stack;       ///< stack_size(...) entries
  KernelPair* pairs;        ///< all pairs closer than best2 at the start, at most `room`; null: the nearest only
  std::size_t room, found;  ///< found: out, may exceed room by one: there are more
  std::int32_t bound_tests, triangle_tests;  ///< out
};

struct BubbleKernel {
  void (*search)(KernelQuery&);
};

/// The kernel for the widest registers that this processor has.
[[nodiscard]] const BubbleKernel& bubble_kernel();

enum class BubbleWidth : std::uint8_t { plain, avx2, avx512 };
/// For tests and measurements, before other threads run. @return false where the processor or the build lacks it
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
