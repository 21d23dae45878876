#pragma once
// Escapes in text from files and other programs, so that a terminal shows control characters instead of executing them.

#include <string>
#include <string_view>

namespace ugoki {

/// Returns the text for one line on a terminal, with escapes. Bytes that are not valid UTF-8, and the control characters U+0000 to U+001F
/// (including tab and newline) and U+007F to U+009F, become \xNN. Line separators (U+2028, U+2029) and characters that change the direction
/// of text (U+061C, U+200E, U+200F, U+202A to U+202E, U+2066 to U+2069) become \uNNNN.
[[nodiscard]] std::string printable(std::string_view text);

/// Returns the JSON text with the JSON escape \uNNNN for each character above U+007E that printable() escapes. The value of the document
/// does not change. @param json valid JSON, which contains such characters only in strings
[[nodiscard]] std::string printable_json(std::string_view json);

}  // namespace ugoki
