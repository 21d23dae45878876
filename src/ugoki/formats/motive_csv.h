#pragma once
// CSV files that OptiTrack Motive exports: one table with markers, rigid bodies and bones. Internal to formats; read_csv() calls it.

#include <string_view>

#include "ugoki/formats/c3d.h"

namespace ugoki::formats {

/// True if the text begins like an export of Motive ("Format Version,").
[[nodiscard]] bool is_motive_csv(std::string_view text);

/// Reads the positions of the markers. Labelled markers are read; without any, the markers of rigid bodies and bones, then the unlabelled
/// ones. Rotations and positions of rigid bodies and bones are left out, with a note.
[[nodiscard]] Result<MarkerMotion> read_motive_csv(std::string_view text, std::string_view file_name, const MarkerOptions& options,
                                                   ReadNotes& notes);

}  // namespace ugoki::formats
