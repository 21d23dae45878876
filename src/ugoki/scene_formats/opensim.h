#pragma once
// Reads motions of OpenSim: tables of coordinates (.mot, .sto) with the model (.osim) to which they belong. docs/formats.md lists what is
// read.

#include <string_view>

#include "ugoki/base/result.h"
#include "ugoki/formats/read_notes.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::scene_formats {

/// The joints are the joints of the model, with their exact rotations; the translation of a joint that moves along a curve is replaced by
/// its mean. Columns are found by the names of coordinates ("knee_angle_r", "/jointset/knee_r/knee_angle_r/value"). Coordinates without a
/// column keep their default. Rows with other than steady times are interpolated. The skeleton's mass is that of the model. Errors: not a
/// table with `endheader`; no column names a coordinate; numbers are missing; the errors of the model. Each has file:line.
[[nodiscard]] Result<MeasuredMotion> read_opensim(std::string_view table, std::string_view table_name, std::string_view model,
                                                  std::string_view model_name, formats::ReadNotes* notes = nullptr);

}  // namespace ugoki::scene_formats
