#include "ugoki/base/printable.h"

#include <cstddef>
#include <cstdint>

namespace ugoki {
namespace {

/// One character of UTF-8 text: code point and number of bytes. If the bytes are not valid UTF-8, `code` is -1 and `size` is 1.
struct Character {
  std::int32_t code = -1;
  std::size_t size = 1;
};

Character character_at(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
  const std::uint8_t first = byte(at);
  if (first < 0x80) return {first, 1};
  const std::size_t size = first >= 0xC2 && first <= 0xDF ? 2 : (first & 0xF0) == 0xE0 ? 3 : first >= 0xF0 && first <= 0xF4 ? 4 : 0;
  if (size == 0 || size > text.size() - at) return {};
  std::int32_t code = first & (0x7F >> size);
  for (std::size_t i = 1; i < size; ++i) {
    if ((byte(at + i) & 0xC0) != 0x80) return {};
    code = code << 6 | (byte(at + i) & 0x3F);
  }
  const bool too_long = (size == 3 && code < 0x800) || (size == 4 && code < 0x10000), surrogate = code >= 0xD800 && code <= 0xDFFF;
  if (too_long || surrogate || code > 0x10FFFF) return {};
  return {code, size};
}

bool is_control(std::int32_t c) { return (c >= 0 && c < 0x20) || (c >= 0x7F && c <= 0x9F); }
bool changes_lines_or_direction(std::int32_t c) {
  return c == 0x61C || c == 0x200E || c == 0x200F || (c >= 0x2028 && c <= 0x202E) || (c >= 0x2066 && c <= 0x2069);
}

std::string escape(const char* prefix, std::uint32_t code, int digits) {
  std::string out = prefix;
  for (int shift = 4 * (digits - 1); shift >= 0; shift -= 4) out += "0123456789abcdef"[code >> shift & 15];
  return out;
}

}  // namespace

std::string printable(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t at = 0; at < text.size();) {
    const Character c = character_at(text, at);
    if (c.code < 0)
      out += escape("\\x", static_cast<std::uint8_t>(text[at]), 2);
    else if (is_control(c.code))
      out += escape("\\x", static_cast<std::uint32_t>(c.code), 2);
    else if (changes_lines_or_direction(c.code))
      out += escape("\\u", static_cast<std::uint32_t>(c.code), 4);
    else
      out += text.substr(at, c.size);
    at += c.size;
  }
  return out;
}

std::string printable_json(std::string_view json) {
  std::string out;
  out.reserve(json.size());
  for (std::size_t at = 0; at < json.size();) {
    const Character c = character_at(json, at);
    if (c.code >= 0x7F && (is_control(c.code) || changes_lines_or_direction(c.code)))
      out += escape("\\u", static_cast<std::uint32_t>(c.code), 4);
    else
      out += json.substr(at, c.size);
    at += c.size;
  }
  return out;
}

}  // namespace ugoki
