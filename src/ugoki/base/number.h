#pragma once
// Text <-> numbers, independent of the locale and exact in both directions.

#include <optional>
#include <string>
#include <string_view>

namespace ugoki {

/// The double that the whole of `text` denotes (decimal or exponent form, optional sign); nothing if there is anything
/// else in it, or if it is not finite. No allocation for texts of up to 63 characters.
[[nodiscard]] std::optional<double> parse_double(std::string_view text);

/// The integer that the whole of `text` denotes; nothing if it is not one or does not fit.
[[nodiscard]] std::optional<long> parse_long(std::string_view text);

/// The shortest decimal text that parse_double turns back into the same bits.
[[nodiscard]] std::string to_text(double value);

/// `value` with `digits` digits after the point, for people.
[[nodiscard]] std::string to_fixed(double value, int digits);

}  // namespace ugoki
