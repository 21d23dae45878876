#include "ugoki/formats/file_skin.h"

#include <algorithm>
#include <cmath>

namespace ugoki::formats {
namespace {

Vec3 point(const std::vector<float>& list, std::size_t i) {
  return {static_cast<double>(list[3 * i]), static_cast<double>(list[3 * i + 1]), static_cast<double>(list[3 * i + 2])};
}

/// Places of the marked entries after the others were removed; -1: removed.
std::vector<std::int64_t> places_of(const std::vector<char>& used) {
  std::vector<std::int64_t> place(used.size(), -1);
  std::int64_t next = 0;
  for (std::size_t i = 0; i < used.size(); ++i)
    if (used[i] != 0) place[i] = next++;
  return place;
}

/// Moves the rows [width values each] of a list to their places.
template <class T>
void keep_rows(std::vector<T>& list, std::size_t width, const std::vector<std::int64_t>& place) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < place.size(); ++i) {
    if (place[i] < 0) continue;
    const auto to = static_cast<std::size_t>(place[i]);
    for (std::size_t k = 0; to != i && k < width; ++k) list[width * to + k] = std::move(list[width * i + k]);
    ++count;
  }
  list.resize(width * count);
}

}  // namespace

void add_weights(Skin& skin, std::vector<std::pair<std::uint16_t, double>>& shares) {
  std::erase_if(shares, [](const auto& s) { return !(s.second > 0 && s.second < 1e9); });
  std::ranges::sort(shares, [](const auto& a, const auto& b) { return a.second != b.second ? a.second > b.second : a.first < b.first; });
  const std::size_t count = std::min<std::size_t>(shares.size(), 4);
  double sum = 0;
  for (std::size_t k = 0; k < count; ++k) sum += shares[k].second;
  int left = 65535;
  for (std::size_t k = 4; k-- > 1;) {  // the heaviest bone gets what rounding leaves
    const auto weight = k < count ? static_cast<int>(std::floor(65535 * shares[k].second / sum + 0.5)) : 0;
    left -= weight;
  }
  for (std::size_t k = 0; k < 4; ++k) {
    skin.bones.push_back(k < count ? shares[k].first : std::uint16_t{0});
    skin.weights.push_back(static_cast<std::uint16_t>(k == 0      ? left
                                                      : k < count ? static_cast<int>(std::floor(65535 * shares[k].second / sum + 0.5))
                                                                  : 0));
  }
}

void add_normals(Skin& skin, std::size_t first, std::size_t first_index) {
  std::vector<Vec3> sums(skin.vertex_count() - first);
  for (std::size_t i = first_index; i + 2 < skin.indices.size(); i += 3) {
    const std::uint32_t *corner = &skin.indices[i], a = corner[0], b = corner[1], c = corner[2];
    const Vec3 p = point(skin.positions, a), normal = cross(point(skin.positions, b) - p, point(skin.positions, c) - p);
    for (const std::uint32_t v : {a, b, c}) sums[v - first] += normal;
  }
  skin.normals.resize(3 * first);
  for (const Vec3& sum : sums) {
    const Vec3 n = normalized(sum, {0, 0, 1});
    for (int k = 0; k < 3; ++k) skin.normals.push_back(static_cast<float>(n[k]));
  }
}

void add_colors(Skin& skin, std::size_t first, std::span<const double> linear) {
  if (linear.empty() && skin.colors.empty()) return;
  skin.colors.resize(3 * first, 65535);
  for (const double x : linear)  // false for a value that is not a number
    skin.colors.push_back(x > 0 ? static_cast<std::uint16_t>(std::floor(65535 * std::min(x, 1.0) + 0.5)) : std::uint16_t{0});
  skin.colors.resize(3 * skin.vertex_count(), 65535);
}

void remove_unused(FileSkin& file) {
  Skin& s = file.skin;
  std::vector<char> vertices(s.vertex_count(), 0), bones(file.bones.size(), 0), textures(s.textures.size(), 0);
  for (const std::uint32_t i : s.indices) vertices[i] = 1;
  const std::vector<std::int64_t> place = places_of(vertices);
  keep_rows(s.positions, 3, place);
  keep_rows(s.normals, 3, place);
  keep_rows(s.uvs, 2, place);
  if (!s.colors.empty()) keep_rows(s.colors, 3, place);
  keep_rows(s.bones, 4, place);
  keep_rows(s.weights, 4, place);
  for (std::uint32_t& i : s.indices) i = static_cast<std::uint32_t>(place[i]);
  for (std::size_t i = 0; i < s.bones.size(); ++i)
    if (s.weights[i] > 0) bones[s.bones[i]] = 1;
  const std::vector<std::int64_t> bone_place = places_of(bones);
  keep_rows(file.bones, 1, bone_place);
  for (std::size_t i = 0; i < s.bones.size(); ++i)
    s.bones[i] = s.weights[i] > 0 ? static_cast<std::uint16_t>(bone_place[s.bones[i]]) : std::uint16_t{0};
  for (const SkinPart& part : s.parts)
    if (part.texture >= 0) textures[static_cast<std::size_t>(part.texture)] = 1;
  const std::vector<std::int64_t> texture_place = places_of(textures);
  keep_rows(s.textures, 1, texture_place);
  for (SkinPart& part : s.parts)
    if (part.texture >= 0) part.texture = static_cast<int>(texture_place[static_cast<std::size_t>(part.texture)]);
}

}  // namespace ugoki::formats
