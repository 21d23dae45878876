#pragma once
// C3D files: markers, analog channels, force platforms and events of a motion-capture recording. The dialect is described
// in docs/formats.md.

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
  automatic,  ///< what the file says, otherwise the axis along which the lowest marker keeps its height best
  y,          ///< Y up, Z forward
  z,          ///< Z up, X forward
};

struct MarkerOptions {
  UpAxis up = UpAxis::automatic;
  double metres_per_unit = 0;  ///< m per unit of length of the file; 0: as the file says
};

/// Reads a whole C3D file from memory: Intel, DEC and SGI/MIPS byte orders, whole numbers and floating point.
/// Numbers that are not finite make the marker unseen in that frame (told in the notes).
/// Errors: a damaged header, parameter section or missing data, each with its place and a remedy. O(bytes).
[[nodiscard]] Result<MarkerMotion> read_c3d(std::span<const std::byte> bytes, std::string_view file_name, const MarkerOptions& options = {},
                                            ReadNotes* notes = nullptr);

struct C3dWriteOptions {
  bool z_up = true;  ///< write Z up, X forward; otherwise Y up, Z forward
  double metres_per_unit =
      0;  ///< of the file: 0: the unit of the file that the recording came from; only 1, 0.1, 0.01 and 0.001 have names
};

/// The recording as a C3D file: Intel byte order, floating point, so that positions keep 24 bits.
/// Errors: more than 65535 markers, or more analog samples in a frame than the format can tell (65535).
[[nodiscard]] Result<std::vector<std::byte>> write_c3d(const MarkerMotion& motion, const C3dWriteOptions& options = {});

}  // namespace ugoki::formats
