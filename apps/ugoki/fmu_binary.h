#pragma once
// The shared objects that run circuits as FMUs (apps/fmu), embedded in this program. Exporting an FMU thus needs no compiler and no other
// file.

#include <string_view>

namespace ugoki::cli {

[[nodiscard]] std::string_view fmu_binary(bool with_content);

}  // namespace ugoki::cli
