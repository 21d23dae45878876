#pragma once
// assimp's own BVH reader.

#include <cstddef>
#include <string>
#include <vector>

namespace ugoki::benchmarks {

struct AssimpMotion {
  std::size_t joints = 0, keys = 0;  ///< animated nodes; keys of the first of them
  std::vector<double> root;          ///< position of the root in every frame, file units
};
/// Throws where assimp refuses.
[[nodiscard]] AssimpMotion read_bvh_with_assimp(const std::string& text);

}  // namespace ugoki::benchmarks
