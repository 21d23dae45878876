#pragma once
// C3D files: markers, analog channels, force platforms and events of a motion-capture recording.
// docs/formats.md describes the supported variants.

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/formats/read_notes.h"
#include "ugoki/motion/markers.h"

namespace ugoki::formats {

/// Which axis of a marker file points up.
enum class UpAxis {
  automatic,  ///< as the file specifies; else Y or Z: the one along which the lowest marker stays closest to a constant height
  y,          ///< Y up, Z forward
  z,          ///< Z up, X forward
};

struct MarkerOptions {
  UpAxis up = UpAxis::automatic;
  double metres_per_unit = 0;  ///< m per file unit; 0: the unit in the file, or a guess if that unit is missing or implausible
};

/// Reads a whole C3D file from memory: Intel, DEC and SGI/MIPS number formats, integer and floating-point data.
/// A marker whose position is not finite counts as not seen in that frame; the notes report the number of such positions.
/// @param notes if given, receives the unit, the up axis and other decisions of the reader
/// Errors: a damaged header or parameter section, or missing data; location "file: section". O(bytes).
[[nodiscard]] Result<MarkerMotion> read_c3d(std::span<const std::byte> bytes, std::string_view file_name, const MarkerOptions& options = {},
                                            ReadNotes* notes = nullptr);

struct C3dWriteOptions {
  bool z_up = true;            ///< write Z up, X forward; otherwise Y up, Z forward
  double metres_per_unit = 0;  ///< m per file unit; 0: unit of the file that was read, or millimetres if that unit has no name
};

/// Returns the recording as a C3D file: Intel byte order, single-precision floating point. Events after the first 255 and force platforms
/// after the first 64 are left out. Errors: more than 65535 markers, more than 65535 analog samples in a frame, or labels too long for the
/// parameter section.
[[nodiscard]] Result<std::vector<std::byte>> write_c3d(const MarkerMotion& motion, const C3dWriteOptions& options = {});

}  // namespace ugoki::formats
