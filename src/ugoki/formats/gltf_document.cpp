#include "ugoki/formats/gltf_document.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>

#include "ugoki/formats/mesh_end.h"
#include "ugoki/formats/text.h"

namespace ugoki::formats {
namespace {

using json::Json;

constexpr const char* again = "Export the file again.";
constexpr std::size_t max_numbers = 50'000'000;  // limit for the values of all accessors together; 400 MB as doubles

std::uint32_t little32(const std::byte* p) {
  std::uint32_t v = 0;
  std::memcpy(&v, p, 4);
  return v;
}

int base64_value(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  return c == '+' || c == '-' ? 62 : c == '/' || c == '_' ? 63 : -1;
}

/// Decodes base64 (RFC 4648) with or without padding, also in the URL alphabet. Returns std::nullopt if `text` is not base64.
std::optional<std::vector<std::byte>> from_base64(std::string_view text) {
  std::vector<std::byte> out;
  out.reserve(text.size() / 4 * 3);
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    if (c == '=') break;
    const int v = base64_value(c);
    if (v < 0) return std::nullopt;
    bits = bits << 6 | static_cast<std::uint32_t>(v);
    if (++count == 4) {
      for (const int shift : {16, 8, 0}) out.push_back(static_cast<std::byte>(bits >> shift & 0xff));
      bits = 0;
      count = 0;
    }
  }
  if (count == 1) return std::nullopt;
  if (count >= 2) out.push_back(static_cast<std::byte>(bits >> (6 * count - 8) & 0xff));
  if (count == 3) out.push_back(static_cast<std::byte>(bits >> 2 & 0xff));
  return out;
}

/// Returns `uri` with its percent escapes resolved.
std::string unescaped(std::string_view uri) {
  std::string out;
  const auto hex = [](char c) {
    return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
  };
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] == '%' && i + 2 < uri.size() && hex(uri[i + 1]) >= 0 && hex(uri[i + 2]) >= 0) {
      out.push_back(static_cast<char>(16 * hex(uri[i + 1]) + hex(uri[i + 2])));
      i += 2;
    } else {
      out.push_back(uri[i]);
    }
  }
  return out;
}

class Parser {
 public:
  Parser(std::string_view name, const GltfFiles& files, const GltfUnpack& unpack, ReadNotes& notes)
      : name_(name), files_(files), unpack_(unpack), notes_(notes) {}

  Result<GltfDocument> parse(std::span<const std::byte> bytes) {
    if (!split(bytes) || !check_asset() || !read_buffers() || !read_nodes() || !read_skins() || !read_animations())
      return fail(std::move(error_));
    read_mesh_ends();
    return std::move(out_);
  }

 private:
  bool refuse(ErrorCode code, const std::string& path, const std::string& message, const std::string& remedy = again) {
    error_ = Error(code, std::string(name_) + ":" + path, message, remedy);
    return false;
  }
  static std::string path(std::string_view list, std::size_t i) { return std::string(list) + "/" + std::to_string(i); }

