#include "ugoki/scene_formats/fbx_mesh_ends.h"

#include <algorithm>
#include <numbers>
#include <vector>

#include "ugoki/formats/mesh_end.h"
#include "ugoki/spatial/rotation.h"

namespace ugoki::scene_formats {
namespace {

constexpr double max_number = 1e30;

/// The numbers of a child record; empty if it is missing or damaged.
std::vector<double> numbers_of(const FbxFile& file, const FbxRecord& record, std::string_view name) {
  const FbxRecord* child = record.child(name);
  if (!child || child->values.empty()) return {};
  Result<std::vector<double>> out = file.numbers(*child, max_number);
  return out ? std::move(*out) : std::vector<double>{};
}

/// Appends the vertices of one mesh to the points of the bones that move them most.
/// @param parts all of one mesh  @param points [out] by the name of the bone, in the bone's frame
void collect_points(const FbxFile& file, std::span<const FbxSkinPart> parts, std::map<std::string, std::vector<Vec3>>& points) {
  const std::vector<double> x = numbers_of(file, *parts[0].mesh, "Vertices");
  const std::size_t count = x.size() / 3;
  std::vector<double> heaviest(count, 0);
  std::vector<std::size_t> owner(count, parts.size());
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const std::vector<double> indices = numbers_of(file, *parts[k].cluster, "Indexes");
    const std::vector<double> weights = numbers_of(file, *parts[k].cluster, "Weights");
    if (indices.size() != weights.size()) continue;
    for (std::size_t i = 0; i < indices.size(); ++i) {
      if (!(indices[i] >= 0) || indices[i] >= static_cast<double>(count)) continue;
      const auto v = static_cast<std::size_t>(indices[i]);
      if (weights[i] <= heaviest[v]) continue;
      heaviest[v] = weights[i];
      owner[v] = k;
    }
  }
  for (std::size_t k = 0; k < parts.size(); ++k) {
    // The matrix from the mesh to the bone in the bind pose, in the order of row vectors: the last four numbers are the translation.
    const std::vector<double> t = numbers_of(file, *parts[k].cluster, "Transform");
    if (t.size() != 16) continue;
    const Mat3 A = Mat3::columns({t[0], t[1], t[2]}, {t[4], t[5], t[6]}, {t[8], t[9], t[10]});
    for (std::size_t v = 0; v < count; ++v)
      if (owner[v] == k) points[parts[k].bone].push_back(A * Vec3{x[3 * v], x[3 * v + 1], x[3 * v + 2]} + Vec3{t[12], t[13], t[14]});
  }
}

/// A vector in the properties of a model ("GeometricTranslation"); `usual` if the model has none.
Vec3 property_of(const FbxRecord& model, std::string_view name, const Vec3& usual) {
  const FbxRecord* all = model.child("Properties70");
  if (!all) return usual;
  for (const FbxRecord& p : all->children) {
    if (p.text(0) != name || p.values.size() < 7) continue;
    const Vec3 v{p.values[4].number, p.values[5].number, p.values[6].number};
    return is_finite(v) ? v : usual;
  }
  return usual;
}

/// Appends the vertices of a rigid mesh to the points of its model, displaced as the model's geometric transform states.
void collect_rigid_points(const FbxFile& file, const FbxRigidMesh& rigid, std::vector<Vec3>& points) {
  const std::vector<double> x = numbers_of(file, *rigid.mesh, "Vertices");
  const Vec3 t = property_of(*rigid.model, "GeometricTranslation", {}), scale = property_of(*rigid.model, "GeometricScaling", {1, 1, 1});
  const Vec3 angles = property_of(*rigid.model, "GeometricRotation", {}) * (std::numbers::pi / 180);
  const Mat3 R = rotation_about({0, 0, 1}, angles.z) * rotation_about({0, 1, 0}, angles.y) * rotation_about({1, 0, 0}, angles.x);
  for (std::size_t v = 0; 3 * v + 2 < x.size(); ++v)
    points.push_back(R * Vec3{scale.x * x[3 * v], scale.y * x[3 * v + 1], scale.z * x[3 * v + 2]} + t);
}

}  // namespace

std::map<std::string, Vec3> fbx_mesh_ends(const FbxFile& file, std::span<const FbxSkinPart> parts, std::span<const FbxRigidMesh> rigid) {
  std::map<const FbxRecord*, std::vector<FbxSkinPart>> by_mesh;
  for (const FbxSkinPart& p : parts) by_mesh[p.mesh].push_back(p);
  std::map<std::string, std::vector<Vec3>> points;
  for (const auto& [mesh, own] : by_mesh) collect_points(file, own, points);
  std::map<std::string, std::vector<Vec3>> rigid_points;
  for (const FbxRigidMesh& r : rigid)
    if (!points.contains(r.bone)) collect_rigid_points(file, r, rigid_points[r.bone]);
  points.merge(rigid_points);
  std::map<std::string, Vec3> out;
  for (const auto& [bone, own] : points)
    if (const std::optional<Vec3> end = formats::far_end(own); end && is_finite(*end)) out[bone] = *end;
  return out;
}

}  // namespace ugoki::scene_formats
