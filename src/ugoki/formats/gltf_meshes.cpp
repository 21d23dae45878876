#include "ugoki/formats/gltf_meshes.h"

#include <cstdio>
#include <set>

#include "ugoki/formats/gltf_data.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::formats {
namespace {

using json::Json;

/// Material of a primitive, and how its texture lies on the mesh.
struct Material {
  SkinPart part;
  int uv_set = 0;
  double offset[2] = {0, 0}, scale[2] = {1, 1}, rotation = 0;  ///< KHR_texture_transform; rad
};

class MeshReader : private GltfData {
 public:
  using GltfData::GltfData;

  Result<GltfMeshes> read(std::span<const std::byte> bytes) {
    if (!split(bytes) || !check_asset() || !read_buffers()) return fail(std::move(error_));
    const Json &nodes = list("nodes"), &meshes = list("meshes");
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const auto mesh = index(nodes[i], "mesh", meshes.size());
      if (!mesh || *mesh < 0) continue;
      const Json& json = meshes[static_cast<std::size_t>(*mesh)];
      const Json* primitives = member(json, "primitives");
      if (primitives == nullptr || !primitives->is_array()) continue;
      for (std::size_t k = 0; k < primitives->size(); ++k) {
        const std::string where = path("meshes", static_cast<std::size_t>(*mesh)) + "/primitives/" + std::to_string(k);
        GltfSurface surface;
        surface.node = i;
        if (!read_primitive((*primitives)[k], where, surface) ||
            !apply_targets((*primitives)[k], rest_weights(nodes[i], json), where, surface)) {
          if (!error_.empty()) remark("A part of the mesh is left out: " + error_.problems[0].message);
          error_ = {};
          continue;
        }
        vertices_ += surface.positions.size() / 3;
        corners_ += surface.corners.size();
        if (vertices_ > max_skin_vertices || corners_ > 3 * max_skin_triangles)
          return fail(ErrorCode::range, std::string(name_) + ":meshes",
                      "The character has more than " + std::to_string(max_skin_vertices / 1000) + " thousand vertices or " +
                          std::to_string(max_skin_triangles / 1'000'000) + " million triangles.",
                      "Reduce its mesh in a modelling program.");
        out_.surfaces.push_back(std::move(surface));
      }
    }
    return std::move(out_);
  }

 private:
  void remark(std::string sentence) {
    if (reported_.insert(sentence).second) notes_.remarks.push_back(std::move(sentence));
  }

  /// Reads an attribute of a primitive; false if it is absent or damaged.
  bool attribute(const Json& attributes, const std::string& key, std::size_t components, std::size_t rows, const std::string& where,
                 std::vector<double>& out) {
    const auto which = index(attributes, key.c_str(), list("accessors").size());
    if (!which || *which < 0 || !accessor(*which, components, where + "/attributes/" + key, out)) return false;
    return out.size() == rows * components || refuse(ErrorCode::structure, where, "Its attributes have different lengths.");
  }

  bool read_primitive(const Json& json, const std::string& where, GltfSurface& out) {
    const Json* attributes = member(json, "attributes");
    if (const Json* extensions = member(json, "extensions");
        extensions != nullptr && member(*extensions, "KHR_draco_mesh_compression") != nullptr)
      return refuse(ErrorCode::unsupported, where, "It is compressed with Draco.");
    const auto mode = index(json, "mode", 7), position = attributes ? index(*attributes, "POSITION", list("accessors").size()) : -1;
    if (!position || *position < 0 || !mode) return refuse(ErrorCode::structure, where, "It has no positions or a wrong mode.");
    if (*mode >= 0 && *mode < 4) return false;  // points and lines
    std::vector<double> values;
    if (!accessor(*position, 3, where + "/attributes/POSITION", values)) return false;
    const std::size_t n = values.size() / 3;
    if (n > max_skin_vertices) return refuse(ErrorCode::range, where, "It has too many vertices.");
    out.positions.assign(values.begin(), values.end());
    if (attribute(*attributes, "NORMAL", 3, n, where, values)) out.normals.assign(values.begin(), values.end());
    for (const char* set : {"0", "1"}) {
      std::vector<double> joints, weights;
      if (!attribute(*attributes, std::string("JOINTS_") + set, 4, n, where, joints) ||
          !attribute(*attributes, std::string("WEIGHTS_") + set, 4, n, where, weights))
        break;
      add_set(joints, weights, n, out);
    }
    if (!error_.empty()) return false;
    const Material material = read_material(json);
    out.part = material.part;
    out.uvs.assign(2 * n, 0);
    if (attribute(*attributes, "TEXCOORD_" + std::to_string(material.uv_set), 2, n, where, values))
      set_uvs(values, material, out.uvs);
    else
      out.part.texture = -1;
    if (!error_.empty()) return false;
    if (!read_colors(*attributes, n, where, out.colors)) return false;
    return read_corners(json, where, n, *mode < 0 ? 4 : *mode, out);
  }

