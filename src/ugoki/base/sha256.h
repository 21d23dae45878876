#pragma once
// SHA-256 (FIPS 180-4). The library uses the hash as the key of stored data.

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace ugoki {

/// The hash of `bytes` as 64 lower-case hexadecimal digits.
[[nodiscard]] std::string sha256(std::span<const std::byte> bytes);
[[nodiscard]] inline std::string sha256(std::string_view text) { return sha256(std::as_bytes(std::span(text.data(), text.size()))); }

}  // namespace ugoki
