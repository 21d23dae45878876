#pragma once
// Meshes of assimp's scene that follow the joints of a character. Internal to scene_formats.

#include <assimp/scene.h>

#include <string>
#include <vector>

#include "ugoki/formats/file_skin.h"
#include "ugoki/scene_formats/scene_places.h"
#include "ugoki/scene_formats/scene_textures.h"

namespace ugoki::scene_formats {

/// A skin whose textures are not loaded yet: SkinPart::texture is an index in `textures`.
struct SceneMeshes {
  formats::FileSkin file;
  std::vector<SceneTexture> textures;
  std::vector<std::string> remarks;  ///< sentences about parts that are left out
};

/// Collects the meshes whose bones, or whose node, have a place. Meshes that would exceed the limits of skins are an error.
/// @param scene with triangles only
[[nodiscard]] Result<SceneMeshes> collect_meshes(const aiScene& scene, const NodePlaces& places, const std::string& location);

}  // namespace ugoki::scene_formats
