// Converts assimp's scene of a mesh file to vertices, triangles and colours.

#include "ugoki/scene_formats/mesh_parser.h"

#include <assimp/config.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include "ugoki/formats/text.h"
#include "ugoki/scene_formats/collada_core.h"
#include "ugoki/scene_formats/scene_joints.h"
#include "ugoki/scene_formats/scene_metadata.h"

namespace ugoki::scene_formats {
namespace {

constexpr std::size_t max_nodes = 100'000;
constexpr std::size_t max_parts = 64;    // materials; triangles of further materials get no colour
constexpr double usual_cutoff = 0.5;     // alpha below which nothing is drawn, as in glTF
constexpr double blended_cutoff = 0.35;  // alpha; without sorting, a cut-off looks better than blending
constexpr double max_coordinate = 1e6;   // m
constexpr const char* again = "Export the mesh again.";

std::string ending_of(std::string_view file_name) {
  const std::size_t dot = file_name.rfind('.');
  std::string ending(dot == std::string_view::npos ? std::string_view() : file_name.substr(dot + 1));
  std::transform(ending.begin(), ending.end(), ending.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  return ending;
}

/// A file in memory.
class MemoryStream : public Assimp::IOStream {
 public:
  explicit MemoryStream(std::vector<std::byte> bytes) : bytes_(std::move(bytes)) {}
  std::size_t Read(void* out, std::size_t size, std::size_t count) override {
    if (size == 0) return 0;
    const std::size_t whole = std::min(count, (bytes_.size() - at_) / size);
    if (whole > 0) std::memcpy(out, bytes_.data() + at_, whole * size);
    at_ += whole * size;
    return whole;
  }
  std::size_t Write(const void*, std::size_t, std::size_t) override { return 0; }
  aiReturn Seek(std::size_t offset, aiOrigin origin) override {
    const std::size_t base = origin == aiOrigin_SET ? 0 : origin == aiOrigin_CUR ? at_ : bytes_.size();
    if (offset > bytes_.size() - base) return aiReturn_FAILURE;
    at_ = base + offset;
    return aiReturn_SUCCESS;
  }
  std::size_t Tell() const override { return at_; }
  std::size_t FileSize() const override { return bytes_.size(); }
  void Flush() override {}

 private:
  std::vector<std::byte> bytes_;
  std::size_t at_ = 0;
};

/// The files that the parser may open: the mesh file and its companions, by their names without folders.
class MemoryFiles : public Assimp::IOSystem {
 public:
  /// @param missing [out] names of files that the parser wanted to open, but that were not given
  MemoryFiles(std::string main, std::span<const std::byte> bytes, const MeshCompanions& companions, std::vector<std::string>& missing)
      : main_(std::move(main)), bytes_(bytes), companions_(companions), missing_(missing) {}
  bool Exists(const char* path) const override { return find(path).has_value(); }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* path, const char*) override {
    std::optional<std::vector<std::byte>> found = find(path);
    const std::string_view all(path);
    if (!found) missing_.emplace_back(all.substr(all.find_last_of("/\\") + 1));
    return found ? new MemoryStream(std::move(*found)) : nullptr;  // the library deletes it in Close()
  }
  void Close(Assimp::IOStream* stream) override { delete stream; }

 private:
  std::optional<std::vector<std::byte>> find(std::string_view path) const {
    const std::string_view name = path.substr(path.find_last_of("/\\") + 1);
    if (name == main_) return std::vector<std::byte>(bytes_.begin(), bytes_.end());
    if (!companions_) return std::nullopt;
    Result<std::vector<std::byte>> found = companions_(name);
    if (!found) return std::nullopt;
    return std::move(*found);
  }

  std::string main_;
  std::span<const std::byte> bytes_;
  const MeshCompanions& companions_;
  std::vector<std::string>& missing_;
};

Affine affine_of(const aiMatrix4x4& m) {
  const auto d = [](ai_real x) { return static_cast<double>(x); };
  return {{d(m.a1), d(m.a2), d(m.a3), d(m.b1), d(m.b2), d(m.b3), d(m.c1), d(m.c2), d(m.c3)}, {d(m.a4), d(m.b4), d(m.c4)}};
}

/// "#rrggbb" of a colour. @param linear true: the components are proportional to the light; false: they are those of sRGB
std::string color_text(const aiColor4D& color, bool linear) {
  char text[8];
  const auto byte = [&](ai_real component) {
    double x = static_cast<double>(component);
    if (!(x > 0)) x = 0;  // also for NaN
    x = std::min(x, 1.0);
    if (linear) x = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
    return static_cast<unsigned>(std::lround(255 * x));
  };
  std::snprintf(text, sizeof text, "#%02x%02x%02x", byte(color.r), byte(color.g), byte(color.b));
  return text;
}

class MeshParser {
 public:
  MeshParser(const aiScene& scene, std::string ending, std::string location, const MeshOptions& options, int collada_up,
             const std::vector<std::string>& missing, formats::ReadNotes& notes)
      : scene_(scene),
        ending_(std::move(ending)),
        location_(std::move(location)),
        options_(options),
        up_(collada_up),
        missing_(missing),
        notes_(notes),
        textures_(scene) {}

