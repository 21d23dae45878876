#pragma once
// Numbers in text files. Internal to publish.

#include <charconv>
#include <string>

namespace ugoki::publish {

/// Appends `x` with 9 significant digits, more than a float has. The result does not depend on the locale.
inline void add_number(std::string& out, double x) {
  char text[40];
  const auto end = std::to_chars(text, text + sizeof text, x == 0 ? 0.0 : x, std::chars_format::general, 9).ptr;
  out.append(text, end);
}

}  // namespace ugoki::publish
