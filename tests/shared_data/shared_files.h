#pragma once
// The shared data as a list of files, each read by the reader that is meant for it.

#include <gtest/gtest.h>

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "ugoki/motion/markers.h"
#include "ugoki/motion/skeleton.h"
#include "ugoki/robot_formats/robot_model.h"

#define NEEDS_SHARED_FILES() \
  if (ugoki::shared_files().empty()) GTEST_SKIP() << "the shared data are not here (" << UGOKI_SHARED_DATA << ")"

namespace ugoki {

/// All files of the folders human, animal, gltf and mechanism, as paths relative to the data's folder, in order.
[[nodiscard]] std::vector<std::string> shared_files();
/// Those with one of these endings (small letters, with the dot).
[[nodiscard]] std::vector<std::string> shared_files(std::initializer_list<const char*> endings);
/// In small letters, with the dot; of "LICENSE" empty.
[[nodiscard]] std::string ending_of(const std::string& path);

[[nodiscard]] std::string shared_text(const std::string& path);
[[nodiscard]] inline std::span<const std::byte> bytes_of(const std::string& text) { return std::as_bytes(std::span(text)); }

/// "human/asf_amc/02_01.amc" -> "human/asf_amc/02.asf".
[[nodiscard]] std::string skeleton_path(const std::string& amc);

/// glTF files whose buffers all are there.
[[nodiscard]] bool is_whole(const std::string& gltf);

/// All motions of a BVH, AMC or glTF file; a failure of the test where it is refused.
[[nodiscard]] std::vector<MeasuredMotion> read_motions(const std::string& path);
/// The recording of a C3D or TRC file.
[[nodiscard]] MarkerMotion read_markers(const std::string& path);
/// URDF (with the loops that its YAML names), SDF or MJCF. Meshes are left out unless told; files beside it are read.
[[nodiscard]] Result<robot_formats::RobotModel> read_robot(const std::string& path,
                                                           robot_formats::RobotOptions options = {.meshes = robot_formats::Meshes::none});

}  // namespace ugoki
