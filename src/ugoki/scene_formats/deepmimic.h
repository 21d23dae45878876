#pragma once
// Reads motions in the text format of DeepMimic (JSON with a list of frames). docs/formats.md lists what is read.

#include <string_view>

#include "ugoki/base/result.h"
#include "ugoki/formats/read_notes.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::scene_formats {

/// Reads `Frames`: each has its duration, the root's position and rotation (w first), then a quaternion for each spherical and an angle
/// about z for each revolute joint. Frames of other than equal durations are interpolated.
/// @param character text of the character file that defines the joints; empty: the humanoid of DeepMimic, whose frames have 44 numbers
/// Errors: not JSON, no frames, a frame of another length. Each problem has its location.
[[nodiscard]] Result<MeasuredMotion> read_deepmimic(std::string_view text, std::string_view file_name, std::string_view character = {},
                                                    std::string_view character_name = {}, formats::ReadNotes* notes = nullptr);

}  // namespace ugoki::scene_formats
