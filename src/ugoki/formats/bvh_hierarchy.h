#pragma once
// The HIERARCHY part of a BVH file. Internal to formats.

#include <optional>
#include <vector>

#include "ugoki/formats/file_axes.h"
#include "ugoki/formats/text.h"

namespace ugoki::formats {

struct BvhChannel {
  int joint = 0;
  bool rotation = false;
  int axis = 0;  ///< of the file: 0 x, 1 y, 2 z
};

struct BvhHierarchy {
  Skeleton skeleton;                 ///< lengths still in the file's units, axes already ours
  std::vector<BvhChannel> channels;  ///< in the order of the numbers of a frame
  std::vector<std::string> remarks;
};

/// Reads up to and including the word MOTION. Problems are added; nothing is returned if there were any.
[[nodiscard]] std::optional<BvhHierarchy> read_bvh_hierarchy(Scanner& scanner, const FileAxes& axes, Problems& problems);

}  // namespace ugoki::formats
