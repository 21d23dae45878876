#pragma once
// Access to the shared MJCF files, and a reader for the files that they refer to.

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "ugoki/files/files.h"
#include "ugoki/robot_formats/robot_model.h"

#define NEEDS_MJCF_DATA() \
  if (!std::filesystem::exists(data_folder())) GTEST_SKIP() << "the shared data are missing (" << data_folder() << ")"

namespace ugoki::robot_formats {

inline std::string data_folder() { return std::string(UGOKI_SHARED_DATA) + "/"; }
inline std::string load_data(const std::string& name) { return files::read_file(data_folder() + name).value_or(std::string()); }
/// Options that read asset files from the shared data.
inline RobotOptions data_options() {
  RobotOptions options;
  options.read_asset = [](const std::string& path) { return files::read_file(data_folder() + path); };
  return options;
}

}  // namespace ugoki::robot_formats
