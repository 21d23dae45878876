#pragma once
// Mesh files that a description names: where they may lie, and their shapes, each read once; internal to robot_formats.

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/robot_formats/mesh_shape.h"
#include "ugoki/robot_formats/robot_model.h"

namespace ugoki::robot_formats {

/// Paths at which the file may lie that `uri` names in the description `file_name`, the likeliest first. `package://a/b/c` and
/// `model://a/b/c` are looked for in the description's folder and every folder above it, as a/b/c and then without
/// leading parts, because packages are copied in pieces; other paths are relative to the description's folder.
[[nodiscard]] std::vector<std::string> places_of(std::string_view uri, std::string_view file_name);

class Assets {
 public:
  Assets(AssetReader read, std::string_view file_name) : read_(std::move(read)), file_name_(file_name) {}

  /// The mesh whose vertices were multiplied by `scale`. Nothing where the file is absent; an Error where it is there but cannot
  /// be used. Kept for the next call. O(file)
  /// @param how exact, hull or box
  [[nodiscard]] const Result<std::optional<MeshShape>>& mesh(const std::string& uri, const Vec3& scale, Meshes how, bool collides);
  /// What was read so far.
  [[nodiscard]] std::vector<MeshRead> take_meshes() { return std::move(meshes_); }

 private:
  AssetReader read_;
  std::string file_name_;
  [[nodiscard]] Result<std::optional<MeshShape>> read(const std::string& uri, const Vec3& scale, Meshes how, bool collides);

  std::map<std::string, Result<std::optional<MeshShape>>, std::less<>> shapes_;
  std::vector<MeshRead> meshes_;
  std::size_t bytes_ = 0;  ///< read so far
  int absent_ = 0;
};

}  // namespace ugoki::robot_formats
