#pragma once
// Content as a JSON text whose mechanisms and motions may be given by recipes: samples, persons of a height, measured files, and operations
// on other motions. docs/export.md, "Content as text", describes the form.

#include <functional>
#include <string_view>

#include "ugoki/content/content_file.h"

namespace ugoki::studio {

/// Reads {"scenario", "mechanisms", "circuit", "motions", "measured"} as content::read_content(), and makes what the recipes describe. Ids
/// that the text uses but does not define are those of the sample content. Equal text gives equal content.
/// @param name name of the text in errors, for example its file
/// @param cancelled called between the recipes; true ends the work with ErrorCode::cancelled; may be empty
[[nodiscard]] Result<content::ContentText> make_content(std::string_view text, std::string_view name,
                                                        const std::function<bool()>& cancelled = {});

}  // namespace ugoki::studio
