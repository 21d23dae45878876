#pragma once
// Base64 encoding of bytes (RFC 4648, section 4: alphabet with + and /, with padding).

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ugoki {

/// Base64 text of `bytes`; its length is a multiple of 4.
[[nodiscard]] std::string to_base64(std::span<const std::uint8_t> bytes);
/// The bytes that `text` encodes. Empty optional if `text` is not canonical base64: a character outside the alphabet, a length that is
/// not a multiple of 4, or unused bits that are not zero.
[[nodiscard]] std::optional<std::vector<std::uint8_t>> from_base64(std::string_view text);

}  // namespace ugoki
