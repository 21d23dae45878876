#pragma once
// Contents whose state hashes are listed in hashes.txt. The hashes are equal for every compiler, target, SIMD width and number of threads.

#include <cstddef>
#include <string>
#include <vector>

namespace ugoki::golden {

/// Content in the form of executable data (*.ugx).
struct GoldenContent {
  std::string name;
  std::vector<std::byte> ugx;
};

/// Numbers of steps after which hashes.txt has a state hash. The fast tests compare only the first `fast_checkpoints` of these.
inline constexpr long checkpoints[] = {1, 100, 500, 2000, 10000};
inline constexpr int fast_checkpoints = 3;

/// The sample content, a walking human, a heap of bodies of all convex shapes, a robot with closed legs and a chain. The last three fall
/// onto the ground.
[[nodiscard]] std::vector<GoldenContent> make_contents();

}  // namespace ugoki::golden
