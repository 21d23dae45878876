#pragma once
// Conversion between text and numbers, independent of the locale.

#include <optional>
#include <string>
#include <string_view>

namespace ugoki {

/// Parses the whole of `text` as a double in decimal or exponent form with an optional sign. The result is rounded correctly.
/// Empty optional if `text` contains any other character, also a blank, or if the value is not finite.
/// No allocation for texts of up to 63 characters.
[[nodiscard]] std::optional<double> parse_double(std::string_view text);

/// Parses the whole of `text` as a decimal integer with an optional sign. Empty optional if the text is not an integer or the value
/// does not fit into a long.
[[nodiscard]] std::optional<long> parse_long(std::string_view text);

/// The shortest decimal text from which parse_double() restores the same bits (for finite values).
[[nodiscard]] std::string to_text(double value);

/// `value` with `digits` digits after the decimal point (clamped to 0 ... 340), for display.
[[nodiscard]] std::string to_fixed(double value, int digits);

}  // namespace ugoki
