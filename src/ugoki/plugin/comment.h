#pragma once
// Annotations ("@in x [m] ...") in the comments of a source file. Internal to plugin.

#include <string_view>
#include <utility>
#include <vector>

#include "ugoki/plugin/source.h"

namespace ugoki::plugin {

/// Reads one annotation. Parts that cannot be read become its `doc`.
/// @param text of the annotation without the sign '@' or '\': "in x [m] = 1, -5..5 How far."
[[nodiscard]] Annotation read_annotation(std::string_view text);
/// Reads a comment. @param lines (line number in the file, text without slashes and stars)
[[nodiscard]] Comment read_comment(const std::vector<std::pair<int, std::string>>& lines);

}  // namespace ugoki::plugin
