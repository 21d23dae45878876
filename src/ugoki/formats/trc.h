#pragma once
// Track Row Column (TRC) files: markers as text. The dialect is described in docs/formats.md.

#include <string>
#include <string_view>

#include "ugoki/formats/c3d.h"

namespace ugoki::formats {

/// Reads a whole TRC file from memory; columns are separated by tabs or commas. An empty place or "NaN" is a marker not seen.
/// Errors: at most twenty problems, each with file:line and a remedy. O(text).
[[nodiscard]] Result<MarkerMotion> read_trc(std::string_view text, std::string_view file_name, const MarkerOptions& options = {},
                                            ReadNotes* notes = nullptr);

struct TrcWriteOptions {
  bool z_up = false;           ///< write Z up, X forward (usual: Y up, Z forward)
  double metres_per_unit = 0;  ///< 0: the unit of the file that the recording came from
  int decimals = 6;            ///< digits after the point, 1 ... 15
};

/// The recording's markers as a TRC file. Analog channels, platforms and events have no place in it.
[[nodiscard]] std::string write_trc(const MarkerMotion& motion, const TrcWriteOptions& options = {});

}  // namespace ugoki::formats
