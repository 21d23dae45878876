#pragma once
// Runs Blender without a window on a script of this folder.

#include <string>

namespace ugoki {

/// A temporary folder, removed by the destructor; `path` is empty if it could not be created.
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
/// Runs a script.
/// @param script name of a file in this folder
/// @param arguments separated by blanks; an argument must not contain blanks
[[nodiscard]] BlenderOutput run_blender(const std::string& script, const std::string& arguments, const TemporaryFolder& folder);

[[nodiscard]] std::string text_of_file(const std::string& path);

}  // namespace ugoki