  Result<ParsedMesh> parse() {
    if (!scene_.mRootNode) return refuse(ErrorCode::structure, "The file has no nodes.");
    if (!missing_.empty())
      notes_.remarks.push_back("The file " + formats::in_quotes(missing_.front()) +
                               " with colours is missing; choose it together with the mesh to see them.");
    out_.animated = scene_.mNumAnimations > 0;
    std::vector<std::pair<const aiNode*, Affine>> nodes = {{scene_.mRootNode, affine_of(scene_.mRootNode->mTransformation)}};
    for (std::size_t i = 0; i < nodes.size(); ++i) {  // without recursion, so that no depth exhausts the stack
      const auto [node, X] = nodes[i];
      for (unsigned m = 0; m < node->mNumMeshes; ++m)
        if (!add(*scene_.mMeshes[node->mMeshes[m]], X)) return fail(std::move(error_));
      if (nodes.size() + node->mNumChildren > max_nodes)
        return refuse(ErrorCode::range, "The file has more than " + std::to_string(max_nodes) + " nodes.", "Join the objects in it.");
      for (unsigned c = 0; c < node->mNumChildren; ++c)
        nodes.emplace_back(node->mChildren[c], X * affine_of(node->mChildren[c]->mTransformation));
    }
    for (auto& [look, triangles] : by_look_) {
      const auto& [color, texture, tint, cutoff, both_sides] = look;
      out_.parts.push_back({color, std::move(triangles), texture, tint, cutoff, both_sides});
    }
    if (out_.parts.empty())
      return refuse(ErrorCode::structure, "The file has no triangles.", "Export the surface of the object, not only its points or lines.");
    to_metres();
    for (const Vec3& p : out_.vertices)
      if (!(std::fabs(p.x) <= max_coordinate && std::fabs(p.y) <= max_coordinate && std::fabs(p.z) <= max_coordinate))
        return refuse(ErrorCode::range, "A coordinate of a vertex is not finite or beyond 1e6 m.",
                      "Check the unit, or export the mesh again.");
    return ParsedMesh{std::move(out_), textures_.take()};
  }

 private:
  std::unexpected<Error> refuse(ErrorCode code, std::string message, std::string remedy = again) {
    return fail(code, location_, std::move(message), std::move(remedy));
  }

