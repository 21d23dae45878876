#pragma once
// Comments as the LSI builder reads them. Internal to plugin.

#include <string_view>
#include <utility>
#include <vector>

#include "ugoki/plugin/source.h"

namespace ugoki::plugin {

/// @param text without the sign: "in x [m] = 1, -5..5 How far."
[[nodiscard]] Annotation read_annotation(std::string_view text);
/// @param lines (number, text without the signs of the comment)
[[nodiscard]] Comment read_comment(const std::vector<std::pair<int, std::string>>& lines);

}  // namespace ugoki::plugin
