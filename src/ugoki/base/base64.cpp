#include "ugoki/base/base64.h"

#include <array>

namespace ugoki {
namespace {

constexpr std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

constexpr std::array<std::uint8_t, 256> make_values() {
  std::array<std::uint8_t, 256> out{};
  for (auto& v : out) v = 255;
  for (std::size_t i = 0; i < letters.size(); ++i) out[static_cast<unsigned char>(letters[i])] = static_cast<std::uint8_t>(i);
  return out;
}
constexpr std::array<std::uint8_t, 256> values = make_values();

}  // namespace

std::string to_base64(std::span<const std::uint8_t> bytes) {
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t remaining = bytes.size() - i;
    const std::uint32_t group =
        (std::uint32_t{bytes[i]} << 16) | (remaining > 1 ? std::uint32_t{bytes[i + 1]} << 8 : 0) | (remaining > 2 ? bytes[i + 2] : 0U);
    out += letters[group >> 18];
    out += letters[(group >> 12) & 63];
    out += remaining > 1 ? letters[(group >> 6) & 63] : '=';
    out += remaining > 2 ? letters[group & 63] : '=';
  }
  return out;
}

std::optional<std::vector<std::uint8_t>> from_base64(std::string_view text) {
  if (text.size() % 4 != 0) return std::nullopt;
  std::vector<std::uint8_t> out;
  out.reserve(text.size() / 4 * 3);
  for (std::size_t i = 0; i < text.size(); i += 4) {
    const bool last = i + 4 == text.size();
    const std::size_t padding = last && text[i + 3] == '=' ? (text[i + 2] == '=' ? 2 : 1) : 0;
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::uint8_t value = k < 4 - padding ? values[static_cast<unsigned char>(text[i + k])] : std::uint8_t{0};
      if (value > 63) return std::nullopt;
      group = (group << 6) | value;
    }
    if ((padding == 1 && (group & 0xff) != 0) || (padding == 2 && (group & 0xffff) != 0)) return std::nullopt;
    out.push_back(static_cast<std::uint8_t>(group >> 16));
    if (padding < 2) out.push_back(static_cast<std::uint8_t>((group >> 8) & 255));
    if (padding < 1) out.push_back(static_cast<std::uint8_t>(group & 255));
  }
  return out;
}

}  // namespace ugoki
