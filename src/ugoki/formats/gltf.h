#pragma once
// glTF 2.0 (.gltf, .glb): skeletons and their animations. The dialect is described in docs/formats.md.

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/formats/read_notes.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::formats {

/// Gives the bytes of a file that stands beside a .gltf file; called with the URI as written, percent escapes resolved.
using GltfFiles = std::function<Result<std::vector<std::byte>>(std::string_view uri)>;

struct GltfOptions {
  double rate = 0;             ///< frames a second to sample the animations at; 0: that of the densest keys
  double metres_per_unit = 0;  ///< 0: metres, as the format demands, unless the skeleton's size is out of all proportion
  GltfFiles files = {};        ///< null: buffers in other files are refused
};

/// Reads all animations of a file from memory: one measured motion for each, on the skeleton of all skins' joints and the nodes between and
/// above them (files without skins: all nodes). A file without animations gives one frame at rest. Rest is the skin's bind pose.
/// Scales are folded into the joints' positions, so that world positions are those of the file.
/// Errors: with file and JSON path (or chunk), each with a remedy. O(bytes + frames * joints).
[[nodiscard]] Result<std::vector<MeasuredMotion>> read_gltf(std::span<const std::byte> bytes, std::string_view file_name,
                                                            const GltfOptions& options = {}, ReadNotes* notes = nullptr);

/// The motion as a binary glTF file: Y up, metres, one node for each joint, a skin, a mesh of bones that moves with it, one animation with
/// a key for every frame. World positions of joints come back to single precision.
[[nodiscard]] std::vector<std::byte> write_glb(const MeasuredMotion& motion);

}  // namespace ugoki::formats