  /// Reads the colours of the vertices without their alpha; false if they are damaged.
  bool read_colors(const Json& attributes, std::size_t n, const std::string& where, std::vector<double>& out) {
    const auto which = index(attributes, "COLOR_0", list("accessors").size());
    if (!which) return refuse(ErrorCode::structure, where + "/attributes/COLOR_0", "The index of the accessor is invalid.");
    if (*which < 0) return true;
    const std::size_t width = text(list("accessors")[static_cast<std::size_t>(*which)], "type") == "VEC4" ? 4 : 3;
    if (!attribute(attributes, "COLOR_0", width, n, where, out)) return false;
    for (std::size_t v = 0; width == 4 && v < n; ++v)
      for (std::size_t k = 0; k < 3; ++k) out[3 * v + k] = out[4 * v + k];
    out.resize(3 * n);
    return true;
  }

  /// Adds the morph targets of a mesh with their weights at rest. Shapes do not change during a motion. @return false: a target is damaged
  /// @param weights of the targets of the mesh
  bool apply_targets(const Json& json, const std::vector<double>& weights, const std::string& where, GltfSurface& out) {
    const Json* targets = member(json, "targets");
    if (targets == nullptr || !targets->is_array() || targets->empty()) return true;
    remark("Morph targets, such as shapes of the face, have their weights at rest; they are not animated.");
    const std::size_t n = out.positions.size() / 3;
    for (std::size_t t = 0; t < std::min(targets->size(), weights.size()); ++t) {
      if (weights[t] == 0) continue;
      const std::string place = where + "/targets/" + std::to_string(t);
      std::vector<double> offsets;
      if (attribute((*targets)[t], "POSITION", 3, n, place, offsets)) add_scaled(out.positions, offsets, weights[t]);
      if (!out.normals.empty() && attribute((*targets)[t], "NORMAL", 3, n, place, offsets)) add_scaled(out.normals, offsets, weights[t]);
      if (!error_.empty()) return false;
    }
    for (std::size_t v = 0; v < out.normals.size(); v += 3) {
      const Vec3 unit = normalized(
          Vec3{static_cast<double>(out.normals[v]), static_cast<double>(out.normals[v + 1]), static_cast<double>(out.normals[v + 2])},
          {0, 0, 1});
      for (int k = 0; k < 3; ++k) out.normals[v + static_cast<std::size_t>(k)] = static_cast<float>(unit[k]);
    }
    return true;
  }

  static void add_scaled(std::vector<float>& to, const std::vector<double>& offsets, double weight) {
    for (std::size_t i = 0; i < to.size(); ++i) to[i] = static_cast<float>(static_cast<double>(to[i]) + weight * offsets[i]);
  }

  /// Weights at rest of the morph targets of a node's mesh: of the node, or else of the mesh, or else none.
  static std::vector<double> rest_weights(const Json& node, const Json& mesh) {
    std::vector<double> out;
    const Json* list = member(node, "weights");
    if (list == nullptr) list = member(mesh, "weights");
    if (list == nullptr || !list->is_array()) return out;
    for (const Json& w : *list) {
      const double x = w.is_number() ? w.get<double>() : 0;
      out.push_back(std::fabs(x) <= max_magnitude ? x : 0);
    }
    return out;
  }

  static void add_set(const std::vector<double>& joints, const std::vector<double>& weights, std::size_t n, GltfSurface& out) {
    const std::size_t before = out.sets, after = before + 4;
    std::vector<std::uint32_t> all(after * n);
    std::vector<double> shares(after * n);
    for (std::size_t v = 0; v < n; ++v) {
      for (std::size_t k = 0; k < before; ++k) {
        all[after * v + k] = out.joints[before * v + k];
        shares[after * v + k] = out.weights[before * v + k];
      }
      for (std::size_t k = 0; k < 4; ++k) {
        const double j = joints[4 * v + k];
        all[after * v + before + k] = j >= 0 && j < 65536 ? static_cast<std::uint32_t>(j) : 65536;
        shares[after * v + before + k] = weights[4 * v + k];
      }
    }
    out.joints = std::move(all);
    out.weights = std::move(shares);
    out.sets = after;
  }

