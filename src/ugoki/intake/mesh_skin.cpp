#include "ugoki/intake/mesh_skin.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "ugoki/formats/file_skin.h"

namespace ugoki::intake {
namespace {

constexpr double crease = 0.766;  // cosine of 40 degrees: triangles that meet at a larger angle have an edge

/// Normals of the corners of triangles whose vertices have none: of each corner, the mean of the triangles at its place that are turned by
/// less than the crease, weighted with their areas.
class CornerNormals {
 public:
  CornerNormals(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles) : vertices_(vertices) {
    for (const Triangle& t : triangles) {
      const Vec3 n = normal_of(t);
      for (const std::int32_t v : t) at_[key(v)].push_back(n);
    }
  }
  [[nodiscard]] Vec3 at(const Triangle& t, std::int32_t v) const {
    const Vec3 own = normalized(normal_of(t));
    Vec3 sum;
    for (const Vec3& n : at_.at(key(v)))
      if (dot(n, own) >= crease * norm(n)) sum += n;
    return normalized(sum, own);
  }

 private:
  using Place = std::array<double, 3>;
  [[nodiscard]] Place key(std::int32_t v) const {
    const Vec3& p = vertices_[static_cast<std::size_t>(v)];
    return {p.x, p.y, p.z};
  }
  [[nodiscard]] Vec3 normal_of(const Triangle& t) const {
    const Vec3& p = vertices_[static_cast<std::size_t>(t[0])];
    return cross(vertices_[static_cast<std::size_t>(t[1])] - p, vertices_[static_cast<std::size_t>(t[2])] - p);
  }
  const std::vector<Vec3>& vertices_;
  std::map<Place, std::vector<Vec3>> at_;  ///< normals of the triangles at a place, twice their areas long
};

}  // namespace

SkinPtr make_mesh_skin(const scene_formats::MeshScene& scene, const std::vector<Vec3>& vertices, std::string_view location,
                       std::vector<std::string>& checks) {
  if (std::ranges::none_of(scene.parts, [](const scene_formats::MeshPart& p) { return p.texture >= 0; })) return nullptr;
  formats::FileSkin file;
  file.bones.emplace_back();
  Skin& skin = file.skin;
  const auto add_vertex = [&](std::size_t v, const Vec3& n) {
    for (int k = 0; k < 3; ++k) skin.positions.push_back(static_cast<float>(vertices[v][k]));
    for (int k = 0; k < 3; ++k) skin.normals.push_back(static_cast<float>(n[k]));
    skin.uvs.insert(skin.uvs.end(), {scene.uvs[2 * v], scene.uvs[2 * v + 1]});
  };
  for (std::size_t v = 0; v < vertices.size(); ++v) add_vertex(v, normalized(scene.normals[v]));
  for (const scene_formats::MeshPart& part : scene.parts) {
    SkinPart out{part.texture >= 0 || part.color.empty() ? part.tint : part.color,
                 part.texture,
                 static_cast<std::uint32_t>(skin.indices.size()),
                 0,
                 part.cutoff,
                 part.both_sides};
    const auto has_normal = [&](std::int32_t v) { return norm(scene.normals[static_cast<std::size_t>(v)]) > 0; };
    std::vector<Triangle> bare;
    for (const Triangle& t : part.triangles)
      if (!std::ranges::all_of(t, has_normal)) bare.push_back(t);
    const CornerNormals normals(vertices, bare);
    for (const Triangle& t : part.triangles)
      for (const std::int32_t v : t) {
        if (std::ranges::all_of(t, has_normal)) {
          skin.indices.push_back(static_cast<std::uint32_t>(v));
          continue;
        }
        skin.indices.push_back(static_cast<std::uint32_t>(skin.vertex_count()));
        add_vertex(static_cast<std::size_t>(v), normals.at(t, v));
      }
    out.count = static_cast<std::uint32_t>(skin.indices.size()) - out.first;
    if (out.count > 0) skin.parts.push_back(std::move(out));
  }
  skin.textures = scene.textures;
  skin.bones.assign(4 * skin.vertex_count(), 0);
  skin.weights.assign(4 * skin.vertex_count(), 0);
  for (std::size_t v = 0; v < skin.vertex_count(); ++v) skin.weights[4 * v] = 65535;
  formats::remove_unused(file);
  Error problems;
  check_skin(skin, 1, location, problems);
  if (!problems.empty()) {
    checks.push_back("The textures are left out: " + problems.problems[0].message);
    return nullptr;
  }
  return std::make_shared<Skin>(std::move(skin));
}

}  // namespace ugoki::intake
