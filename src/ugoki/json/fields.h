#pragma once
// Reads JSON objects field by field and reports every problem with its path in the document.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/json/json.h"

namespace ugoki::json {

/// Maximum number of problems reported for one document. It bounds the size of the answer to a hostile document.
inline constexpr std::size_t max_problems = 100;

/// Reader of one JSON object. An absent field leaves its variable unchanged; a field of the wrong type adds a problem.
/// Refers to the object and to the list of problems; both must outlive the reader.
class Fields {
 public:
  /// @param path location of the object, for messages: "scenario/events/3", or "walker.json:" for the top-level object of a file
  Fields(const Json& object, std::string path, Error& problems);

  /// False if the value is not a JSON object. Every field then counts as absent; the constructor has reported the problem.
  [[nodiscard]] bool is_object() const { return object_.is_object(); }
  [[nodiscard]] bool has(std::string_view key) const;
  /// The value of field `key`, or null if it is absent. Marks the field as known for refuse_others().
  [[nodiscard]] const Json* find(std::string_view key);
  /// Returns `former` if the object has the field only under this former name, otherwise `key`. Keeps older documents readable.
  [[nodiscard]] std::string_view renamed(std::string_view key, std::string_view former) const;
  /// Path of the object.
  [[nodiscard]] const std::string& path() const { return path_; }
  /// Path of field `key`.
  [[nodiscard]] std::string path(std::string_view key) const;
  [[nodiscard]] Error& problems() { return problems_; }
  /// Adds a problem, as long as there are fewer than max_problems.
  void report(ErrorCode code, std::string path, std::string message, std::string remedy);

  // Each of these sets `value` from field `key`; it reports a problem if the field has another type.
  void number(std::string_view key, double& value);
  void integer(std::string_view key, int& value);
  void boolean(std::string_view key, bool& value);
  void text(std::string_view key, std::string& value);
  /// Reads a list of exactly `values.size()` numbers. @return true if the field is present and valid; otherwise `values` is unchanged
  bool numbers(std::string_view key, std::span<double> values);
  /// Reads a list of exactly `values.size()` numbers from any value of the document. @param path location of `value`, for messages
  bool numbers(const Json& value, const std::string& path, std::span<double> values);
  /// The list in field `key`; null if the field is absent. Reports a problem and returns null if the field is not a list or has more
  /// than `max_entries` entries. @param entries plural noun for messages, for example "links"
  [[nodiscard]] const Json* list(std::string_view key, std::size_t max_entries, std::string_view entries);
  /// Reports a problem if the field is absent. @param meaning description of the field, for the remedy: "Give <meaning>."
  void require(std::string_view key, std::string_view meaning);
  /// Reports every field of the object that no earlier call has read or looked up.
  void refuse_others();

 private:
  void wrong(const std::string& path, const Json& value, std::string_view wanted);

  const Json& object_;
  std::string path_;
  Error& problems_;
  std::vector<std::string> known_;
};

}  // namespace ugoki::json
