#pragma once
// Reads skeletons and their animations from USD text files. docs/formats.md lists what is read.

#include <string_view>

#include "ugoki/scene_formats/scene_file.h"

namespace ugoki::scene_formats {

/// Reads the UsdSkel skeletons of a file with their animations. In a file without skeletons, the prims whose transformations are animated
/// become the joints. The skeleton at rest is the bind pose. Unit and up axis are converted to metres and Z up.
/// Errors: not USD text (binary USD is refused), syntax, neither a skeleton nor an animated prim, arrays of wrong lengths.
/// @param text the whole file @param file_name for the locations of problems @param notes receives unit, axis and remarks; may be null
[[nodiscard]] Result<MeasuredMotion> read_usd(std::string_view text, std::string_view file_name, const SceneOptions& options = {},
                                              formats::ReadNotes* notes = nullptr);

/// True if the bytes are binary USD: a crate (*.usdc) or a package (*.usdz).
[[nodiscard]] bool is_binary_usd(std::string_view bytes);

}  // namespace ugoki::scene_formats
