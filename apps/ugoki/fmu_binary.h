#pragma once
// The shared objects that run circuits as FMUs (apps/fmu), embedded in this program. Exporting an FMU thus needs no compiler and no other
// file.

#include <string_view>

namespace ugoki::cli {

/// @param all_lsis  with all built-in LSIs; false: the smaller one, with the signal LSIs only
[[nodiscard]] std::string_view fmu_binary(bool all_lsis);

}  // namespace ugoki::cli
