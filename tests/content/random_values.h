#pragma once
// Random numbers and choices for random commands, as pieces of JSON.

#include <initializer_list>
#include <random>
#include <string>
#include <string_view>

namespace ugoki::content::testing {

class RandomValues {
 public:
  explicit RandomValues(unsigned seed) : random_(seed) {}

  /// Random index from 0 to `n` - 1.
  std::size_t pick(std::size_t n) { return random_() % n; }

 protected:
  std::string number(double low, double high) { return std::to_string(low + (high - low) * static_cast<double>(pick(10'000)) / 9'999); }
  std::string vector(double low, double high) {
    return "[" + number(low, high) + ", " + number(low, high) + ", " + number(low, high) + "]";
  }
  std::string boolean() { return pick(2) ? "true" : "false"; }
  /// One of the words, in quotation marks.
  std::string word(std::initializer_list<std::string_view> words) { return quoted(std::string(words.begin()[pick(words.size())])); }
  std::string color() { return pick(2) ? R"("#204080")" : R"("#c0d0e0")"; }
  static std::string quoted(const std::string& text) { return "\"" + text + "\""; }
  template <class List>
  const auto& any(const List& list) {
    return list[pick(list.size())];
  }

 private:
  std::mt19937 random_;
};

}  // namespace ugoki::content::testing
