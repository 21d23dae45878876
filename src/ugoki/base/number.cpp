#include "ugoki/base/number.h"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace ugoki {

std::optional<double> parse_double(std::string_view text) {
  if (text.empty()) return std::nullopt;
  for (const char c : text) {
    const bool numeric = (c >= '0' && c <= '9') || c == '+' || c == '-' || c == '.' || c == 'e' || c == 'E';
    if (!numeric) return std::nullopt;  // strtod would also take hexadecimal, inf, nan and leading blanks
  }
  char buffer[64];
  std::string longer;
  const char* begin = buffer;
  if (text.size() < sizeof buffer) {
    std::memcpy(buffer, text.data(), text.size());
    buffer[text.size()] = '\0';
  } else {
    longer = std::string(text);
    begin = longer.c_str();
  }
  char* end = nullptr;
  const double value = std::strtod(begin, &end);
  if (end != begin + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<long> parse_long(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  long value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || text.empty()) return std::nullopt;
  return value;
}

std::string to_text(double value) {
  char buffer[64];
  const auto [end, error] = std::to_chars(buffer, buffer + sizeof buffer, value);
  return error == std::errc{} ? std::string(buffer, end) : std::string("nan");
}

std::string to_fixed(double value, int digits) {
  char buffer[400];
  const int n = std::snprintf(buffer, sizeof buffer, "%.*f", digits, value);
  return n > 0 ? std::string(buffer, static_cast<std::size_t>(n) < sizeof buffer ? static_cast<std::size_t>(n) : sizeof buffer - 1) : std::string();
}

}  // namespace ugoki
