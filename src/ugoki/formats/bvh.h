#pragma once
// Biovision Hierarchy (BVH) motion files. The dialect is described in docs/formats.md.

#include <string>
#include <string_view>

#include "ugoki/base/result.h"
#include "ugoki/formats/read_notes.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::formats {

struct BvhOptions {
  double metres_per_unit = 0;  ///< m per unit of length of the file; 0: guessed from the size of the skeleton
  bool z_up = false;           ///< the file's Z points up and X forward (usual: Y up, Z forward)
};

/// Reads a whole BVH file from memory. Position channels replace the components of OFFSET that they measure; rotation
/// channels are applied in their order, the first one outermost: R = R_first ... R_last; position comes before rotation
/// whatever the order of the channels.
/// @param file_name names the motion and stands in the place of every problem
/// @param notes     if given, gets the exact frame time, the unit and what else was decided
/// Errors: at most twenty problems, each with file:line and a remedy. O(text) time and memory.
[[nodiscard]] Result<MeasuredMotion> read_bvh(std::string_view text, std::string_view file_name, const BvhOptions& options = {},
                                              ReadNotes* notes = nullptr);

struct BvhWriteOptions {
  double metres_per_unit = 0;  ///< 0: the unit of the file that the motion came from
  bool z_up = false;           ///< write Z up, X forward (usual: Y up, Z forward)
  int decimals = 8;            ///< digits after the point of every length and angle, 1 ... 15
};

/// The motion as a BVH file. Every joint gets three rotation channels in the order of the file that it came from (ZXY
/// where that was no order of three axes), and position channels if it is a root or its translation was measured.
/// Angles are those nearest to the previous frame's, so that they do not jump. Lines end with LF. O(frames * joints).
[[nodiscard]] std::string write_bvh(const MeasuredMotion& motion, const BvhWriteOptions& options = {});

}  // namespace ugoki::formats
