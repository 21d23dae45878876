#pragma once
// Track Row Column (TRC) files: marker positions as text. docs/formats.md describes the supported variants.

#include <string>
#include <string_view>

#include "ugoki/formats/c3d.h"

namespace ugoki::formats {

/// Reads a whole TRC file from memory; columns are separated by tabs or commas. A marker with an empty or "NaN" component counts as
/// not seen in that frame.
/// @param notes if given, receives the unit, the up axis and other decisions of the reader
/// Errors: at most twenty problems, each with file:line and a remedy. O(text).
[[nodiscard]] Result<MarkerMotion> read_trc(std::string_view text, std::string_view file_name, const MarkerOptions& options = {},
                                            ReadNotes* notes = nullptr);

struct TrcWriteOptions {
  bool z_up = false;           ///< true: write Z up, X forward; false (usual): Y up, Z forward
  double metres_per_unit = 0;  ///< m per file unit; 0: unit of the file that was read, or millimetres if that unit has no name
  int decimals = 6;            ///< digits after the decimal point, 1 ... 15
};

/// Returns the markers of the recording as a TRC file. Analog channels, force platforms and events are not written.
[[nodiscard]] std::string write_trc(const MarkerMotion& motion, const TrcWriteOptions& options = {});

}  // namespace ugoki::formats
