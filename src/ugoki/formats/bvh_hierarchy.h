#pragma once
// The HIERARCHY section of a BVH file. Internal to formats.

#include <optional>
#include <vector>

#include "ugoki/formats/file_axes.h"
#include "ugoki/formats/text.h"

namespace ugoki::formats {

/// A channel: one of the values in each frame of the file.
struct BvhChannel {
  int joint = 0;          ///< index in Skeleton::joints
  bool rotation = false;  ///< true: rotation about the axis; false: position along it
  int axis = 0;           ///< axis of the file: 0 x, 1 y, 2 z
};

struct BvhHierarchy {
  Skeleton skeleton;                 ///< in Ugoki's axes, but with lengths in file units
  std::vector<BvhChannel> channels;  ///< in the order of the values of a frame
  std::vector<std::string> remarks;  ///< sentences for ReadNotes::remarks
};

/// Reads from the beginning of the file up to and including the word MOTION. Returns std::nullopt if it added problems.
[[nodiscard]] std::optional<BvhHierarchy> read_bvh_hierarchy(Scanner& scanner, const FileAxes& axes, Problems& problems);

}  // namespace ugoki::formats
