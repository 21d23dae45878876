#pragma once
// Annotations ("@in x [m] ...") in the comments of a source file. Internal to plugin.

#include <string_view>
#include <utility>
#include <vector>

#include "ugoki/plugin/source.h"

namespace ugoki::plugin {

/// Reads one annotation. Text that cannot be read as another part of the annotation becomes its `doc`.
/// @param text the annotation without the sign '@' or '\': "in x [m] = 1, -5..5 How far."
[[nodiscard]] Annotation read_annotation(std::string_view text);
/// Reads a comment. @param lines pairs of the line number in the file and the line's text without slashes and stars
[[nodiscard]] Comment read_comment(const std::vector<std::pair<int, std::string>>& lines);

}  // namespace ugoki::plugin
