#pragma once
// Comma-separated values: markers, positions of joints, coordinates of mechanisms. The dialect is described in docs/formats.md.

#include <string>
#include <string_view>

#include "ugoki/base/result.h"
#include "ugoki/formats/c3d.h"
#include "ugoki/formats/read_notes.h"
#include "ugoki/motion/motion.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::formats {

struct CsvWriteOptions {
  int decimals = 0;     ///< digits after the point, 1 ... 15; 0: the shortest text that gives back the same bits
  bool degrees = true;  ///< angles of coordinates; otherwise rad
};

/// One row a frame: time, then x, y, z of every marker in m, Z up; empty where a marker was not seen. Residuals, analog channels, platforms
/// and events have no place in it.
[[nodiscard]] std::string write_csv(const MarkerMotion& motion, const CsvWriteOptions& options = {});
/// World positions of every joint.
[[nodiscard]] std::string write_csv_positions(const MeasuredMotion& motion, const CsvWriteOptions& options = {});
/// Coordinates of the mechanism: angles [deg or rad], displacements [m], unit quaternions, named "link" or "link.x" ...; contact labels as
/// 0 and 1.
/// @param motion of this mechanism (check_motion)
[[nodiscard]] std::string write_csv(const Motion& motion, const Mechanism& mechanism, const CsvWriteOptions& options = {});

/// What a file's columns are. Nothing is read but the head.
enum class CsvKind { points, coordinates };
[[nodiscard]] CsvKind csv_kind(std::string_view text);

/// Three columns for each point: NAME.x, NAME.y, NAME.z (also with _, :, - or a blank before the letter, which may be a capital), each
/// perhaps with a unit in brackets; a column "time" (s) or "frame". Separated by commas, semicolons or tabs. Other columns are noted and
/// passed over. Errors: at most twenty problems, each with file:line and a remedy. O(text).
[[nodiscard]] Result<MarkerMotion> read_csv(std::string_view text, std::string_view file_name, const MarkerOptions& options = {},
                                            ReadNotes* notes = nullptr);

/// Coordinates of this mechanism, as write_csv names them; columns in any order. Those that are missing keep the neutral position, and this
/// is told. Quaternions are made unit. Errors as above, and a column that the mechanism does not have.
[[nodiscard]] Result<Motion> read_csv(std::string_view text, std::string_view file_name, const Mechanism& mechanism,
                                      ReadNotes* notes = nullptr);

}  // namespace ugoki::formats
