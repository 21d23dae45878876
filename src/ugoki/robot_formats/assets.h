#pragma once
// Mesh files of a robot description: the paths at which they are searched, and a cache of the shapes made from them.
// Internal to robot_formats.

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/robot_formats/mesh_shape.h"
#include "ugoki/robot_formats/robot_model.h"

namespace ugoki::robot_formats {

/// Returns the paths at which the file `uri` of the description `file_name` may be found, most likely path first. `package://a/b/c` and
/// `model://a/b/c` are searched as a/b/c, b/c and c, because packages are often copied in part. a/b/c and b/c are searched in the
/// description's folder and in every folder above it, c only in the description's folder. Paths without a scheme are relative to the
/// description's folder. Returns no path for other schemes (http://).
[[nodiscard]] std::vector<std::string> candidate_paths(std::string_view uri, std::string_view file_name);

/// Loads and caches the meshes of one description.
class Assets {
 public:
  Assets(AssetReader read, std::string_view file_name) : read_(std::move(read)), file_name_(file_name) {}

  /// Returns the mesh as a shape, after its vertices were multiplied by `scale`. std::nullopt if the file was not found; an Error if it was
  /// found but cannot be used. The result is cached. The first call for a mesh costs O(file size).
  /// @param how exact surface, convex hull or box
  /// @param collides whether the shape takes part in collision detection
  [[nodiscard]] const Result<std::optional<MeshShape>>& mesh(const std::string& uri, const Vec3& scale, Meshes how, bool collides);
  /// All meshes read so far.
  [[nodiscard]] std::vector<MeshRead> take_meshes() { return std::move(meshes_); }

 private:
  AssetReader read_;
  std::string file_name_;
  [[nodiscard]] Result<std::optional<MeshShape>> read(const std::string& uri, const Vec3& scale, Meshes how, bool collides);

  std::map<std::string, Result<std::optional<MeshShape>>, std::less<>> shapes_;
  std::vector<MeshRead> meshes_;
  std::size_t bytes_ = 0;  ///< total size of the mesh files read so far
  int absent_ = 0;         ///< number of mesh files that were not found
};

}  // namespace ugoki::robot_formats
