#pragma once
// Parses mesh files with assimp, without protection. Internal to scene_formats.

#include "ugoki/scene_formats/mesh_scene.h"
#include "ugoki/scene_formats/scene_textures.h"

namespace ugoki::scene_formats {

/// A mesh whose textures are not loaded yet: MeshPart::texture is an index in `textures`.
struct ParsedMesh {
  MeshScene scene;
  std::vector<SceneTexture> textures;
};

/// The same as read_mesh_scene(), but in the calling process, without limits on time and memory, and without loading textures.
[[nodiscard]] Result<ParsedMesh> parse_mesh_scene(std::span<const std::byte> bytes, std::string_view file_name, const MeshOptions& options,
                                                  formats::ReadNotes& notes);

}  // namespace ugoki::scene_formats
