#pragma once
// Biovision Hierarchy (BVH) motion files. docs/formats.md describes the supported variants.

#include <string>
#include <string_view>

#include "ugoki/base/result.h"
#include "ugoki/formats/read_notes.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::formats {

struct BvhOptions {
  double metres_per_unit = 0;  ///< m per file unit of length; 0: guessed from the size of the skeleton
  bool z_up = false;           ///< true: the file's Z points up and X forward; false (usual): Y up, Z forward
};

/// Reads a whole BVH file from memory. A position channel replaces the component of OFFSET along its axis. The rotation channels are
/// multiplied in file order, the first one outermost: R = R_first ... R_last. A joint's rotation does not rotate its own translation,
/// whatever the order of the channels.
/// @param file_name names the motion and appears in the location of every problem
/// @param notes     if given, receives the exact frame time, the unit and other decisions of the reader
/// Errors: at most twenty problems, each with file:line and a remedy. O(text) time and memory.
[[nodiscard]] Result<MeasuredMotion> read_bvh(std::string_view text, std::string_view file_name, const BvhOptions& options = {},
                                              ReadNotes* notes = nullptr);

struct BvhWriteOptions {
  double metres_per_unit = 0;  ///< m per file unit; 0: unit of the file that was read
  bool z_up = false;           ///< true: write Z up, X forward; false (usual): Y up, Z forward
  int decimals = 8;            ///< digits after the decimal point of every length and angle, 1 ... 15
};

/// Returns the motion as a BVH file. Every joint has three rotation channels in its rotation_order. An order of fewer than three axes is
/// completed; an order with a repeated axis is replaced by ZXY. Roots and joints whose translation was measured also have position
/// channels. Among equivalent angles [deg], the writer chooses those closest to the previous frame. Lines end with LF. O(frames * joints).
[[nodiscard]] std::string write_bvh(const MeasuredMotion& motion, const BvhWriteOptions& options = {});

}  // namespace ugoki::formats
