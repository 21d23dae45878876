#pragma once
// Units and axes of marker files. Internal to formats.

#include <optional>
#include <string>
#include <string_view>

#include "ugoki/formats/c3d.h"

namespace ugoki::formats {

/// m of a unit of length as marker files name it ("mm", "M", "inches"); nothing if it is no known name.
[[nodiscard]] std::optional<double> metres_of(std::string_view unit);
/// "mm" of 0.001; empty if the unit has no name of its own.
[[nodiscard]] std::string_view name_of_unit(double metres);

/// Turns the positions (in file axes and file units, with residuals set) into metres, Z up; plates likewise.
/// @param told the axis that the file tells, or automatic
/// @param metres m per file unit by what the file says; 0: it says nothing
/// What is decided is put into the notes. Returns false if lengths come out beyond max_magnitude.
[[nodiscard]] bool to_our_axes(MarkerMotion& motion, const MarkerOptions& options, UpAxis told, double metres, ReadNotes& notes);

}  // namespace ugoki::formats
