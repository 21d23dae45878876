#pragma once
// Bytes as text of letters, digits, + and / (RFC 4648, with padding).

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ugoki {

[[nodiscard]] std::string to_base64(std::span<const std::uint8_t> bytes);
/// Nothing where the text is not what to_base64 gives: another character, a wrong length, bits left over.
[[nodiscard]] std::optional<std::vector<std::uint8_t>> from_base64(std::string_view text);

}  // namespace ugoki
