#pragma once
// Texts and numbers in the answer of a guarded child process. Internal to scene_formats.

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::scene_formats {

/// Appends a text, preceded by its length.
inline void put(std::string& out, std::string_view text) {
  const std::uint64_t size = text.size();
  out.append(reinterpret_cast<const char*>(&size), sizeof size);
  out += text;
}

/// Removes a text, written by put(), from the front of `in`; false if `in` does not begin with a complete text.
inline bool take(std::string_view& in, std::string_view& text) {
  std::uint64_t size = 0;
  if (in.size() < sizeof size) return false;
  std::memcpy(&size, in.data(), sizeof size);
  in.remove_prefix(sizeof size);
  if (size > in.size()) return false;
  text = in.substr(0, size);
  in.remove_prefix(size);
  return true;
}

template <class T>
void put_number(std::string& out, T x) {
  put(out, {reinterpret_cast<const char*>(&x), sizeof x});
}
template <class T>
bool take_number(std::string_view& in, T& x) {
  std::string_view text;
  if (!take(in, text) || text.size() != sizeof x) return false;
  std::memcpy(&x, text.data(), sizeof x);
  return true;
}

/// Lists of numbers, or of structures of numbers.
template <class T>
void put_list(std::string& out, const std::vector<T>& list) {
  put(out, {reinterpret_cast<const char*>(list.data()), list.size() * sizeof(T)});
}
template <class T>
bool take_list(std::string_view& in, std::vector<T>& list) {
  std::string_view text;
  if (!take(in, text) || text.size() % sizeof(T) != 0) return false;
  list.resize(text.size() / sizeof(T));
  if (!list.empty()) std::memcpy(list.data(), text.data(), text.size());
  return true;
}

/// Appends the problems of an error.
inline void put_error(std::string& out, const Error& error) {
  put_number(out, std::uint64_t{error.problems.size()});
  for (const Problem& p : error.problems) {
    put_number(out, static_cast<std::uint64_t>(p.code));
    for (const std::string* text : {&p.location, &p.message, &p.remedy}) put(out, *text);
  }
}
/// Removes an error, written by put_error(), from the front of `in`; false if it is not complete or has no problem.
inline bool take_error(std::string_view& in, Error& error) {
  std::uint64_t count = 0;
  if (!take_number(in, count)) return false;
  for (std::uint64_t i = 0; i < count; ++i) {
    std::uint64_t code = 0;
    std::string_view parts[3];
    if (!take_number(in, code) || code > static_cast<std::uint64_t>(ErrorCode::cancelled)) return false;
    for (std::string_view& part : parts)
      if (!take(in, part)) return false;
    error.add(static_cast<ErrorCode>(code), std::string(parts[0]), std::string(parts[1]), std::string(parts[2]));
  }
  return !error.empty();
}

}  // namespace ugoki::scene_formats
