#include "ugoki/robot_formats/assets.h"

#include <utility>

#include "ugoki/base/number.h"

namespace ugoki::robot_formats {
namespace {

constexpr std::size_t max_parts = 12;                    // limits of the search: number of folders, and number of shortened paths
constexpr std::size_t max_bytes = std::size_t{1} << 31;  // total size of all mesh files of one description
constexpr int max_absent = 500;                          // missing files after which the search ends, because each search tries many paths

/// Returns the folder of the file and its parent folders: "a/c.urdf" gives "a/", "", "../", "../../" ... At most `max_parts` folders.
std::vector<std::string> folders_above(std::string_view file_name) {
  std::vector<std::string> out;
  std::size_t slash = file_name.rfind('/');
  while (slash != std::string_view::npos && out.size() < max_parts) {
    out.emplace_back(file_name.substr(0, slash + 1));
    if (slash == 0) return out;
    slash = file_name.rfind('/', slash - 1);
  }
  for (std::string above; !file_name.starts_with('/') && out.size() < max_parts; above += "../") out.push_back(above);
  return out;
}

}  // namespace

std::vector<std::string> candidate_paths(std::string_view uri, std::string_view file_name) {
  std::string_view path = uri;
  bool searched = false;
  for (const std::string_view scheme : {"package://", "model://", "file://"}) {
    if (!uri.starts_with(scheme)) continue;
    path.remove_prefix(scheme.size());
    searched = scheme != "file://";
  }
  if (path.empty() || path.find("://") != std::string_view::npos) return {};
  const std::vector<std::string> folders = folders_above(file_name);
  if (!searched) return {path.starts_with('/') ? std::string(path) : (folders.empty() ? "" : folders.front()) + std::string(path)};
  while (path.starts_with('/')) path.remove_prefix(1);
  std::vector<std::string> out;
  for (std::size_t part = 0; part < max_parts && !path.empty(); ++part) {
    const bool bare = path.find('/') == std::string_view::npos;  // a file name without folders is searched only in the description's folder
    for (std::size_t i = 0; i < (bare ? 1 : folders.size()); ++i) out.push_back(folders[i] + std::string(path));
    if (bare) break;
    path.remove_prefix(path.find('/') + 1);
    while (path.starts_with('/')) path.remove_prefix(1);
  }
  return out;
}

const Result<std::optional<MeshShape>>& Assets::mesh(const std::string& uri, const Vec3& scale, Meshes how, bool collides) {
  const std::string key = uri + " " + to_text(scale.x) + " " + to_text(scale.y) + " " + to_text(scale.z) + (collides ? " c" : "");
  if (const auto it = shapes_.find(key); it != shapes_.end()) return it->second;
  return shapes_.emplace(key, read(uri, scale, how, collides)).first->second;
}

Result<std::optional<MeshShape>> Assets::read(const std::string& uri, const Vec3& scale, Meshes how, bool collides) {
  if (!read_ || absent_ >= max_absent) return std::nullopt;
  for (const std::string& path : candidate_paths(uri, file_name_)) {
    const Result<std::string> bytes = read_(path);
    if (!bytes) continue;
    bytes_ += bytes->size();
    if (bytes_ > max_bytes)
      return fail(ErrorCode::range, path, "The meshes of this description have more than 2 GB in total.",
                  "Reduce the meshes, or read without them.");
    Result<MeshFile> mesh = read_mesh(*bytes, path);
    if (!mesh) return fail(std::move(mesh.error()));
    for (Vec3& p : mesh->points) p = {p.x * scale.x, p.y * scale.y, p.z * scale.z};
    if (scale.x * scale.y * scale.z < 0)
      for (auto& [a, b, c] : mesh->triangles) std::swap(b, c);
    Result<MeshShape> shape = shape_of_mesh(*mesh, how, collides, path);
    if (!shape) return fail(std::move(shape.error()));
    const GeometryPtr& geometry = shape->shape.geometry;
    meshes_.push_back({path, mesh->points.size(), mesh->triangles.size(), geometry ? geometry->hash : 0, shape->found});
    return std::move(*shape);
  }
  ++absent_;
  return std::nullopt;
}

}  // namespace ugoki::robot_formats
