#pragma once
// Pictures to which the materials of assimp's scene refer. Internal to scene_formats.

#include <assimp/scene.h>

#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/formats/read_notes.h"
#include "ugoki/mechanism/skin.h"

namespace ugoki::scene_formats {

struct SceneTexture {
  std::string path;             ///< as the file names it; empty: the file contains the picture
  std::vector<std::byte> data;  ///< empty if `path` is not
};

/// The pictures of a scene, each once. They are not loaded.
class SceneTextures {
 public:
  explicit SceneTextures(const aiScene& scene) : scene_(scene) {}

  /// Index of the picture with this path in the file; adds it.
  int index_of(const std::string& path);
  [[nodiscard]] std::vector<SceneTexture> take() { return std::move(list_); }

 private:
  const aiScene& scene_;
  std::vector<SceneTexture> list_;
  std::map<std::string, int> known_;  ///< by the path in the file
};

/// Path of the picture that gives the colour of a material; empty: there is none.
[[nodiscard]] std::string color_texture_of(const aiMaterial& material);
/// Set of texture coordinates of the picture that a mesh shows.
[[nodiscard]] unsigned uv_set_of(const aiScene& scene, const aiMesh& mesh);

/// Loads pictures and moves those that can be shown to `out`; reports the others.
/// @param files reads pictures beside the file, by the name that the file gives; null: they are left out
/// @param owner what the pictures are to be chosen with: "the character's file"
/// @return [from] index in `out`; -1: left out
[[nodiscard]] std::vector<int> load_textures(std::vector<SceneTexture> from,
                                             const std::function<Result<std::vector<std::byte>>(std::string_view)>& files,
                                             std::string_view owner, std::vector<SkinTexture>& out, formats::ReadNotes& notes);

}  // namespace ugoki::scene_formats
