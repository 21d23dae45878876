#include "ugoki/scene_formats/scene_textures.h"

#include <assimp/material.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "ugoki/formats/text.h"

namespace ugoki::scene_formats {

int SceneTextures::index_of(const std::string& path) {
  const auto [known, is_new] = known_.try_emplace(path, static_cast<int>(list_.size()));
  if (!is_new) return known->second;
  SceneTexture texture;
  const aiTexture* own = scene_.GetEmbeddedTexture(path.c_str());
  if (own && own->mHeight == 0 && own->pcData) {
    const auto* data = reinterpret_cast<const std::byte*>(own->pcData);
    texture.data.assign(data, data + own->mWidth);
  }
  if (texture.data.empty()) texture.path = path;
  list_.push_back(std::move(texture));
  return known->second;
}

std::string color_texture_of(const aiMaterial& material) {
  aiString path;
  for (const aiTextureType type : {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE})
    if (material.GetTexture(type, 0, &path) == aiReturn_SUCCESS) return path.C_Str();
  return {};
}

unsigned uv_set_of(const aiScene& scene, const aiMesh& mesh) {
  int set = 0;
  if (mesh.mMaterialIndex < scene.mNumMaterials)
    (void)scene.mMaterials[mesh.mMaterialIndex]->Get(AI_MATKEY_UVWSRC(aiTextureType_DIFFUSE, 0), set);
  const bool known = set > 0 && set < AI_MAX_NUMBER_OF_TEXTURECOORDS && mesh.HasTextureCoords(static_cast<unsigned>(set));
  return known ? static_cast<unsigned>(set) : 0;
}

std::vector<int> load_textures(std::vector<SceneTexture> from, const std::function<Result<std::vector<std::byte>>(std::string_view)>& files,
                               std::string_view owner, std::vector<SkinTexture>& out, formats::ReadNotes& notes) {
  std::vector<int> place(from.size(), -1);
  std::size_t together = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    auto& [path, data] = from[i];
    const std::string name = path.substr(path.find_last_of("/\\") + 1);
    if (!path.empty()) {
      Result<std::vector<std::byte>> found = files ? files(path) : fail(ErrorCode::io, path, "", "");
      if (!found && files && name != path) found = files(name);  // paths of the machine on which the file was made
      if (!found) {
        notes.remarks.push_back("The texture " + formats::in_quotes(name) + " is not beside the file; choose it together with " +
                                std::string(owner) + " to see it.");
        continue;
      }
      data = std::move(*found);
    }
    SkinTexture texture;
    const std::optional<PictureSize> size = picture_size(data, texture.type);
    if (!size || std::max(size->width, size->height) > max_texture_side || data.size() > max_texture_bytes ||
        together + data.size() > max_skin_bytes) {
      notes.remarks.push_back("The texture " + formats::in_quotes(name) + " is left out: textures are PNG or JPEG, with at most " +
                              std::to_string(max_texture_side) + " pixels a side and " + std::to_string(max_texture_bytes >> 20) + " MB.");
      continue;
    }
    together += data.size();
    texture.data = std::move(data);
    place[i] = static_cast<int>(out.size());
    out.push_back(std::move(texture));
  }
  return place;
}

}  // namespace ugoki::scene_formats
