#pragma once
// Parses mesh files with assimp, without protection. Internal to scene_formats.

#include "ugoki/scene_formats/mesh_scene.h"

namespace ugoki::scene_formats {

/// The same as read_mesh_scene(), but in the calling process, without limits on time and memory.
[[nodiscard]] Result<MeshScene> parse_mesh_scene(std::span<const std::byte> bytes, std::string_view file_name, const MeshOptions& options,
                                                 formats::ReadNotes& notes);

}  // namespace ugoki::scene_formats
