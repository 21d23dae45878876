#pragma once
// Output of the verbs: results on stdout, errors and progress on stderr.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/json/json.h"

namespace ugoki::cli {

using json::Json;

/// Prints each problem on a line of stderr, escaped by printable(); with `as_json` also an object {"error": {"problems": [...]}} on stdout.
/// @return 1, the exit status
int print_error(const Error& error, bool as_json);

/// Prints a JSON value, indented by 2, and a newline.
void print_json(const Json& value);
/// Prints JSON text, escaped by printable_json(), and a newline.
void print_json_text(std::string_view text);
/// Prints the line, escaped by printable(), and a newline. All text for users is printed by this function or by print_message(), because
/// names in files may contain control sequences of the terminal.
void print_line(std::string_view line);
/// Prints "ugoki: ", the message, escaped by printable(), and a newline on stderr.
void print_message(std::string_view message);
/// Prints a warning like print_message(), if there is one.
void print_warning(const std::optional<Problem>& warning);
/// Prints a table with columns padded to their widest cell; the first row is the heading. Columns with only numbers are right-aligned.
void print_table(const std::vector<std::vector<std::string>>& rows);

/// A progress bar on stderr. It is drawn only on a terminal and only after half a second.
class Progress {
 public:
  explicit Progress(std::string label);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  /// @param done completed fraction, 0 ... 1
  void show(double done);
  void clear();

 private:
  std::string label_;
  bool terminal_, drawn_ = false;
  double began_, last_ = 0;
};

/// From this call on the first Ctrl+C (or SIGTERM, or SIGHUP when the terminal is closed) only sets a flag, which interrupted() returns, so
/// that the verb can finish cleanly. The second signal ends the process at once.
void catch_interrupt();
[[nodiscard]] bool interrupted();
[[nodiscard]] Error interrupted_error();

}  // namespace ugoki::cli
