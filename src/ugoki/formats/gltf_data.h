#pragma once
// The JSON and the buffers of a glTF file, with checked access to their values. Internal to formats.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "ugoki/formats/gltf_unpack.h"
#include "ugoki/formats/text.h"
#include "ugoki/json/json.h"

namespace ugoki::formats {

inline constexpr const char* gltf_again = "Export the file again.";
inline constexpr std::size_t gltf_numbers = 50'000'000;  ///< limit for the values of all accessors together; 400 MB as doubles

inline std::uint32_t gltf_little32(const std::byte* p) {
  std::uint32_t v = 0;
  std::memcpy(&v, p, 4);
  return v;
}

inline int gltf_base64_value(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  return c == '+' || c == '-' ? 62 : c == '/' || c == '_' ? 63 : -1;
}

/// Decodes base64 (RFC 4648) with or without padding, also in the URL alphabet. Returns std::nullopt if `text` is not base64.
inline std::optional<std::vector<std::byte>> gltf_base64(std::string_view text) {
  std::vector<std::byte> out;
  out.reserve(text.size() / 4 * 3);
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    if (c == '=') break;
    const int v = gltf_base64_value(c);
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
inline std::string gltf_unescaped(std::string_view uri) {
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

/// JSON and buffers. Functions that return bool return false after they have set error_.
class GltfData {
 public:
  using Json = json::Json;
  GltfData(std::string_view name, const GltfFiles& files, const GltfUnpack& unpack, ReadNotes& notes)
      : name_(name), files_(files), unpack_(unpack), notes_(notes) {}

 protected:
  bool refuse(ErrorCode code, const std::string& path, const std::string& message, const std::string& remedy = gltf_again) {
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
      if (gltf_little32(bytes.data() + 4) != 2)
        return refuse(ErrorCode::unsupported, "header",
                      "Version " + std::to_string(gltf_little32(bytes.data() + 4)) + " of glTF is not supported.",
                      "Export the file as glTF 2.0.");
      if (gltf_little32(bytes.data() + 8) > bytes.size())
        return refuse(ErrorCode::truncated, "header", "The file is shorter than its header specifies.");
      const std::size_t length = gltf_little32(bytes.data() + 12);
      if (20 + length > bytes.size()) return refuse(ErrorCode::truncated, "chunk 0", "The file ends within its JSON chunk.");
      if (gltf_little32(bytes.data() + 16) != 0x4E4F534A) return refuse(ErrorCode::syntax, "chunk 0", "The first chunk is not JSON.");
      text = text.substr(20, length);
      while (!text.empty() && (text.back() == ' ' || text.back() == '\0')) text.remove_suffix(1);
      const std::size_t at = 20 + length;
      if (at + 8 <= bytes.size() && gltf_little32(bytes.data() + at + 4) == 0x004E4942) {
        const std::size_t size = gltf_little32(bytes.data() + at);
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
        auto bytes = comma == std::string::npos ? std::nullopt : gltf_base64(std::string_view(uri).substr(comma + 8));
        if (!bytes) return refuse(ErrorCode::syntax, path("buffers", i) + "/uri", "The data are not valid base64.");
        buffers_.push_back(std::move(*bytes));
      } else {
        if (!files_)
          return refuse(ErrorCode::unsupported, path("buffers", i) + "/uri",
                        "The file refers to " + path_in_quotes(uri) + ", which is not available.",
                        "Use a .glb file, or provide both files together.");
        auto bytes = files_(gltf_unescaped(uri));
        if (!bytes) {
          error_ = std::move(bytes.error());
          return false;
        }
        buffers_.push_back(std::move(*bytes));
      }
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
    const auto count = index(json, "count", gltf_numbers / components);
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
    if (read_ > gltf_numbers)
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
    const auto count = index(packing, "count", gltf_numbers), stride = index(packing, "byteStride", 257);
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
      case 5126: return static_cast<double>(std::bit_cast<float>(gltf_little32(p)));
      case 5125: return gltf_little32(p);
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
};

}  // namespace ugoki::formats