  /// Finds the JSON text and the binary chunk, and parses the JSON. A GLB file has a header of 12 bytes, then chunks. A chunk has a length,
  /// a type and data.
  bool split(std::span<const std::byte> bytes) {
    std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (text.starts_with("glTF")) {
      if (bytes.size() < 20) return refuse(ErrorCode::truncated, "header", "The file ends within its header.");
      if (little32(bytes.data() + 4) != 2)
        return refuse(ErrorCode::unsupported, "header",
                      "Version " + std::to_string(little32(bytes.data() + 4)) + " of glTF is not supported.",
                      "Export the file as glTF 2.0.");
      if (little32(bytes.data() + 8) > bytes.size())
        return refuse(ErrorCode::truncated, "header", "The file is shorter than its header specifies.");
      const std::size_t length = little32(bytes.data() + 12);
      if (20 + length > bytes.size()) return refuse(ErrorCode::truncated, "chunk 0", "The file ends within its JSON chunk.");
      if (little32(bytes.data() + 16) != 0x4E4F534A) return refuse(ErrorCode::syntax, "chunk 0", "The first chunk is not JSON.");
      text = text.substr(20, length);
      while (!text.empty() && (text.back() == ' ' || text.back() == '\0')) text.remove_suffix(1);
      const std::size_t at = 20 + length;
      if (at + 8 <= bytes.size() && little32(bytes.data() + at + 4) == 0x004E4942) {
        const std::size_t size = little32(bytes.data() + at);
        if (at + 8 + size > bytes.size()) return refuse(ErrorCode::truncated, "chunk 1", "The file ends within its binary chunk.");
        binary_ = bytes.subspan(at + 8, size);
      }
    }
    auto parsed = json::parse_json(text, name_, std::size_t{512} << 20);
    if (!parsed) {
      error_ = std::move(parsed.error());
      return false;
    }
    root_ = std::move(*parsed);
    return root_.is_object() || refuse(ErrorCode::syntax, "", "The file is not a JSON object.", "Check that it is a glTF file.");
  }

  bool check_asset() {
    const Json* asset = member(root_, "asset");
    const Json* version = asset != nullptr ? member(*asset, "version") : nullptr;
    if (version == nullptr || !version->is_string())
      return refuse(ErrorCode::syntax, "asset/version", "The glTF version is missing.", "Check that it is a glTF file.");
    if (!version->get_ref<const std::string&>().starts_with("2."))
      return refuse(ErrorCode::unsupported, "asset/version",
                    "Version " + in_quotes(version->get_ref<const std::string&>()) + " of glTF is not supported.",
                    "Export the file as glTF 2.0.");
    if (const Json* required = member(root_, "extensionsRequired"); required != nullptr && required->is_array())
      for (const Json& e : *required)
        if (e.is_string() && (e == "KHR_draco_mesh_compression"))
          notes_.remarks.push_back("The extension " + in_quotes(e.get_ref<const std::string&>()) +
                                   " is not supported; meshes are skipped.");
    // Unlike Draco, which compresses meshes only, meshopt compresses animations and skins too.
    for (const Json& view : list("bufferViews"))
      if (!unpack_ && packing_of(view) != nullptr)
        return refuse(ErrorCode::unsupported, "bufferViews", "The data are compressed with EXT_meshopt_compression, which is not read.",
                      "Convert the file without compression, for example with gltf-transform copy.");
    return true;
  }

  /// Returns the member `key` of an object; null if `object` is not an object or has no such member.
  static const Json* member(const Json& object, const char* key) {
    if (!object.is_object()) return nullptr;
    const auto it = object.find(key);
    return it == object.end() ? nullptr : &*it;
  }
  /// Returns the list `key` of the document; an empty list if it is missing.
  const Json& list(const char* key) {
    static const Json nothing = Json::array();
    const Json* l = member(root_, key);
    return l != nullptr && l->is_array() ? *l : nothing;
  }
  /// Returns the integer `key` in [0, below); -1 if it is missing; std::nullopt if it has another type or value.
  static std::optional<long> index(const Json& object, const char* key, std::size_t below) {
    const Json* v = member(object, key);
    if (v == nullptr) return -1;
    if (!v->is_number_unsigned() && !(v->is_number_integer() && v->get<std::int64_t>() >= 0)) return std::nullopt;
    const auto n = v->get<std::uint64_t>();
    return n < below ? std::optional<long>(static_cast<long>(n)) : std::nullopt;
  }
  /// Returns the text `key`; empty if it is missing or not a string.
  static std::string text(const Json& object, const char* key) {
    const Json* v = member(object, key);
    return v != nullptr && v->is_string() ? v->get<std::string>() : std::string();
  }
  /// Reads the list `key` of exactly n numbers of magnitude at most max_magnitude. If the list is missing, `out` is unchanged and the
  /// result is true. Returns false if the value is anything else.
  template <std::size_t n>
  static bool numbers(const Json& object, const char* key, std::array<double, n>& out) {
    const Json* v = member(object, key);
    if (v == nullptr) return true;
    if (!v->is_array() || v->size() != n) return false;
    for (std::size_t i = 0; i < n; ++i) {
      if (!(*v)[i].is_number()) return false;
      out[i] = (*v)[i].template get<double>();
      if (!(std::fabs(out[i]) <= max_magnitude)) return false;
    }
    return true;
  }

