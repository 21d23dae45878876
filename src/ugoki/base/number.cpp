#include "ugoki/base/number.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include <locale.h>

namespace ugoki {

std::optional<double> parse_double(std::string_view text) {
  if (text.empty()) return std::nullopt;
  for (const char c : text) {
    const bool numeric = (c >= '0' && c <= '9') || c == '+' || c == '-' || c == '.' || c == 'e' || c == 'E';
    if (!numeric) return std::nullopt;  // strtod also accepts hexadecimal, inf, nan and leading blanks
  }
#ifdef __cpp_lib_to_chars  // faster than strtod; a leading plus sign and underflow are errors here and are parsed by strtod below
  double fast = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), fast);
  if (error == std::errc{} && stop == text.data() + text.size()) return fast;
#endif
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
#ifdef __GLIBC__
  static const locale_t c_locale = newlocale(LC_ALL_MASK, "C", nullptr);
  const double value = strtod_l(begin, &end, c_locale);
#else
  const double value = std::strtod(begin, &end);  // musl (WebAssembly) always uses a decimal point here
#endif
  if (end != begin + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<long> parse_long(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
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
  char buffer[700];  // sign, at most 309 digits before the point, the point, at most 340 digits after it
  const auto [end, error] = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, std::clamp(digits, 0, 340));
  return error == std::errc{} ? std::string(buffer, end) : std::string();
}

}  // namespace ugoki
