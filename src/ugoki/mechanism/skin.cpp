#include "ugoki/mechanism/skin.h"

#include <algorithm>
#include <cmath>

namespace ugoki {
namespace {

int byte_at(std::span<const std::byte> data, std::size_t at) { return std::to_integer<int>(data[at]); }
int big16(std::span<const std::byte> data, std::size_t at) { return byte_at(data, at) << 8 | byte_at(data, at + 1); }

std::optional<PictureSize> png_size(std::span<const std::byte> data) {
  constexpr unsigned char head[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n', 0, 0, 0, 13, 'I', 'H', 'D', 'R'};
  if (data.size() < 33 || !std::equal(std::begin(head), std::end(head), data.begin(),
                                      [](unsigned char a, std::byte b) { return a == std::to_integer<unsigned char>(b); }))
    return std::nullopt;
  if (big16(data, 16) != 0 || big16(data, 20) != 0) return PictureSize{1 << 16, 1 << 16};  // larger than any limit
  return PictureSize{big16(data, 18), big16(data, 22)};
}

/// The size is in the frame header, which follows other segments.
std::optional<PictureSize> jpeg_size(std::span<const std::byte> data) {
  if (data.size() < 4 || big16(data, 0) != 0xffd8) return std::nullopt;
  std::size_t at = 2;
  while (at + 9 < data.size() && byte_at(data, at) == 0xff) {
    const int marker = byte_at(data, at + 1);
    if (marker == 0xff) {  // padding
      ++at;
      continue;
    }
    const bool frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (frame) return PictureSize{big16(data, at + 7), big16(data, at + 5)};
    at += 2 + static_cast<std::size_t>(big16(data, at + 2));
  }
  return std::nullopt;
}

bool all_finite(const std::vector<float>& values) {
  return std::ranges::all_of(values, [](float x) { return std::fabs(x) <= 1e9f; });
}

}  // namespace

std::optional<PictureSize> picture_size(std::span<const std::byte> data, std::string& type) {
  std::optional<PictureSize> size = png_size(data);
  type = size ? "image/png" : "image/jpeg";
  if (!size) size = jpeg_size(data);
  if (size && (size->width < 1 || size->height < 1)) return std::nullopt;
  return size;
}

void check_skin(const Skin& skin, std::size_t bones, std::string_view location, Error& problems) {
  const auto wrong = [&](const char* what) {
    problems.add(ErrorCode::structure, std::string(location), std::string("The skin is damaged: ") + what + ".",
                 "Import the character's file again, or remove \"skin\".");
  };
  const std::size_t n = skin.vertex_count();
  if (n == 0 || n > max_skin_vertices || skin.positions.size() != 3 * n) return wrong("the number of vertices is out of range");
  if (skin.normals.size() != 3 * n || skin.uvs.size() != 2 * n || skin.bones.size() != 4 * n || skin.weights.size() != 4 * n)
    return wrong("its lists have different lengths");
  if (!skin.colors.empty() && skin.colors.size() != 3 * n) return wrong("the number of colours differs from that of the vertices");
  if (!all_finite(skin.positions) || !all_finite(skin.normals) || !all_finite(skin.uvs)) return wrong("a value is not finite");
  if (bones == 0 || bones > max_skin_bones) return wrong("the number of bones is out of range");
  if (std::ranges::any_of(skin.bones, [&](std::uint16_t b) { return b >= bones; })) return wrong("a vertex has a bone that does not exist");
  for (std::size_t v = 0; v < n; ++v) {
    int sum = 0;
    for (std::size_t k = 0; k < 4; ++k) sum += skin.weights[4 * v + k];
    if (sum != 65535) return wrong("the weights of a vertex do not add up to 1");
  }
  if (skin.indices.empty() || skin.indices.size() % 3 != 0 || skin.triangle_count() > max_skin_triangles)
    return wrong("the number of triangles is out of range");
  if (std::ranges::any_of(skin.indices, [&](std::uint32_t i) { return i >= n; }))
    return wrong("a triangle has a vertex that does not exist");
  if (skin.parts.empty() || skin.parts.size() > max_skin_parts) return wrong("the number of materials is out of range");
  for (const SkinPart& part : skin.parts)
    if (part.count % 3 != 0 || part.first > skin.indices.size() || part.count > skin.indices.size() - part.first ||
        part.texture >= static_cast<int>(skin.textures.size()) || !(part.cutoff >= 0 && part.cutoff <= 1))
      return wrong("a material has a wrong range, texture or cut-off");
  std::size_t bytes = 0;
  for (const SkinTexture& t : skin.textures) {
    std::string type;
    const std::optional<PictureSize> size = picture_size(t.data, type);
    if (!size || type != t.type) return wrong("a texture is neither PNG nor JPEG");
    if (t.data.size() > max_texture_bytes || std::max(size->width, size->height) > max_texture_side ||
        (bytes += t.data.size()) > max_skin_bytes)
      return wrong("a texture is too large");
  }
}

std::size_t bytes_of(const Skin& skin) {
  std::size_t sum = 4 * (skin.positions.size() + skin.normals.size() + skin.uvs.size() + skin.indices.size()) +
                    2 * (skin.bones.size() + skin.weights.size() + skin.colors.size());
  for (const SkinTexture& t : skin.textures) sum += t.data.size();
  return sum;
}

Vec3 skinned_point(const Skin& skin, std::span<const SkinBone> bones, std::span<const Pose> links, std::size_t vertex) {
  const float* x = skin.positions.data() + 3 * vertex;
  const Vec3 v{static_cast<double>(x[0]), static_cast<double>(x[1]), static_cast<double>(x[2])};
  Vec3 out;
  for (std::size_t k = 0; k < 4; ++k) {
    const std::size_t b = skin.bones[4 * vertex + k];
    const double w = skin.weights[4 * vertex + k] / 65535.0;
    if (w > 0) out += w * (links[b] * (bones[b].A * v + bones[b].p));
  }
  return out;
}

}  // namespace ugoki
