#pragma once
// The shared data as a list of files, and functions that read each file with the reader of its format.

#include <gtest/gtest.h>

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "ugoki/motion/markers.h"
#include "ugoki/motion/skeleton.h"
#include "ugoki/robot_formats/robot_model.h"

#define NEEDS_SHARED_FILES() \
  if (ugoki::shared_files().empty()) GTEST_SKIP() << "the shared data were not found (" << UGOKI_SHARED_DATA << ")"

namespace ugoki {

/// All files of the folders human, animal, gltf and mechanism, as paths relative to the data's folder, sorted by path.
[[nodiscard]] std::vector<std::string> shared_files();
/// Files with one of these extensions (lower case, with the dot).
[[nodiscard]] std::vector<std::string> shared_files(std::initializer_list<const char*> endings);
/// Extension in lower case, with the dot; empty for "LICENSE".
[[nodiscard]] std::string ending_of(const std::string& path);

[[nodiscard]] std::string shared_text(const std::string& path);
[[nodiscard]] inline std::span<const std::byte> bytes_of(const std::string& text) { return std::as_bytes(std::span(text)); }

/// Skeleton file of an AMC file: "human/asf_amc/02.asf" for "human/asf_amc/02_01.amc".
[[nodiscard]] std::string skeleton_path(const std::string& amc);

/// glTF files whose buffers all exist.
[[nodiscard]] bool is_whole(const std::string& gltf);

/// All motions of a BVH, AMC or glTF file; the test fails if the file is refused.
[[nodiscard]] std::vector<MeasuredMotion> read_motions(const std::string& path);
/// The recording of a C3D or TRC file.
[[nodiscard]] MarkerMotion read_markers(const std::string& path);
/// Reads URDF (with the loops of its YAML file), SDF or MJCF, including other files of the folder. Meshes are left out by default.
[[nodiscard]] Result<robot_formats::RobotModel> read_robot(const std::string& path,
                                                           robot_formats::RobotOptions options = {.meshes = robot_formats::Meshes::none});

}  // namespace ugoki
