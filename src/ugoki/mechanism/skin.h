#pragma once
// The skin of a character: a textured surface whose vertices follow the links. It is drawn only; it has no mass and does not collide.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/spatial/spatial.h"

namespace ugoki {

/// A picture in the form of its file.
struct SkinTexture {
  std::string type;  ///< "image/png" or "image/jpeg"
  std::vector<std::byte> data;
};

/// The triangles of one material.
struct SkinPart {
  std::string color = "#ffffff";  ///< "#rrggbb", base colour; multiplied by that of the texture
  int texture = -1;               ///< index in Skin::textures; -1: none
  std::uint32_t first = 0;        ///< index in Skin::indices of the first corner
  std::uint32_t count = 0;        ///< number of corners, three for each triangle
  double cutoff = 0;              ///< 0 ... 1: where the texture's alpha is below, nothing is drawn
  bool both_sides = false;        ///< also triangles that are seen from behind are drawn
};

/// Surface with weights. Vertices are in the frame and unit of their bones (SkinBone::A maps them to metres). Immutable once made.
struct Skin {
  std::vector<float> positions;  ///< [vertices][3]
  std::vector<float> normals;    ///< [vertices][3] unit vectors
  std::vector<float> uvs;        ///< [vertices][2] of the textures; (0, 0) is the top left corner of the picture
  /// [vertices][3] linear red, green and blue in 1/65535, multiplied with colour and texture of the part; empty: all white
  std::vector<std::uint16_t> colors;
  std::vector<std::uint16_t> bones;    ///< [vertices][4] indices in MechanismSpec::skin_bones
  std::vector<std::uint16_t> weights;  ///< [vertices][4] shares of the bones, in 1/65535; their sum is 65535
  std::vector<std::uint32_t> indices;  ///< corners of the triangles: indices of vertices
  std::vector<SkinPart> parts;         ///< disjoint
  std::vector<SkinTexture> textures;

  [[nodiscard]] std::size_t vertex_count() const { return positions.size() / 3; }
  [[nodiscard]] std::size_t triangle_count() const { return indices.size() / 3; }
};
using SkinPtr = std::shared_ptr<const Skin>;

/// Attaches a bone of a skin to a link: a vertex v [bone's unit] is at A v + p [m] in the link's frame.
struct SkinBone {
  std::string link;
  Mat3 A = Mat3::identity();  ///< rotation and scale
  Vec3 p;                     ///< m
};

inline constexpr std::size_t max_skin_vertices = 500'000;
inline constexpr std::size_t max_skin_triangles = 1'000'000;
inline constexpr std::size_t max_skin_bones = 2'000;
inline constexpr std::size_t max_skin_parts = 256;
inline constexpr std::size_t max_texture_bytes = std::size_t{16} << 20;  ///< of one texture
inline constexpr std::size_t max_skin_bytes = std::size_t{48} << 20;     ///< of all textures of a skin
inline constexpr int max_texture_side = 8192;                            ///< pixels

/// Width and height of a picture [pixels], from the head of its file.
struct PictureSize {
  int width = 0, height = 0;
};
/// Reads the size and sets `type` to "image/png" or "image/jpeg"; std::nullopt for other files and damaged ones.
[[nodiscard]] std::optional<PictureSize> picture_size(std::span<const std::byte> data, std::string& type);

/// Adds a problem for each list of the skin whose length, indices, weights or values are wrong, and for pictures that are none or too
/// large. @param bones number of bones  O(vertices + triangles)
void check_skin(const Skin& skin, std::size_t bones, std::string_view location, Error& problems);

/// Bytes of the skin in memory, with its textures.
[[nodiscard]] std::size_t bytes_of(const Skin& skin);

/// World position [m] of a vertex. @param links [bones] world pose of the link of each bone
[[nodiscard]] Vec3 skinned_point(const Skin& skin, std::span<const SkinBone> bones, std::span<const Pose> links, std::size_t vertex);

}  // namespace ugoki