  /// Colour of a mesh; empty: the file gives none.
  std::string color_of(const aiMesh& mesh) {
    const bool gltf = ending_ == "glb" || ending_ == "gltf";
    if (mesh.HasVertexColors(0) && (ending_ == "ply" || ending_ == "stl")) {
      aiColor4D mean{0, 0, 0, 1};
      for (unsigned v = 0; v < mesh.mNumVertices; ++v)
        mean = mean + mesh.mColors[0][v] * (ai_real(1) / static_cast<ai_real>(mesh.mNumVertices));
      return color_text(mean, false);
    }
    if (mesh.mMaterialIndex >= scene_.mNumMaterials || ending_ == "ply" || ending_ == "stl" || !missing_.empty()) return {};
    const aiMaterial& material = *scene_.mMaterials[mesh.mMaterialIndex];
    if (aiString name; material.Get(AI_MATKEY_NAME, name) == aiReturn_SUCCESS && std::strcmp(name.C_Str(), AI_DEFAULT_MATERIAL_NAME) == 0)
      return {};
    aiColor4D color;
    if (material.Get(AI_MATKEY_BASE_COLOR, color) != aiReturn_SUCCESS && material.Get(AI_MATKEY_COLOR_DIFFUSE, color) != aiReturn_SUCCESS)
      return {};
    return color_text(color, gltf);
  }

  /// Colour, texture, colour that is multiplied with the texture, alpha cutoff, and whether both sides are drawn.
  using Look = std::tuple<std::string, int, std::string, double, bool>;

  Look look_of(const aiMesh& mesh, std::string color) {
    const std::string white = "#ffffff";
    if (mesh.mMaterialIndex >= scene_.mNumMaterials || !missing_.empty() || !mesh.HasTextureCoords(uv_set_of(scene_, mesh)))
      return {color, -1, white, 0, false};
    const aiMaterial& material = *scene_.mMaterials[mesh.mMaterialIndex];
    const std::string path = color_texture_of(material);
    if (path.empty()) return {color, -1, white, 0, false};
    // a texture replaces the colour of the other formats, whose programs often write a grey beside it
    const bool gltf = ending_ == "glb" || ending_ == "gltf";
    double cutoff = 0;
    aiString mode, opacity;
    if (gltf && material.Get("$mat.gltf.alphaMode", 0, 0, mode) == aiReturn_SUCCESS) {
      if (std::strcmp(mode.C_Str(), "BLEND") == 0) cutoff = blended_cutoff;
      if (std::strcmp(mode.C_Str(), "MASK") == 0) {
        ai_real given = usual_cutoff;
        (void)material.Get("$mat.gltf.alphaCutoff", 0, 0, given);
        cutoff = given >= 0 && given <= 1 ? static_cast<double>(given) : usual_cutoff;
      }
    } else if (material.GetTexture(aiTextureType_OPACITY, 0, &opacity) == aiReturn_SUCCESS) {
      cutoff = blended_cutoff;
    }
    int both = 0;
    const bool both_sides = material.Get(AI_MATKEY_TWOSIDED, both) == aiReturn_SUCCESS && both != 0;
    const std::string tint = gltf && !color.empty() ? color : white;
    return {std::move(color), textures_.index_of(path), tint, cutoff, both_sides};
  }

  /// Transform of texture coordinates (KHR_texture_transform): offset + R(rotation) scale uv, with (0, 0) at the top left corner.
  struct UvTransform {
    double offset[2] = {0, 0}, scale[2] = {1, 1}, c = 1, s = 0;  ///< c, s: cosine and sine of the rotation
  };

  /// The transform of the picture that a mesh of a glTF file shows. assimp stores it about the centre of the picture, with (0, 0) at the
  /// lower left corner; the terms of its importer (glTF2Importer.cpp) are subtracted.
  [[nodiscard]] UvTransform uv_transform_of(const aiMesh& mesh) const {
    UvTransform out;
    aiUVTransform t;
    if ((ending_ != "glb" && ending_ != "gltf") || mesh.mMaterialIndex >= scene_.mNumMaterials ||
        scene_.mMaterials[mesh.mMaterialIndex]->Get(AI_MATKEY_UVTRANSFORM(aiTextureType_BASE_COLOR, 0), t) != aiReturn_SUCCESS)
      return out;
    const double rotation = -static_cast<double>(t.mRotation), sx = static_cast<double>(t.mScaling.x),
                 sy = static_cast<double>(t.mScaling.y);
    out.scale[0] = sx;
    out.scale[1] = sy;
    out.c = std::cos(rotation);
    out.s = std::sin(rotation);
    out.offset[0] = static_cast<double>(t.mTranslation.x) - 0.5 * sx * (1 - out.c + out.s);
    out.offset[1] = 1 - sy - (static_cast<double>(t.mTranslation.y) - 0.5 * sy * (out.s + out.c - 1));
    return out;
  }

