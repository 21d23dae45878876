#pragma once
// Comma-separated values: markers, joint positions, coordinates of mechanisms. docs/formats.md describes the supported variants.

#include <string>
#include <string_view>

#include "ugoki/base/result.h"
#include "ugoki/formats/c3d.h"
#include "ugoki/formats/read_notes.h"
#include "ugoki/motion/motion.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::formats {

struct CsvWriteOptions {
  int decimals = 0;     ///< digits after the decimal point, 1 ... 15; 0: the shortest text that is read back as the same double
  bool degrees = true;  ///< unit of angular coordinates: true deg, false rad
};

/// Writes one row for each frame: time [s], then x, y, z [m, Z up] of every marker; empty fields for a marker that was not seen. Residuals,
/// analog channels, force platforms and events are not written.
[[nodiscard]] std::string write_csv(const MarkerMotion& motion, const CsvWriteOptions& options = {});
/// Writes one row for each frame: time [s], then the world position x, y, z [m] of every joint.
[[nodiscard]] std::string write_csv_positions(const MeasuredMotion& motion, const CsvWriteOptions& options = {});
/// Writes one row for each frame: time [s], then the coordinates q of the mechanism: angles [deg or rad], displacements [m], unit
/// quaternions. Columns are named "link" or "link.x" ... (csv_coordinates). Contact labels follow in columns "link.contact", 0 or 1.
/// @param motion must belong to `mechanism` (check_motion)
[[nodiscard]] std::string write_csv(const Motion& motion, const Mechanism& mechanism, const CsvWriteOptions& options = {});

/// Content of a CSV file: points (markers) or coordinates of a mechanism.
enum class CsvKind { points, coordinates };
/// Returns the kind of content that the column names indicate; points if the header line cannot be read.
[[nodiscard]] CsvKind csv_kind(std::string_view text);

/// Reads points. Each point has three columns NAME.x, NAME.y, NAME.z. The separator before the letter may also be _, :, - or a blank; the
/// letter may be a capital; a unit in brackets may follow. A column "time" (s, or "time[ms]") gives the frame rate. Columns are separated
/// by commas, semicolons or tabs. Other columns are skipped; the notes report how many. Errors: at most twenty problems, each with
/// file:line and a remedy. O(text).
[[nodiscard]] Result<MarkerMotion> read_csv(std::string_view text, std::string_view file_name, const MarkerOptions& options = {},
                                            ReadNotes* notes = nullptr);

/// Reads coordinates of `mechanism`. The columns have the names that write_csv gives them, in any order. Coordinates without a column keep
/// their neutral value; the notes report how many. Quaternions are normalised.
/// Errors: the errors of read_csv for points, and columns that name no coordinate of the mechanism.
[[nodiscard]] Result<Motion> read_csv(std::string_view text, std::string_view file_name, const Mechanism& mechanism,
                                      ReadNotes* notes = nullptr);

}  // namespace ugoki::formats