  static void set_uvs(const std::vector<double>& values, const Material& m, std::vector<float>& out) {
    const double c = ugoki::cos(m.rotation), s = ugoki::sin(m.rotation);
    for (std::size_t v = 0; 2 * v < values.size(); ++v) {
      const double x = m.scale[0] * values[2 * v], y = m.scale[1] * values[2 * v + 1];
      out[2 * v] = static_cast<float>(m.offset[0] + c * x + s * y);
      out[2 * v + 1] = static_cast<float>(m.offset[1] - s * x + c * y);
    }
  }

  /// Reads the corners; strips (5) and fans (6) become triangles.
  bool read_corners(const Json& json, const std::string& where, std::size_t n, long mode, GltfSurface& out) {
    const auto indices = index(json, "indices", list("accessors").size());
    if (!indices) return refuse(ErrorCode::structure, where + "/indices", "The index of the accessor is invalid.");
    std::vector<std::uint32_t> line(n);
    if (*indices >= 0) {
      std::vector<double> values;
      if (!accessor(*indices, 1, where + "/indices", values)) return false;
      line.clear();
      for (const double i : values) {
        if (!(i >= 0 && i < static_cast<double>(n)))
          return refuse(ErrorCode::range, where, "A triangle refers to a vertex that does not exist.");
        line.push_back(static_cast<std::uint32_t>(i));
      }
    } else {
      for (std::size_t i = 0; i < n; ++i) line[i] = static_cast<std::uint32_t>(i);
    }
    if (mode == 4) {
      line.resize(line.size() / 3 * 3);
      out.corners = std::move(line);
    } else {
      for (std::size_t i = 0; i + 2 < line.size(); ++i) {
        const std::size_t turned = mode == 5 ? i & 1 : 0;
        for (const std::size_t k : {mode == 5 ? i : 0, i + 1 + turned, i + 2 - turned}) out.corners.push_back(line[k]);
      }
    }
    return !out.corners.empty();
  }