  /// Appends the vertices of a mesh with their normals and texture coordinates.
  void add_vertices(const aiMesh& mesh, const Affine& X) {
    const double side = X.M.determinant() < 0 ? -1 : 1;
    const Vec3 a = X.M.column(0), b = X.M.column(1), c = X.M.column(2);
    const Mat3 N = Mat3::columns(cross(b, c) * side, cross(c, a) * side, cross(a, b) * side);  // M^-T times |det M|: turns normals
    const unsigned set = uv_set_of(scene_, mesh);
    const UvTransform turn = uv_transform_of(mesh);
    const auto vector = [](const aiVector3D& v) {
      return Vec3{static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
    };
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      out_.vertices.push_back(X.M * vector(mesh.mVertices[v]) + X.p);
      const Vec3 n = mesh.HasNormals() ? N * vector(mesh.mNormals[v]) : Vec3{};
      out_.normals.push_back(is_finite(n) ? normalized(n, {}) : Vec3{});
      const aiVector3D uv = mesh.HasTextureCoords(set) ? mesh.mTextureCoords[set][v] : aiVector3D();
      // assimp counts from the lower left corner of the picture, for all formats
      const double x = turn.scale[0] * static_cast<double>(uv.x), y = turn.scale[1] * (1 - static_cast<double>(uv.y));
      for (const double w : {turn.offset[0] + turn.c * x + turn.s * y, turn.offset[1] - turn.s * x + turn.c * y})
        out_.uvs.push_back(std::isfinite(w) ? static_cast<float>(w) : 0.0F);
    }
  }

  bool add(const aiMesh& mesh, const Affine& X) {
    out_.skinned = out_.skinned || mesh.mNumBones > 0;
    Look look = look_of(mesh, color_of(mesh));
    if (!by_look_.contains(look) && by_look_.size() >= max_parts) look = {"", -1, "#ffffff", 0, false};
    std::vector<Triangle>& triangles = by_look_[look];
    const auto first = static_cast<std::int64_t>(out_.vertices.size());
    const bool mirrored = X.M.determinant() < 0;
    add_vertices(mesh, X);
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices != 3) continue;  // points and lines
      Triangle t{};
      for (unsigned k = 0; k < 3; ++k) {
        if (face.mIndices[k] >= mesh.mNumVertices)
          return wrong(ErrorCode::range, "A triangle refers to a vertex that does not exist.", again);
        t[k] = static_cast<std::int32_t>(first + face.mIndices[k]);
      }
      if (mirrored) std::swap(t[1], t[2]);
      triangles.push_back(t);
    }
    count_ += triangles.size() > 0 ? mesh.mNumFaces : 0;
    if (triangles.empty()) by_look_.erase(look);
    if (count_ > max_triangles || out_.vertices.size() > 3 * max_triangles)
      return wrong(ErrorCode::range, "The mesh has more than " + std::to_string(max_triangles / 1'000'000) + " million triangles.",
                   "Reduce it in a modelling program; 10,000 triangles are enough for most props.");
    return true;
  }
  bool wrong(ErrorCode code, std::string message, std::string remedy) {
    error_.add(code, location_, std::move(message), std::move(remedy));
    return false;
  }