  bool read_buffers() {
    const Json& buffers = list("buffers");
    for (std::size_t i = 0; i < buffers.size(); ++i) {
      const std::string uri = text(buffers[i], "uri");
      if (uri.empty()) {
        if (i > 0 || binary_.empty()) {
          buffers_.push_back({});
          continue;
        }
        buffers_.emplace_back(binary_.begin(), binary_.end());
      } else if (uri.starts_with("data:")) {
        const std::size_t comma = uri.find(";base64,");
        auto bytes = comma == std::string::npos ? std::nullopt : from_base64(std::string_view(uri).substr(comma + 8));
        if (!bytes) return refuse(ErrorCode::syntax, path("buffers", i) + "/uri", "The data are not valid base64.");
        buffers_.push_back(std::move(*bytes));
      } else {
        if (!files_)
          return refuse(ErrorCode::unsupported, path("buffers", i) + "/uri",
                        "The file refers to " + path_in_quotes(uri) + ", which is not available.",
                        "Use a .glb file, or provide both files together.");
        auto bytes = files_(unescaped(uri));
        if (!bytes) {
          error_ = std::move(bytes.error());
          return false;
        }
        buffers_.push_back(std::move(*bytes));
      }
    }
    return true;
  }

  bool read_nodes() {
    const Json& nodes = list("nodes");
    if (nodes.empty()) return refuse(ErrorCode::structure, "nodes", "The file has no nodes.");
    if (nodes.size() > max_joints)
      return refuse(ErrorCode::range, "nodes", "The file has more than " + std::to_string(max_joints) + " nodes.",
                    "Export only the skeleton and its meshes.");
    out_.nodes.resize(nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i)
      if (!read_node(nodes[i], i)) return false;
    // Find cycles: the chain of parents of every node must end within max_depth steps.
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      std::size_t steps = 0;
      for (int n = static_cast<int>(i); n >= 0; n = out_.nodes[static_cast<std::size_t>(n)].parent)
        if (++steps > max_depth)
          return refuse(ErrorCode::structure, path("nodes", i), "The node is its own ancestor, or nested more than 1000 deep.");
    }
    return true;
  }

  bool read_node(const Json& json, std::size_t i) {
    GltfNode& node = out_.nodes[i];
    node.name = text(json, "name");
    std::array<double, 3> t{0, 0, 0}, s{1, 1, 1};
    std::array<double, 4> r{0, 0, 0, 1};
    std::array<double, 16> m{};
    if (!numbers(json, "translation", t) || !numbers(json, "scale", s) || !numbers(json, "rotation", r) || !numbers(json, "matrix", m))
      return refuse(ErrorCode::range, path("nodes", i),
                    "The transform has a wrong number of values, or a value that is not a number up to 1e9.");
    node.translation = {t[0], t[1], t[2]};
    node.scale = {s[0], s[1], s[2]};
    node.rotation = normalized(Quat{r[3], r[0], r[1], r[2]});
    if (member(json, "matrix") != nullptr)  // stored by columns
      node.matrix = Affine{Mat3::columns({m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}), {m[12], m[13], m[14]}};
    const auto skin = index(json, "skin", list("skins").size());
    if (!skin) return refuse(ErrorCode::structure, path("nodes", i) + "/skin", "The index of the skin is invalid.");
    node.skin = static_cast<int>(*skin);
    const Json* children = member(json, "children");
    if (children == nullptr) return true;
    if (!children->is_array()) return refuse(ErrorCode::structure, path("nodes", i) + "/children", "The value is not a list.");
    for (const Json& c : *children) {
      if (!c.is_number_unsigned() || c.get<std::uint64_t>() >= out_.nodes.size())
        return refuse(ErrorCode::structure, path("nodes", i) + "/children", "The index of a child is invalid.");
      GltfNode& child = out_.nodes[c.get<std::size_t>()];
      if (child.parent >= 0) return refuse(ErrorCode::structure, path("nodes", i) + "/children", "A node has two parents.");
      child.parent = static_cast<int>(i);
    }
    return true;
  }

  /// Reads all values of an accessor into `out` [count][components]. @param location JSON path for error messages
  bool accessor(long index_of_accessor, std::size_t components, const std::string& location, std::vector<double>& out) {
    const Json& json = list("accessors")[static_cast<std::size_t>(index_of_accessor)];
    const std::string type = text(json, "type");
    const std::size_t own = type == "SCALAR"                   ? 1
                            : type == "VEC2"                   ? 2
                            : type == "VEC3"                   ? 3
                            : type == "VEC4" || type == "MAT2" ? 4
                            : type == "MAT3"                   ? 9
                            : type == "MAT4"                   ? 16
                                                               : 0;
    if (own != components)
      return refuse(ErrorCode::structure, location, "The accessor has the type " + in_quotes(type) + ", which is not allowed here.");
    const auto count = index(json, "count", max_numbers / components);
    const auto kind = index(json, "componentType", 6000);
    if (!count || *count < 1 || !kind)
      return refuse(ErrorCode::range, location, "The count or component type of the accessor is missing or out of range.");
    const std::size_t size = *kind == 5126                    ? 4
                             : *kind == 5120 || *kind == 5121 ? 1
                             : *kind == 5122 || *kind == 5123 ? 2
                             : *kind == 5125                  ? 4
                                                              : 0;
    if (size == 0) return refuse(ErrorCode::structure, location, "The component type of the accessor is unknown.");
    read_ += static_cast<std::size_t>(*count) * components;
    if (read_ > max_numbers)
      return refuse(ErrorCode::range, location, "The file has more than 50 million numbers.", "Split it into several files.");
    out.assign(static_cast<std::size_t>(*count) * components, 0);
    const Json* normalized = member(json, "normalized");
    const bool norm = normalized != nullptr && normalized->is_boolean() && normalized->get<bool>();
    if (member(json, "bufferView") != nullptr) {
      const auto offset = index(json, "byteOffset", std::numeric_limits<std::uint32_t>::max());
      if (!offset || !view(json, "bufferView", location, static_cast<std::size_t>(std::max(*offset, 0L)), *kind, norm, size, components,
                           static_cast<std::size_t>(*count), out))
        return error_.empty() ? refuse(ErrorCode::structure, location, "The offset of the accessor is invalid.") : false;
    }
    if (const Json* sparse = member(json, "sparse")) return apply_sparse(*sparse, location, *kind, norm, size, components, out);
    return true;
  }

  /// Reads `count` elements of `components` values from the buffer view `object[key]`, beginning at byte `offset` of the view.
  /// @param kind glTF component type  @param norm true: integers are normalised to [0, 1] or [-1, 1]  @param size bytes of a component
  bool view(const Json& object, const char* key, const std::string& location, std::size_t offset, long kind, bool norm, std::size_t size,
            std::size_t components, std::size_t count, std::vector<double>& out) {
    const Json& views = list("bufferViews");
    const auto which = index(object, key, views.size());
    if (!which || *which < 0) return refuse(ErrorCode::structure, location, "The index of the buffer view is missing or invalid.");
    const auto given = index(views[static_cast<std::size_t>(*which)], "byteStride", 4096);
    std::span<const std::byte> bytes;
    if (!bytes_of_view(static_cast<std::size_t>(*which), location, bytes)) return false;
    if (!given) return refuse(ErrorCode::structure, path("bufferViews", static_cast<std::size_t>(*which)), "The stride is out of range.");
    const std::size_t stride = *given > 0 ? static_cast<std::size_t>(*given) : size * components;
    if (offset + (count - 1) * stride + size * components > bytes.size())
      return refuse(ErrorCode::truncated, location, "The accessor extends beyond its buffer.",
                    "Copy the file again, together with the files to which it refers.");
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t c = 0; c < components; ++c)
        out[i * components + c] = component(bytes.data() + offset + i * stride + c * size, kind, norm);
    return true;
  }

  /// The description of how EXT_meshopt_compression packs a buffer view; null if the view is not packed.
  static const Json* packing_of(const Json& view) {
    const Json* extensions = member(view, "extensions");
    return extensions != nullptr ? member(*extensions, "EXT_meshopt_compression") : nullptr;
  }

  /// Finds the bytes of buffer view `which`, unpacked. @param location JSON path for error messages
  bool bytes_of_view(std::size_t which, const std::string& location, std::span<const std::byte>& out) {
    const Json& view = list("bufferViews")[which];
    const Json* packing = packing_of(view);
    if (const auto found = unpacked_.find(which); packing != nullptr && found != unpacked_.end()) {
      out = found->second;
      return true;
    }
    const Json& json = packing != nullptr ? *packing : view;
    const auto buffer = index(json, "buffer", buffers_.size()),
               start = index(json, "byteOffset", std::numeric_limits<std::uint32_t>::max()),
               length = index(json, "byteLength", std::numeric_limits<std::uint32_t>::max());
    if (!buffer || *buffer < 0 || !start || !length || *length < 0)
      return refuse(ErrorCode::structure, path("bufferViews", which), "The buffer, offset or length is missing or out of range.");
    const std::vector<std::byte>& bytes = buffers_[static_cast<std::size_t>(*buffer)];
    const auto first = static_cast<std::size_t>(std::max(*start, 0L)), size = static_cast<std::size_t>(*length);
    if (first + size > bytes.size())
      return refuse(ErrorCode::truncated, location, "The accessor extends beyond its buffer.",
                    "Copy the file again, together with the files to which it refers.");
    out = std::span(bytes).subspan(first, size);
    return packing == nullptr || unpack(which, *packing, out);
  }

  /// Replaces the bytes of a packed buffer view by the unpacked bytes.
  bool unpack(std::size_t which, const Json& packing, std::span<const std::byte>& bytes) {
    const std::string location = path("bufferViews", which) + "/extensions/EXT_meshopt_compression";
    const auto count = index(packing, "count", max_numbers), stride = index(packing, "byteStride", 257);
    if (!count || *count < 0 || !stride || *stride < 4 || *stride % 4 != 0)
      return refuse(ErrorCode::structure, location, "The count or stride is missing or out of range.");
    const std::string mode = text(packing, "mode"), filter = text(packing, "filter");
    if (mode != "ATTRIBUTES")
      return refuse(ErrorCode::structure, location, "The mode is " + in_quotes(mode) + "; animations and skins need ATTRIBUTES.");
    // The packed form has at least 2 bits for 16 bytes, so that damaged counts cannot make the memory large.
    const auto n = static_cast<std::size_t>(*count), width = static_cast<std::size_t>(*stride);
    if (n * width / 64 > bytes.size())
      return refuse(ErrorCode::truncated, location, "The packed data are too short for " + std::to_string(n) + " elements.");
    std::optional<std::vector<std::byte>> plain = unpack_(bytes, n, width, filter.empty() ? "NONE" : filter);
    if (!plain || plain->size() != n * width) return refuse(ErrorCode::structure, location, "The packed data are damaged.");
    bytes = unpacked_[which] = std::move(*plain);
    return true;
  }

  static double component(const std::byte* p, long kind, bool norm) {
    std::uint32_t bits = 0;
    switch (kind) {
      case 5126: return static_cast<double>(std::bit_cast<float>(little32(p)));
      case 5125: return little32(p);
      case 5120:
        return norm ? std::max(static_cast<std::int8_t>(std::to_integer<int>(*p)) / 127.0, -1.0)
                    : static_cast<std::int8_t>(std::to_integer<int>(*p));
      case 5121: return std::to_integer<int>(*p) / (norm ? 255.0 : 1.0);
      default: break;
    }
    bits = std::to_integer<std::uint32_t>(p[0]) | std::to_integer<std::uint32_t>(p[1]) << 8;
    if (kind == 5123) return bits / (norm ? 65535.0 : 1.0);
    const auto v = static_cast<std::int16_t>(bits);
    return norm ? std::max(v / 32767.0, -1.0) : v;
  }

  /// Replaces the elements of `out` [count][components] whose indices a sparse accessor lists.
  bool apply_sparse(const Json& sparse, const std::string& location, long kind, bool norm, std::size_t size, std::size_t components,
                    std::vector<double>& out) {
    const auto count = index(sparse, "count", out.size() / components + 1);
    const Json *indices = member(sparse, "indices"), *values = member(sparse, "values");
    if (!count || *count < 1 || indices == nullptr || values == nullptr)
      return refuse(ErrorCode::structure, location, "The sparse accessor is incomplete.");
    const auto index_kind = index(*indices, "componentType", 6000), index_offset = index(*indices, "byteOffset", 1u << 31),
               value_offset = index(*values, "byteOffset", 1u << 31);
    const std::size_t index_size = !index_kind ? 0 : *index_kind == 5121 ? 1 : *index_kind == 5123 ? 2 : *index_kind == 5125 ? 4 : 0;
    if (index_size == 0 || !index_offset || !value_offset)
      return refuse(ErrorCode::structure, location, "The sparse accessor is incomplete.");
    const auto n = static_cast<std::size_t>(*count);
    std::vector<double> entries(n), replacements(n * components);
    if (!view(*indices, "bufferView", location, static_cast<std::size_t>(std::max(*index_offset, 0L)), *index_kind, false, index_size, 1, n,
              entries) ||
        !view(*values, "bufferView", location, static_cast<std::size_t>(std::max(*value_offset, 0L)), kind, norm, size, components, n,
              replacements))
      return false;
    for (std::size_t i = 0; i < n; ++i) {
      const auto at = static_cast<std::size_t>(entries[i]);
      if (at >= out.size() / components)
        return refuse(ErrorCode::range, location, "A sparse index is not below the count of the accessor.");
      for (std::size_t c = 0; c < components; ++c) out[at * components + c] = replacements[i * components + c];
    }
    return true;
  }

  bool read_skins() {
    const Json& skins = list("skins");
    for (std::size_t i = 0; i < skins.size(); ++i) {
      GltfSkin skin;
      const Json* joints = member(skins[i], "joints");
      if (joints == nullptr || !joints->is_array() || joints->empty())
        return refuse(ErrorCode::structure, path("skins", i), "The skin has no joints.");
      for (const Json& j : *joints) {
        if (!j.is_number_unsigned() || j.get<std::uint64_t>() >= out_.nodes.size())
          return refuse(ErrorCode::structure, path("skins", i) + "/joints", "The index of a joint is invalid.");
        skin.joints.push_back(j.get<int>());
      }
      const auto binds = index(skins[i], "inverseBindMatrices", list("accessors").size());
      if (!binds) return refuse(ErrorCode::structure, path("skins", i) + "/inverseBindMatrices", "The index of the accessor is invalid.");
      if (*binds >= 0) {
        std::vector<double> m;
        if (!accessor(*binds, 16, path("skins", i) + "/inverseBindMatrices", m)) return false;
        if (m.size() < 16 * skin.joints.size())
          return refuse(ErrorCode::structure, path("skins", i) + "/inverseBindMatrices", "There are fewer matrices than joints.");
        for (std::size_t j = 0; j < skin.joints.size(); ++j) {
          const double* v = m.data() + 16 * j;
          skin.inverse_binds.push_back({Mat3::columns({v[0], v[1], v[2]}, {v[4], v[5], v[6]}, {v[8], v[9], v[10]}), {v[12], v[13], v[14]}});
        }
      }
      out_.skins.push_back(std::move(skin));
    }
    return true;
  }

  /// Sets GltfSkin::mesh_ends. A mesh that cannot be read is left out.
  void read_mesh_ends() {
    constexpr std::size_t max_numbers_of_meshes = 12'000'000;  // numbers of all meshes
    std::size_t numbers = 0;
    const Json &nodes = list("nodes"), &meshes = list("meshes"), &accessors = list("accessors");
    std::vector<std::vector<std::vector<Vec3>>> points(out_.skins.size());  // [skins][joints]
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const auto mesh = index(nodes[i], "mesh", meshes.size());
      if (out_.nodes[i].skin < 0 || !mesh || *mesh < 0) continue;
      const auto s = static_cast<std::size_t>(out_.nodes[i].skin);
      const GltfSkin& skin = out_.skins[s];
      const Json* primitives = member(meshes[static_cast<std::size_t>(*mesh)], "primitives");
      if (skin.inverse_binds.empty() || primitives == nullptr || !primitives->is_array()) continue;
      points[s].resize(skin.joints.size());
      for (const Json& p : *primitives) {
        const Json* attributes = member(p, "attributes");
        if (attributes == nullptr || member(p, "extensions") != nullptr) continue;
        const auto position = index(*attributes, "POSITION", accessors.size()), joints = index(*attributes, "JOINTS_0", accessors.size()),
                   weights = index(*attributes, "WEIGHTS_0", accessors.size());
        if (!position || *position < 0 || !joints || *joints < 0 || !weights || *weights < 0) continue;
        const auto count = index(accessors[static_cast<std::size_t>(*position)], "count", max_numbers_of_meshes);
        if (!count || *count < 1 || (numbers += 11 * static_cast<std::size_t>(*count)) > max_numbers_of_meshes) continue;
        std::vector<double> x, j, w;
        const bool read = accessor(*position, 3, "meshes", x) && accessor(*joints, 4, "meshes", j) && accessor(*weights, 4, "meshes", w);
        error_ = {};
        if (!read || j.size() != w.size() || 4 * x.size() != 3 * j.size()) continue;
        for (std::size_t v = 0; 3 * v < x.size(); ++v) {
          const auto heaviest = static_cast<std::size_t>(std::max_element(&w[4 * v], &w[4 * v] + 4) - &w[4 * v]);
          const double joint = j[4 * v + heaviest];
          if (!(joint >= 0) || joint >= static_cast<double>(skin.joints.size())) continue;
          const auto k = static_cast<std::size_t>(joint);
          const Affine& bind = skin.inverse_binds[k];
          points[s][k].push_back(bind.A * Vec3{x[3 * v], x[3 * v + 1], x[3 * v + 2]} + bind.p);
        }
      }
    }
    for (std::size_t s = 0; s < points.size(); ++s) {
      out_.skins[s].mesh_ends.resize(points[s].size());
      for (std::size_t k = 0; k < points[s].size(); ++k) out_.skins[s].mesh_ends[k] = far_end(points[s][k]);
    }
  }

  bool read_animations() {
    const Json& animations = list("animations");
    if (animations.size() > 1000)
      return refuse(ErrorCode::range, "animations", "The file has more than 1000 animations.", "Split it into several files.");
    for (std::size_t i = 0; i < animations.size(); ++i) {
      GltfAnimation animation;
      animation.name = text(animations[i], "name");
      const Json *channels = member(animations[i], "channels"), *samplers = member(animations[i], "samplers");
      if (channels == nullptr || !channels->is_array() || samplers == nullptr || !samplers->is_array())
        return refuse(ErrorCode::structure, path("animations", i), "The animation has no channels or no samplers.");
      for (std::size_t c = 0; c < channels->size(); ++c)
        if (!read_channel((*channels)[c], *samplers, path("animations", i) + "/channels/" + std::to_string(c), animation)) return false;
      out_.animations.push_back(std::move(animation));
    }
    return true;
  }

  bool read_channel(const Json& json, const Json& samplers, const std::string& location, GltfAnimation& animation) {
    const Json* target = member(json, "target");
    const auto which = index(json, "sampler", samplers.size());
    if (target == nullptr || !which || *which < 0)
      return refuse(ErrorCode::structure, location, "The channel has no target or no valid sampler.");
    const auto node = index(*target, "node", out_.nodes.size());
    if (!node) return refuse(ErrorCode::structure, location + "/target/node", "The index of the node is invalid.");
    GltfChannel channel;
    const std::string path = text(*target, "path");
    if (*node < 0 || (path != "translation" && path != "rotation" && path != "scale"))
      return true;  // morph weights and paths of extensions are not read
    channel.node = static_cast<int>(*node);
    channel.path = path == "rotation" ? GltfPath::rotation : path == "scale" ? GltfPath::scale : GltfPath::translation;
    const Json& sampler = samplers[static_cast<std::size_t>(*which)];
    const auto input = index(sampler, "input", list("accessors").size()), output = index(sampler, "output", list("accessors").size());
    if (!input || *input < 0 || !output || *output < 0)
      return refuse(ErrorCode::structure, location + "/sampler", "The sampler has no valid input or output.");
    const std::string interpolation = text(sampler, "interpolation");
    channel.interpolation = interpolation == "STEP"          ? GltfInterpolation::step
                            : interpolation == "CUBICSPLINE" ? GltfInterpolation::cubic
                                                             : GltfInterpolation::linear;
    const std::size_t components = channel.path == GltfPath::rotation ? 4 : 3;
    if (!accessor(*input, 1, location, channel.times) || !accessor(*output, components, location, channel.values)) return false;
    const std::size_t rows = channel.times.size() * (channel.interpolation == GltfInterpolation::cubic ? 3 : 1);
    if (channel.values.size() < rows * components) return refuse(ErrorCode::structure, location, "There are fewer values than times.");
    for (std::size_t k = 0; k < channel.times.size(); ++k)
      if (!(channel.times[k] >= 0 && channel.times[k] < 1e6) || (k > 0 && channel.times[k] < channel.times[k - 1]))
        return refuse(ErrorCode::range, location, "The times of the keys are negative, decreasing, or 1e6 s or more.");
    for (const double v : channel.values)
      if (!(std::fabs(v) <= max_magnitude))
        return refuse(ErrorCode::range, location, "A value is not finite or its magnitude is above 1e9.");
    animation.channels.push_back(std::move(channel));
    return true;
  }

  std::string_view name_;
  const GltfFiles& files_;
  const GltfUnpack& unpack_;
  ReadNotes& notes_;
  Error error_;
  Json root_;
  std::span<const std::byte> binary_;
  std::vector<std::vector<std::byte>> buffers_;
  std::map<std::size_t, std::vector<std::byte>> unpacked_;  ///< by index of the buffer view
  std::size_t read_ = 0;                                    ///< number of values read so far, over all accessors
  GltfDocument out_;
};

}  // namespace

Result<GltfDocument> read_gltf_document(std::span<const std::byte> bytes, std::string_view file_name, const GltfFiles& files,
                                        const GltfUnpack& unpack, ReadNotes& notes) {
  return Parser(file_name, files, unpack, notes).parse(bytes);
}

}  // namespace ugoki::formats
