#pragma once
// FBX and COLLADA files: skeletons and their animations. What is read is described in docs/formats.md.

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/formats/read_notes.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::scene_formats {

struct SceneOptions {
  double rate = 0;             ///< frames a second to sample the animations at; 0: that of the densest keys
  double metres_per_unit = 0;  ///< 0: as the file says
  double seconds = 120;        ///< that reading may take
};

/// Reads all animations of a file from memory: one measured motion for each, on the skeleton of all skins' bones and the nodes between and
/// above them (files without skins: all nodes that move and those that hang on them). A file without animations gives one frame at rest.
/// Units and the axis that points up are those of the file. Another process reads; when it crashes, hangs, or wants more than
/// 4 GB, that is an Error like any other.
/// @param file_name its ending (.fbx, .dae) says which format; stands in the place of every problem
[[nodiscard]] Result<std::vector<MeasuredMotion>> read_scene(std::span<const std::byte> bytes, std::string_view file_name,
                                                             const SceneOptions& options = {}, formats::ReadNotes* notes = nullptr);

/// The same in this process, without any guard: for the child process and for tests that look for crashes on purpose.
[[nodiscard]] Result<std::vector<MeasuredMotion>> read_scene_unguarded(std::span<const std::byte> bytes, std::string_view file_name,
                                                                       const SceneOptions& options, formats::ReadNotes& notes);

}  // namespace ugoki::scene_formats
