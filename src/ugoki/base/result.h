#pragma once
// Result type of every function that reads data from outside: a value, or the problems found, each with its location and a remedy.

#include <expected>
#include <string>
#include <utility>
#include <vector>

namespace ugoki {

enum class ErrorCode {
  syntax,       ///< the text or bytes do not conform to the format
  truncated,    ///< the data ends too early
  range,        ///< a value is outside its allowed range, or not finite
  unknown,      ///< a name refers to no existing item
  duplicate,    ///< two items have the same name, or several items match one name
  structure,    ///< the items are inconsistent (impossible mechanism, wire between incompatible pins)
  unsupported,  ///< the data is valid, but not supported by this program
  io,           ///< the file, database or socket failed
  conflict,     ///< another program or user changed or locked the data
  cancelled,    ///< stopped by the user
};

/// One problem: its location, a description and a remedy.
struct Problem {
  ErrorCode code = ErrorCode::syntax;
  std::string location;  ///< for example "walk.bvh:17", "scenario/characters/0/track", "link left_foot"; may be empty
  std::string message;   ///< one sentence: what is wrong
  std::string remedy;    ///< one sentence: what the user can do; may be empty

  /// "location: Message. Remedy."
  [[nodiscard]] std::string text() const;
};

/// The problems found by a function, in the order in which they were found. Readers report all problems, not only the first.
struct Error {
  std::vector<Problem> problems;

  Error() = default;
  Error(Problem problem) { problems.push_back(std::move(problem)); }
  Error(ErrorCode code, std::string location, std::string message, std::string remedy = {}) {
    problems.push_back({code, std::move(location), std::move(message), std::move(remedy)});
  }
  [[nodiscard]] bool empty() const { return problems.empty(); }
  void add(ErrorCode code, std::string location, std::string message, std::string remedy = {}) {
    problems.push_back({code, std::move(location), std::move(message), std::move(remedy)});
  }
  /// The texts of all problems, one per line.
  [[nodiscard]] std::string text() const;
};

/// A value, or an error with at least one problem.
template <class T>
using Result = std::expected<T, Error>;

/// An error result with one problem: `return fail(ErrorCode::syntax, "a.bvh:3", "...", "...");` in a function that returns Result<T>.
[[nodiscard]] inline std::unexpected<Error> fail(ErrorCode code, std::string location, std::string message, std::string remedy = {}) {
  return std::unexpected<Error>(Error(code, std::move(location), std::move(message), std::move(remedy)));
}
[[nodiscard]] inline std::unexpected<Error> fail(Error error) { return std::unexpected<Error>(std::move(error)); }

}  // namespace ugoki
