#pragma once
// Reading JSON objects field by field with all problems reported by their path in the document.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/json/json.h"

namespace ugoki::json {

/// More problems help nobody; the bound keeps the answer to a hostile document small.
inline constexpr std::size_t most_problems = 100;

/// One object of a document. Absent fields leave their variable alone, wrong ones become problems.
class Fields {
 public:
  /// @param path of the object, for messages: "scenario/events/3", or "walker.json:" for the whole of a file
  Fields(const Json& object, std::string path, Error& problems);

  /// False where the value is something else; then every field is absent and the problem is told.
  [[nodiscard]] bool is_object() const { return object_.is_object(); }
  [[nodiscard]] bool has(std::string_view key) const;
  /// The field, or null.
  [[nodiscard]] const Json* find(std::string_view key);
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::string path(std::string_view key) const;
  [[nodiscard]] Error& problems() { return problems_; }
  /// Adds a problem, as long as there are fewer than most_problems.
  void report(ErrorCode code, std::string path, std::string message, std::string remedy);

  void number(std::string_view key, double& value);
  void integer(std::string_view key, int& value);
  void boolean(std::string_view key, bool& value);
  void text(std::string_view key, std::string& value);
  /// A list of exactly as many numbers as `values` holds. @return whether it was there and right
  bool numbers(std::string_view key, std::span<double> values);
  /// The same for any value of the document. @param path its own
  bool numbers(const Json& value, const std::string& path, std::span<double> values);
  /// A list of at most `most` entries; null if it is absent or something else (told). @param what "links", for messages
  [[nodiscard]] const Json* list(std::string_view key, std::size_t most, std::string_view what);
  /// The field must be there.
  void require(std::string_view key, std::string_view meaning);
  /// Reports every field that was not asked for.
  void refuse_others();

 private:
  void wrong(const std::string& path, const Json& value, std::string_view wanted);

  const Json& object_;
  std::string path_;
  Error& problems_;
  std::vector<std::string> known_;
};

}  // namespace ugoki::json
