#pragma once
// Scanning of text formats: words with their line numbers, numbers, and a bounded list of problems. Internal to formats.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "ugoki/base/result.h"

namespace ugoki::formats {

/// No file gives more joints than this, nor deeper trees, nor more numbers.
inline constexpr std::size_t max_joints = 10'000;
inline constexpr std::size_t max_depth = 1'000;
inline constexpr std::size_t max_numbers = 400'000'000;
/// Lengths and angles beyond this are no measurements; the bound keeps every later product finite.
inline constexpr double max_magnitude = 1e9;

/// Problems found in one file. Keeps the first twenty; the readers go on only where more of them help.
class Problems {
 public:
  explicit Problems(std::string_view file) : file_(file) {}
  void add(ErrorCode code, int line, std::string message, std::string remedy);
  [[nodiscard]] bool empty() const { return error_.empty(); }
  [[nodiscard]] bool full() const { return error_.problems.size() >= 20; }
  [[nodiscard]] Error take() { return std::move(error_); }

 private:
  std::string file_;
  Error error_;
};

/// The text that may be read: without byte order mark. Refuses what is empty, UTF-16, or not text; the problem is added.
[[nodiscard]] std::optional<std::string_view> plain_text(std::string_view text, std::string_view format, Problems& problems);

/// `token` in quotes, shortened and without unprintable bytes, for messages.
[[nodiscard]] std::string in_quotes(std::string_view token);

/// A path in quotes, likewise without unprintable ASCII; a very long one loses its beginning, for its end is what tells.
[[nodiscard]] std::string path_in_quotes(std::string_view path);

/// "02_01" of "subjects/02_01.amc".
[[nodiscard]] std::string stem_of(std::string_view file_name);

/// `name` as valid UTF-8: unchanged if it is, otherwise its bytes taken as Latin-1.
[[nodiscard]] std::string utf8(std::string_view name);

[[nodiscard]] bool equal_ignoring_case(std::string_view a, std::string_view b);

/// The finite number that the whole of `token` denotes, at most max_magnitude. Same value as parse_double, faster.
[[nodiscard]] std::optional<double> measured_number(std::string_view token);

/// A sentence on why `token` is no measured_number, and what to do about it.
struct NumberFault {
  ErrorCode code;
  std::string message, remedy;
};
[[nodiscard]] NumberFault number_fault(std::string_view token);

/// Walks through a text. Lines end with LF, CR LF or CR and are counted from 1.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text) {}

  [[nodiscard]] int line() const { return line_; }
  [[nodiscard]] std::size_t remaining() const { return text_.size() - at_; }

  /// Skips blanks and line ends; true if something follows.
  bool skip_space();
  /// The next word, up to a blank or line end; empty at the end of the text. line() is then the word's line.
  std::string_view word();
  /// The next word without consuming it.
  [[nodiscard]] std::string_view peek();
  /// The next word on this line; empty if there is none.
  std::string_view word_on_line();
  /// What is left of the line, without blanks at its ends, stopping before `stop`. Does not consume the line end.
  std::string_view rest_of_line(char stop = '\0');
  /// Consumes `keyword` (letters in any case) if it comes next on any line, even if not followed by a blank.
  bool accept(std::string_view keyword);
  /// Consumes one character after blanks on this line.
  bool accept_on_line(char c);

 private:
  void skip_blanks();

  std::string_view text_;
  std::size_t at_ = 0;
  int line_ = 1;
};

}  // namespace ugoki::formats
