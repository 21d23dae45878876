#pragma once
// Reads skeletons and their animations from FBX and COLLADA files. docs/formats.md lists what is read.

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/formats/read_notes.h"
#include "ugoki/motion/skeleton.h"
#include "ugoki/scene_formats/scene_places.h"

namespace ugoki::scene_formats {

/// Options of read_scene().
struct SceneOptions {
  double rate = 0;             ///< sampling rate of the animations, Hz; 0: the rate of the channel with the most closely spaced keys
  double metres_per_unit = 0;  ///< m per file unit of length; 0: as the file specifies
  bool mesh_ends = false;      ///< FBX: gives joints without children the far ends of their meshes as end sites; otherwise they have none
  double seconds = 120;        ///< maximum time for reading, s
};

/// Reads all animations of a file from memory and returns one measured motion for each. The skeleton consists of the bones of all skins,
/// the nodes between them, and the animated nodes above them. In a file without skins it consists of all animated nodes and their
/// descendants without meshes. A file without animations gives one frame in the rest pose. The file's unit and up axis are converted to
/// metres and Z up. The file is parsed in a child process. If this process crashes, exceeds the time limit, or needs more than 4 GB, the
/// result is an Error.
/// @param file_name its extension (.fbx, .dae) selects the format; the name appears in the location of every problem
/// @param notes receives unit, axis and remarks; may be null
[[nodiscard]] Result<std::vector<MeasuredMotion>> read_scene(std::span<const std::byte> bytes, std::string_view file_name,
                                                             const SceneOptions& options = {}, formats::ReadNotes* notes = nullptr);

/// The same as read_scene(), but in the calling process, without protection. Used by the child process and by tests for crashes.
/// @param places receives the places of the nodes; may be null
[[nodiscard]] Result<std::vector<MeasuredMotion>> read_scene_unguarded(std::span<const std::byte> bytes, std::string_view file_name,
                                                                       const SceneOptions& options, formats::ReadNotes& notes,
                                                                       NodePlaces* places = nullptr);

}  // namespace ugoki::scene_formats
