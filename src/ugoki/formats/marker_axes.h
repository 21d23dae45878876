#pragma once
// Units and axes of marker files (C3D, TRC, CSV). Internal to formats.

#include <optional>
#include <string>
#include <string_view>

#include "ugoki/formats/c3d.h"

namespace ugoki::formats {

/// Returns the length [m] of the unit that a marker file calls `unit` ("mm", "M", "inches"); std::nullopt for an unknown name.
[[nodiscard]] std::optional<double> metres_of(std::string_view unit);
/// Returns the name of the unit of length `metres` [m], "mm" for 0.001; empty if this unit has no name.
[[nodiscard]] std::string_view name_of_unit(double metres);

/// Converts marker positions, residuals and force platforms of `motion` from file axes and file units to metres, Z up, in place.
/// @param file_up the up axis that the file specifies; automatic if it specifies none
/// @param metres  m per file unit, from the file; 0 if the file specifies none
/// @param notes   receives the unit, the up axis, and a remark for each guess
/// Returns false if a converted position has a norm above max_magnitude (m) or is not finite.
[[nodiscard]] bool to_our_axes(MarkerMotion& motion, const MarkerOptions& options, UpAxis file_up, double metres, ReadNotes& notes);

}  // namespace ugoki::formats
