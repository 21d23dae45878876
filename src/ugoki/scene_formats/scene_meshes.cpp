#include "ugoki/scene_formats/scene_meshes.h"

#include <assimp/material.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <utility>

#include "ugoki/formats/text.h"

namespace ugoki::scene_formats {
namespace {

constexpr double max_coordinate = 1e9;   // file units
constexpr double cutoff_of_hair = 0.35;  // alpha; without sorting, a cut-off looks better than blending

double real(ai_real x) { return static_cast<double>(x); }
double linear_of_srgb(double x) { return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4); }
bool plausible(const aiVector3D& v) {
  return std::fabs(real(v.x)) <= max_coordinate && std::fabs(real(v.y)) <= max_coordinate && std::fabs(real(v.z)) <= max_coordinate;
}

/// Place of the mesh of a bone: `place` of its node after the matrix from the mesh to the bone.
formats::FileBone bone_of(const NodePlace& place, const aiMatrix4x4& m) {
  const Mat3 M{real(m.a1), real(m.a2), real(m.a3), real(m.b1), real(m.b2), real(m.b3), real(m.c1), real(m.c2), real(m.c3)};
  return {place.joint, place.A * M, place.A * Vec3{real(m.a4), real(m.b4), real(m.c4)} + place.p};
}

class MeshCollector {
 public:
  MeshCollector(const aiScene& scene, const NodePlaces& places, const std::string& location)
      : scene_(scene), places_(places), location_(location), textures_(scene) {}

  Result<SceneMeshes> collect() {
    std::vector<const aiNode*> nodes;
    if (scene_.mRootNode) nodes.push_back(scene_.mRootNode);
    for (std::size_t i = 0; i < nodes.size(); ++i) {  // without recursion, so that no depth exhausts the stack
      const aiNode& node = *nodes[i];
      for (unsigned m = 0; m < node.mNumMeshes; ++m)
        if (!add(*scene_.mMeshes[node.mMeshes[m]], node)) return fail(std::move(error_));
      nodes.insert(nodes.end(), node.mChildren, node.mChildren + node.mNumChildren);
    }
    out_.textures = textures_.take();
    return std::move(out_);
  }

 private:
  Skin& skin() { return out_.file.skin; }
  void remark(const std::string& sentence) {
    if (std::ranges::find(out_.remarks, sentence) == out_.remarks.end()) out_.remarks.push_back(sentence);
  }
  bool refuse(std::string message) {
    error_.add(ErrorCode::range, location_, std::move(message), "Reduce the mesh of the character in a modelling program.");
    return false;
  }

  /// Index of a bone; bones of several meshes that are alike are one.
  std::uint16_t bone_index(std::string_view name, const NodePlace& place, const aiMatrix4x4& offset) {
    std::string key(name);
    key.append(reinterpret_cast<const char*>(&offset), sizeof offset);
    const auto [known, is_new] = bones_.try_emplace(std::move(key), static_cast<std::uint16_t>(out_.file.bones.size()));
    if (is_new) out_.file.bones.push_back(bone_of(place, offset));
    return known->second;
  }

  /// Adds a mesh. @return false: the limits of skins are exceeded
  bool add(const aiMesh& mesh, const aiNode& node) {
    if (mesh.mNumVertices == 0 || !std::all_of(mesh.mVertices, mesh.mVertices + mesh.mNumVertices, plausible)) return true;
    std::optional<std::uint16_t> any;  // a bone of the mesh, for vertices without weights
    std::vector<std::vector<std::pair<std::uint16_t, double>>> shares(mesh.mNumVertices);
    for (unsigned b = 0; b < mesh.mNumBones; ++b) {
      const aiBone& bone = *mesh.mBones[b];
      const auto place = places_.find(std::string_view(bone.mName.C_Str()));
      if (place == places_.end() || bone.mNumWeights == 0) continue;
      const std::uint16_t index = bone_index(place->first, place->second, bone.mOffsetMatrix);
      if (!any) any = index;
      for (unsigned w = 0; w < bone.mNumWeights; ++w)
        if (bone.mWeights[w].mVertexId < mesh.mNumVertices)
          shares[bone.mWeights[w].mVertexId].emplace_back(index, real(bone.mWeights[w].mWeight));
    }
    if (!any) {
      const auto place = places_.find(std::string_view(node.mName.C_Str()));
      if (place == places_.end()) {
        remark("Meshes that follow no joint of the character are left out.");
        return true;
      }
      any = bone_index(place->first, place->second, {});
    }
    for (auto& of_vertex : shares) {
      if (of_vertex.empty()) of_vertex.emplace_back(*any, 1);
      formats::add_weights(skin(), of_vertex);
    }
    add_triangles(mesh);
    if (mesh.mNumAnimMeshes > 0) remark("Morph targets, such as shapes of the face, are left out.");
    if (skin().vertex_count() > max_skin_vertices || skin().triangle_count() > max_skin_triangles)
      return refuse("The character has more than " + std::to_string(max_skin_vertices / 1000) + " thousand vertices or " +
                    std::to_string(max_skin_triangles / 1'000'000) + " million triangles.");
    if (out_.file.bones.size() > max_skin_bones || skin().parts.size() > max_skin_parts)
      return refuse("The character has more than " + std::to_string(max_skin_bones) + " bones or " + std::to_string(max_skin_parts) +
                    " parts.");
    return true;
  }

