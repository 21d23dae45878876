#pragma once
// What the verbs print: results on stdout, errors and progress on stderr.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/json/json.h"

namespace ugoki::cli {

using json::Json;

/// One line a problem on stderr; with `as_json` also an object {"error": {"problems": [...]}} on stdout.
/// @return 1, the exit status
int print_error(const Error& error, bool as_json);

/// Indented, and a newline.
void print_json(const Json& value);
void print_line(std::string_view line);
/// Columns padded to their widest cell; the first row is the heading. Columns whose cells are all numbers are right-aligned.
void print_table(const std::vector<std::vector<std::string>>& rows);

/// A bar on stderr, drawn only on a terminal and only when the work takes longer than half a second.
class Progress {
 public:
  explicit Progress(std::string label);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  /// @param done 0 ... 1
  void show(double done);
  void clear();

 private:
  std::string label_;
  bool terminal_, drawn_ = false;
  double began_, last_ = 0;
};

/// From now on Ctrl+C only sets a mark, so that the verb can end in order.
void catch_interrupt();
[[nodiscard]] bool interrupted();
[[nodiscard]] Error interrupted_error();

}  // namespace ugoki::cli