  Material read_material(const Json& primitive) {
    Material out;
    const auto which = index(primitive, "material", list("materials").size());
    if (!which || *which < 0) return out;
    const Json& json = list("materials")[static_cast<std::size_t>(*which)];
    std::array<double, 4> color{1, 1, 1, 1};
    const Json* base = member(json, "pbrMetallicRoughness");
    const Json* texture = base != nullptr ? member(*base, "baseColorTexture") : nullptr;
    if (base != nullptr) (void)numbers(*base, "baseColorFactor", color);
    if (const Json* extensions = member(json, "extensions"))
      if (const Json* older = member(*extensions, "KHR_materials_pbrSpecularGlossiness")) {
        (void)numbers(*older, "diffuseFactor", color);
        texture = member(*older, "diffuseTexture");
      }
    char text_of_color[8];
    const auto byte = [](double x) {
      x = std::clamp(x, 0.0, 1.0);
      return static_cast<unsigned>(std::lround(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * ugoki::exp(ugoki::log(x) / 2.4) - 0.055)));
    };
    std::snprintf(text_of_color, sizeof text_of_color, "#%02x%02x%02x", byte(color[0]), byte(color[1]), byte(color[2]));
    out.part.color = text_of_color;
    const Json* both = member(json, "doubleSided");
    out.part.both_sides = both != nullptr && both->is_boolean() && both->get<bool>();
    const std::string alpha = text(json, "alphaMode");
    if (alpha == "MASK") {
      out.part.cutoff = 0.5;
      if (const Json* cutoff = member(json, "alphaCutoff"); cutoff != nullptr && cutoff->is_number())
        out.part.cutoff = std::clamp(cutoff->get<double>(), 0.0, 1.0);
    } else if (alpha == "BLEND" && texture != nullptr) {
      out.part.cutoff = 0.35;  // hair and lashes; without sorting, a cut-off looks better than blending
    }
    if (texture != nullptr) place_texture(*texture, out);
    return out;
  }

  void place_texture(const Json& json, Material& out) {
    const auto which = index(json, "index", list("textures").size()), set = index(json, "texCoord", 8);
    if (!which || *which < 0) return;
    out.uv_set = static_cast<int>(std::max(set.value_or(0), 0L));
    if (const Json* extensions = member(json, "extensions"))
      if (const Json* t = member(*extensions, "KHR_texture_transform")) {
        std::array<double, 2> offset{0, 0}, scale{1, 1};
        if (numbers(*t, "offset", offset) && numbers(*t, "scale", scale))
          for (std::size_t k = 0; k < 2; ++k) out.offset[k] = offset[k], out.scale[k] = scale[k];
        if (const Json* angle = member(*t, "rotation"); angle != nullptr && angle->is_number())
          out.rotation = std::clamp(angle->get<double>(), -1e3, 1e3);
        if (const auto own = index(*t, "texCoord", 8); own && *own >= 0) out.uv_set = static_cast<int>(*own);
      }
    out.part.texture = texture_of(static_cast<std::size_t>(*which));
  }

  /// Index in GltfMeshes::textures of a texture of the file; -1: it cannot be shown, which a remark reports.
  int texture_of(std::size_t which) {
    const auto image = index(list("textures")[which], "source", list("images").size());
    if (!image || *image < 0) {
      remark("A texture that is neither PNG nor JPEG is left out; the base colour of its material is shown.");
      return -1;
    }
    const auto i = static_cast<std::size_t>(*image);
    if (const auto known = textures_.find(i); known != textures_.end()) return known->second;
    SkinTexture texture;
    int& slot = textures_[i] = -1;
    if (!bytes_of_image(list("images")[i], path("images", i), texture.data)) {
      if (!error_.empty()) remark("A texture is left out: " + error_.problems[0].message + " " + error_.problems[0].remedy);
      error_ = {};
      return -1;
    }
    const std::optional<PictureSize> size = picture_size(texture.data, texture.type);
    texture_bytes_ += texture.data.size();
    if (!size)
      remark("A texture that is neither PNG nor JPEG is left out; the base colour of its material is shown.");
    else if (std::max(size->width, size->height) > max_texture_side || texture.data.size() > max_texture_bytes ||
             texture_bytes_ > max_skin_bytes)
      remark("A texture of " + std::to_string(size->width) + " x " + std::to_string(size->height) + " pixels (" +
             std::to_string(texture.data.size() >> 20) + " MB) is left out: textures have at most " + std::to_string(max_texture_side) +
             " pixels a side and " + std::to_string(max_texture_bytes >> 20) + " MB, and " + std::to_string(max_skin_bytes >> 20) +
             " MB together.");
    else {
      slot = static_cast<int>(out_.textures.size());
      out_.textures.push_back(std::move(texture));
    }
    return slot;
  }

  bool bytes_of_image(const Json& json, const std::string& where, std::vector<std::byte>& out) {
    const std::string uri = text(json, "uri");
    if (uri.starts_with("data:")) {
      const std::size_t comma = uri.find(";base64,");
      auto bytes = comma == std::string::npos ? std::nullopt : gltf_base64(std::string_view(uri).substr(comma + 8));
      if (!bytes) return refuse(ErrorCode::syntax, where + "/uri", "Its data are not valid base64.");
      out = std::move(*bytes);
      return true;
    }
    if (!uri.empty()) {
      auto bytes = files_ ? files_(gltf_unescaped(uri)) : Result<std::vector<std::byte>>(fail(ErrorCode::io, where, "", ""));
      if (!bytes)
        return refuse(ErrorCode::io, where + "/uri", "The file " + path_in_quotes(uri) + " is missing.",
                      "Choose it together with the character's file.");
      out = std::move(*bytes);
      return true;
    }
    const auto view = index(json, "bufferView", list("bufferViews").size());
    std::span<const std::byte> bytes;
    if (!view || *view < 0) return refuse(ErrorCode::structure, where, "It has no data.");
    if (!bytes_of_view(static_cast<std::size_t>(*view), where, bytes)) return false;
    out.assign(bytes.begin(), bytes.end());
    return true;
  }

  GltfMeshes out_;
  std::map<std::size_t, int> textures_;  ///< by index of the image
  std::set<std::string> reported_;
  std::size_t vertices_ = 0, corners_ = 0, texture_bytes_ = 0;
};

}  // namespace

Result<GltfMeshes> read_gltf_meshes(std::span<const std::byte> bytes, std::string_view file_name, const GltfFiles& files,
                                    const GltfUnpack& unpack, ReadNotes& notes) {
  return MeshReader(file_name, files, unpack, notes).read(bytes);
}

}  // namespace ugoki::formats
