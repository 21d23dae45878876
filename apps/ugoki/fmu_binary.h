#pragma once
// The shared object that runs circuits as FMUs (apps/fmu), inside of this program: so exporting needs no compiler and no other file.

#include <string_view>

namespace ugoki::cli {

[[nodiscard]] std::string_view fmu_binary(bool with_content);

}  // namespace ugoki::cli
