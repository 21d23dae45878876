#pragma once
// Reads recordings of Xsens suits (MVNX, the XML format of MVN). docs/formats.md lists what is read.

#include <string_view>

#include "ugoki/base/result.h"
#include "ugoki/formats/read_notes.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::scene_formats {

/// Reads the first subject of an MVNX file. Each segment becomes a joint at the segment's origin. In MVN's axes (X forward, Z up) the
/// frames of all segments are parallel to the world at rest. The tree follows the file's <joints>; a file without them has the tree of the
/// 23 usual segments. Frames of calibration poses (identity, tpose, npose) are left out. Errors: not MVNX; segments, numbers or frames are
/// missing; the joints form a loop. Each problem has file:line and a remedy.
[[nodiscard]] Result<MeasuredMotion> read_mvnx(std::string_view text, std::string_view file_name, formats::ReadNotes* notes = nullptr);

}  // namespace ugoki::scene_formats
