#pragma once
// Settings of assimp, and numbers in its metadata of a file, such as unit and up axis. Internal to scene_formats.

#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <optional>

namespace ugoki::scene_formats {

/// Sets what all readers of characters need: joints without pivot nodes, no cameras and lights, the axes of the file.
void set_importer(Assimp::Importer& importer);

/// Takes the scene from the importer for good if a mesh contains a bone twice (bones with equal names in an FBX file): the library would
/// free the bone twice. The memory is not freed; characters are read in a child process, which ends.
void keep_repeated_bones(Assimp::Importer& importer);

/// Returns the number `key`, of type double, float or int; nothing if the file does not state it.
[[nodiscard]] inline std::optional<double> metadata_number(const aiScene& scene, const char* key) {
  if (!scene.mMetaData) return std::nullopt;
  int whole = 0;
  float single = 0;
  double real = 0;
  if (scene.mMetaData->Get(key, real)) return real;
  if (scene.mMetaData->Get(key, single)) return static_cast<double>(single);
  if (scene.mMetaData->Get(key, whole)) return whole;
  return std::nullopt;
}

}  // namespace ugoki::scene_formats
