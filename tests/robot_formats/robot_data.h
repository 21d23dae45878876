#pragma once
// Access to the shared URDF and SDF files and the files that they refer to.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "ugoki/files/files.h"
#include "ugoki/robot_formats/robot_model.h"

#define NEEDS_ROBOT_DATA() \
  if (!std::filesystem::exists(robot_folder())) GTEST_SKIP() << "the shared data are missing (" << robot_folder() << ")"

namespace ugoki::robot_formats {

inline std::string robot_folder() { return std::string(UGOKI_SHARED_DATA) + "/mechanism/"; }

/// Sorted paths of the shared files with this extension.
inline std::vector<std::string> robot_files(const std::string& ending) {
  std::vector<std::string> out;
  for (const auto& e : std::filesystem::recursive_directory_iterator(robot_folder()))
    if (e.path().extension() == ending) out.push_back(e.path().string());
  std::sort(out.begin(), out.end());
  return out;
}

inline std::string load_robot(const std::string& path) { return files::read_file(path).value_or(std::string()); }

/// Options that read meshes from disk, and the loops from the YAML file with the same base name, if it exists.
inline RobotOptions options_for(const std::string& path, bool with_loops = true) {
  RobotOptions options;
  options.read_asset = [](const std::string& asset) { return files::read_file(asset); };
  const std::string yaml = std::filesystem::path(path).replace_extension(".yaml").string();
  if (with_loops && std::filesystem::exists(yaml)) options.loops = SideFile{yaml, load_robot(yaml)};
  return options;
}

/// Last folder and file name, "5bar_linkage/robot.urdf": enough to identify a shared file.
inline std::string short_path(const std::string& path) {
  const std::filesystem::path p(path);
  return (p.parent_path().filename() / p.filename()).string();
}

}  // namespace ugoki::robot_formats
