#pragma once
// Contents whose state hashes are kept in hashes.txt: equal for every compiler, target, SIMD width and number of threads.

#include <cstddef>
#include <string>
#include <vector>

namespace ugoki::golden {

/// A content as executable data.
struct GoldenContent {
  std::string name;
  std::vector<std::byte> ugx;
};

/// Steps after which hashes.txt has a state hash. The fast tests run the first `fast_checkpoints` of them.
inline constexpr long checkpoints[] = {1, 100, 500, 2000, 10000};
inline constexpr int fast_checkpoints = 3;

/// The sample content, a walking human, a heap of bodies of all convex shapes, a robot with closed legs and a chain. The last three fall
/// onto the ground.
[[nodiscard]] std::vector<GoldenContent> make_contents();

}  // namespace ugoki::golden
