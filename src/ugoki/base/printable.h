#pragma once
// Text from outside in a form that a terminal shows and does not execute.

#include <string>
#include <string_view>

namespace ugoki {

/// The text with its control characters as escapes, for one line on a terminal. Bytes of invalid UTF-8, and the control characters U+0000 to
/// U+001F (with tab and newline) and U+007F to U+009F, become \xNN. Line separators (U+2028, U+2029) and characters that change the direction
/// of the text (U+061C, U+200E, U+200F, U+202A to U+202E, U+2066 to U+2069) become \uNNNN.
[[nodiscard]] std::string printable(std::string_view text);

/// JSON text in which the characters above U+007E that printable() escapes are written as \uNNNN, an escape of JSON. The value of the document is
/// the same. @param json valid JSON; it has such characters in strings only
[[nodiscard]] std::string printable_json(std::string_view json);

}  // namespace ugoki