  /// Converts the vertices to metres and Z up. FBX states its unit in cm; COLLADA was converted to metres by assimp; glTF is in metres.
  void to_metres() {
    const bool fbx = ending_ == "fbx", stated = fbx || ending_ == "dae" || ending_ == "glb" || ending_ == "gltf";
    int up = 1;
    if (ending_ == "stl" || ending_ == "ply") up = 2;
    if (ending_ == "dae") up = up_;
    if (fbx) up = std::clamp(static_cast<int>(metadata_number(scene_, "UpAxis").value_or(1)), 0, 2);
    double metres = fbx ? 0.01 * metadata_number(scene_, "UnitScaleFactor").value_or(1) : 1;
    if (!(metres > 0 && std::isfinite(metres))) metres = 1;
    Vec3 low = out_.vertices.front(), high = low;
    for (const Vec3& p : out_.vertices)
      for (int k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], p[k]);
        high[k] = std::max(high[k], p[k]);
      }
    const double extent = std::max({high.x - low.x, high.y - low.y, high.z - low.z});
    if (options_.metres_per_unit > 0) {
      metres = options_.metres_per_unit;
    } else if (!stated && std::isfinite(extent)) {
      notes_.unit_guessed = true;
      if (extent > 20) {
        metres = 0.001;
        notes_.remarks.push_back("The format has no unit of length. Lengths are assumed to be in millimetres, because the mesh would be " +
                                 std::to_string(static_cast<long>(extent)) + " m long otherwise. Set the unit if it is wrong.");
      } else {
        notes_.remarks.push_back("The format has no unit of length. Lengths are assumed to be in metres. Set the unit if it is wrong.");
      }
    }
    notes_.metres_per_unit = metres;
    notes_.z_up = up == 2;
    const Mat3 R = axes_with_up(up);
    for (Vec3& p : out_.vertices) p = R * p * metres;
    for (Vec3& n : out_.normals) n = R * n;
  }

  const aiScene& scene_;
  std::string ending_, location_;
  const MeshOptions& options_;
  int up_;
  const std::vector<std::string>& missing_;
  formats::ReadNotes& notes_;
  MeshScene out_;
  std::map<Look, std::vector<Triangle>> by_look_;
  SceneTextures textures_;
  std::size_t count_ = 0;
  Error error_;
};

}  // namespace

bool is_mesh_file(std::string_view file_name) {
  const std::string ending = ending_of(file_name);
  return ending == "glb" || ending == "gltf" || ending == "obj" || ending == "stl" || ending == "ply" || ending == "dae" || ending == "fbx";
}

Result<ParsedMesh> parse_mesh_scene(std::span<const std::byte> bytes, std::string_view file_name, const MeshOptions& options,
                                    formats::ReadNotes& notes) {
  const std::string location(file_name), ending = ending_of(file_name);
  if (!is_mesh_file(file_name))
    return fail(ErrorCode::unsupported, location, "Mesh files of this type cannot be read.",
                "Give a .glb, .gltf, .obj, .stl, .ply, .dae or .fbx file.");
  if (bytes.empty()) return fail(ErrorCode::truncated, location, "The file is empty.", again);
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);  // to_metres() converts the up axis, for all formats
  const std::string name = "mesh." + ending;
  std::vector<std::string> missing;
  importer.SetIOHandler(new MemoryFiles(name, bytes, options.companions, missing));  // the importer deletes it
  const aiScene* scene = importer.ReadFile(name, aiProcess_Triangulate);
  if (!scene && !missing.empty())
    return fail(ErrorCode::io, location, "The file " + formats::in_quotes(missing.front()) + ", which the mesh uses, is missing.",
                "Choose it together with the mesh.");
  if (!scene)
    return fail(ErrorCode::syntax, location, "The mesh cannot be read: " + formats::utf8(importer.GetErrorString()) + ".",
                "Export it again, or in another format (.glb, .obj).");
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return MeshParser(*scene, ending, location, options, ending == "dae" ? collada_up_axis(text) : 1, missing, notes).parse();
}

}  // namespace ugoki::scene_formats
