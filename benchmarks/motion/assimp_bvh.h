#pragma once
// assimp's own BVH reader.

#include <cstddef>
#include <string>
#include <vector>

namespace ugoki::benchmarks {

struct AssimpMotion {
  std::size_t joints = 0, keys = 0;  ///< number of animated nodes; number of keys of the first one
  std::vector<double> root;          ///< position of the root in every animation frame, in the file's units
};
/// Throws if assimp refuses the file.
[[nodiscard]] AssimpMotion read_bvh_with_assimp(const std::string& text);

}  // namespace ugoki::benchmarks
