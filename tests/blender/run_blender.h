#pragma once
// Blender without a window, on a script of this folder.

#include <string>

namespace ugoki {

/// A folder that goes with its owner; path is empty where it could not be made.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::string path;
};

[[nodiscard]] bool blender_is_installed();

struct BlenderOutput {
  int status = -1;
  std::string text;
};
/// @param script of this folder  @param arguments without blanks, separated by them
[[nodiscard]] BlenderOutput run_blender(const std::string& script, const std::string& arguments, const TemporaryFolder& folder);

[[nodiscard]] std::string text_of_file(const std::string& path);

}  // namespace ugoki
