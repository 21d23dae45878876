#pragma once
// Scanner for text formats: words with their line numbers, number parsing, and a bounded list of problems. Internal to formats.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "ugoki/base/result.h"

namespace ugoki::formats {

/// Limits for the content of a file. A reader rejects a file that exceeds one of them.
inline constexpr std::size_t max_joints = 10'000;        ///< joints, bones or glTF nodes
inline constexpr std::size_t max_depth = 1'000;          ///< nesting of joints or glTF nodes
inline constexpr std::size_t max_numbers = 400'000'000;  ///< values of all frames together; 3.2 GB as doubles
/// Maximum magnitude of a number in a file, in the file's units. Larger lengths or angles cannot be measurements. The limit also keeps all
/// products of such numbers finite.
inline constexpr double max_magnitude = 1e9;

/// Problems found in one file. Keeps the first twenty and ignores the others.
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

/// Returns `text` without a UTF-8 byte order mark and without trailing padding. Empty, UTF-16 or binary text adds a problem and returns
/// std::nullopt. @param format name of the format for messages, for example "BVH"
[[nodiscard]] std::optional<std::string_view> plain_text(std::string_view text, std::string_view format, Problems& problems);

/// Returns `token` in single quotes for messages: at most 40 bytes, '?' for every byte that is not printable ASCII.
[[nodiscard]] std::string in_quotes(std::string_view token);

/// Returns `path` in single quotes for messages, with '?' for control characters. A path of more than 400 bytes is shortened to its end,
/// because the end identifies the file.
[[nodiscard]] std::string path_in_quotes(std::string_view path);

/// Returns the file name without folders and extension: "02_01" for "subjects/02_01.amc".
[[nodiscard]] std::string stem_of(std::string_view file_name);

/// Returns `name` as valid UTF-8. A valid name is unchanged; otherwise its bytes are interpreted as Latin-1.
[[nodiscard]] std::string utf8(std::string_view name);

/// True if `a` and `b` are equal when the case of ASCII letters is ignored.
[[nodiscard]] bool equal_ignoring_case(std::string_view a, std::string_view b);

/// Parses `token`; std::nullopt unless the whole token is one finite number of magnitude at most max_magnitude. Returns the same double as
/// parse_double, bit for bit, but is faster.
[[nodiscard]] std::optional<double> measured_number(std::string_view token);

/// Reason why measured_number rejects a token.
struct NumberFault {
  ErrorCode code;
  std::string message, remedy;  ///< one sentence each
};
/// Returns the reason why measured_number has rejected `token`.
[[nodiscard]] NumberFault number_fault(std::string_view token);

/// Reads a text from beginning to end. Lines end with LF, CR LF or CR and are counted from 1.
class Scanner {
 public:
  explicit Scanner(std::string_view text) : text_(text) {}

  [[nodiscard]] int line() const { return line_; }
  /// Number of bytes not read yet.
  [[nodiscard]] std::size_t remaining() const { return text_.size() - at_; }

  /// Skips blanks and line ends. Returns false at the end of the text.
  bool skip_space();
  /// Consumes and returns the next word, up to a blank or line end; empty at the end of the text. line() is then the word's line.
  std::string_view word();
  /// Returns the next word without consuming it.
  [[nodiscard]] std::string_view peek();
  /// Consumes and returns the next word on this line; empty if there is none.
  std::string_view word_on_line();
  /// Consumes and returns the rest of the line without blanks at either end. If `stop` is given and present, ends before this character.
  /// Does not consume the line end.
  std::string_view rest_of_line(char stop = '\0');
  /// Skips blanks and line ends, then consumes `keyword` if the text continues with it, ignoring case. The keyword may end within a word.
  bool accept(std::string_view keyword);
  /// Skips blanks on this line, then consumes the character `c`. Returns false if another character or the line end follows.
  bool accept_on_line(char c);

 private:
  void skip_blanks();

  std::string_view text_;
  std::size_t at_ = 0;
  int line_ = 1;
};

}  // namespace ugoki::formats
