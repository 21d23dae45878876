#pragma once
// glTF 2.0 (.gltf, .glb): skeletons and their animations. docs/formats.md describes the supported subset.

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

/// Returns the bytes of a file to which a .gltf file refers by a relative URI. The URI is passed with percent escapes resolved.
using GltfFiles = std::function<Result<std::vector<std::byte>>(std::string_view uri)>;

struct GltfOptions {
  double rate = 0;             ///< frames per second at which animations are sampled; 0: the rate of the most closely spaced keys
  double metres_per_unit = 0;  ///< m per file unit; 0: 1 as glTF specifies; guessed if the skeleton would exceed 20 m or be below 1 cm
  bool mesh_ends = false;      ///< gives joints without children the far ends of their meshes as end sites; otherwise they have none
  GltfFiles files = {};        ///< reads buffers that are in other files; null: a .gltf file with such buffers is rejected
};

/// Reads all animations of a file from memory and returns one measured motion for each. The skeleton consists of the joints of all skins,
/// the nodes between them, and the animated nodes above them. In a file without skins it consists of all nodes. A file that animates no
/// joint gives one frame at rest. The rest pose is the bind pose of the skin. Scales are included in the positions of the joints, so that
/// the world positions equal those of the file.
/// Errors have the location "file:JSON path" or "file:chunk", and a remedy. O(bytes + frames * joints).
[[nodiscard]] Result<std::vector<MeasuredMotion>> read_gltf(std::span<const std::byte> bytes, std::string_view file_name,
                                                            const GltfOptions& options = {}, ReadNotes* notes = nullptr);

/// Returns the motion as a binary glTF file: Y up, metres, one node for each joint, a skin, a mesh of bones bound to the skin, and one
/// animation with a key for every frame. World positions of the joints have single precision.
[[nodiscard]] std::vector<std::byte> write_glb(const MeasuredMotion& motion);

}  // namespace ugoki::formats