  void add_triangles(const aiMesh& mesh) {
    const std::size_t base = skin().vertex_count(), first = skin().indices.size();
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      const aiVector3D& p = mesh.mVertices[v];
      skin().positions.insert(skin().positions.end(), {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
    }
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices != 3) continue;  // points and lines
      if (std::any_of(face.mIndices, face.mIndices + 3, [&](unsigned i) { return i >= mesh.mNumVertices; })) continue;
      for (unsigned k = 0; k < 3; ++k) skin().indices.push_back(static_cast<std::uint32_t>(base + face.mIndices[k]));
    }
    add_surface_normals(mesh, base, first);
    SkinPart part = part_of(mesh);
    const unsigned set = uv_set_of(scene_, mesh);
    if (!mesh.HasTextureCoords(set)) part.texture = -1;
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      const aiVector3D uv = mesh.HasTextureCoords(set) ? mesh.mTextureCoords[set][v] : aiVector3D();
      const bool finite = std::isfinite(real(uv.x)) && std::isfinite(real(uv.y));
      // these formats count from the lower left corner of the picture
      skin().uvs.insert(skin().uvs.end(), {finite ? static_cast<float>(uv.x) : 0.0f, finite ? static_cast<float>(1 - uv.y) : 0.0f});
    }
    add_vertex_colors(mesh, base);
    part.first = static_cast<std::uint32_t>(first);
    part.count = static_cast<std::uint32_t>(skin().indices.size() - first);
    if (part.count > 0) skin().parts.push_back(std::move(part));
  }

  /// Adds the colours of the vertices, which are those of sRGB in these formats.
  void add_vertex_colors(const aiMesh& mesh, std::size_t base) {
    std::vector<double> linear;
    for (unsigned v = 0; mesh.HasVertexColors(0) && v < mesh.mNumVertices; ++v)
      for (const ai_real x : {mesh.mColors[0][v].r, mesh.mColors[0][v].g, mesh.mColors[0][v].b}) linear.push_back(linear_of_srgb(real(x)));
    formats::add_colors(skin(), base, linear);
  }

  void add_surface_normals(const aiMesh& mesh, std::size_t base, std::size_t first) {
    if (!mesh.HasNormals()) return formats::add_normals(skin(), base, first);
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      const aiVector3D& a = mesh.mNormals[v];
      Vec3 n{real(a.x), real(a.y), real(a.z)};
      n = is_finite(n) ? normalized(n, {0, 0, 1}) : Vec3{0, 0, 1};
      for (int k = 0; k < 3; ++k) skin().normals.push_back(static_cast<float>(n[k]));
    }
  }

  /// Colour and texture of a mesh. The colours of these formats are those of sRGB. A texture replaces the colour.
  SkinPart part_of(const aiMesh& mesh) {
    SkinPart part;
    if (mesh.mMaterialIndex >= scene_.mNumMaterials) return part;
    const aiMaterial& material = *scene_.mMaterials[mesh.mMaterialIndex];
    aiString opacity;
    if (const std::string path = color_texture_of(material); !path.empty()) {
      part.texture = textures_.index_of(path);
      if (material.GetTexture(aiTextureType_OPACITY, 0, &opacity) == aiReturn_SUCCESS) part.cutoff = cutoff_of_hair;
    }
    aiColor4D color(1, 1, 1, 1);
    if (part.texture < 0 && material.Get(AI_MATKEY_BASE_COLOR, color) != aiReturn_SUCCESS)
      (void)material.Get(AI_MATKEY_COLOR_DIFFUSE, color);
    char text[8];
    const auto byte = [](ai_real x) { return static_cast<unsigned>(std::lround(255 * (real(x) > 0 ? std::min(real(x), 1.0) : 0.0))); };
    std::snprintf(text, sizeof text, "#%02x%02x%02x", byte(color.r), byte(color.g), byte(color.b));
    part.color = text;
    int both = 0;
    part.both_sides = material.Get(AI_MATKEY_TWOSIDED, both) == aiReturn_SUCCESS && both != 0;
    return part;
  }

  const aiScene& scene_;
  const NodePlaces& places_;
  const std::string& location_;
  SceneMeshes out_;
  std::map<std::string, std::uint16_t> bones_;  ///< by name and matrix
  SceneTextures textures_;
  Error error_;
};

}  // namespace

Result<SceneMeshes> collect_meshes(const aiScene& scene, const NodePlaces& places, const std::string& location) {
  return MeshCollector(scene, places, location).collect();
}

}  // namespace ugoki::scene_formats
