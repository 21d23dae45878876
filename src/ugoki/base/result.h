#pragma once
// What every reader of outside data returns: a value, or the problems found, each with a place and a remedy.

#include <expected>
#include <string>
#include <utility>
#include <vector>

namespace ugoki {

enum class ErrorCode {
  syntax,       ///< the text or bytes do not follow the format
  truncated,    ///< the data ends too early
  range,        ///< a number is out of its range, or not finite
  unknown,      ///< a name that nothing has
  duplicate,    ///< a name that two things have
  structure,    ///< the parts do not fit together (impossible mechanism, wrong wire)
  unsupported,  ///< valid, but this program does not do it
  io,           ///< the file, database or socket failed
  conflict,     ///< somebody else changed it first
  cancelled,    ///< stopped by the user
};

/// One problem: where it is, what is wrong, what to do about it.
struct Problem {
  ErrorCode code = ErrorCode::syntax;
  std::string place;    ///< "walk.bvh:17", "scenario/characters/0/track", "link left_foot"
  std::string message;  ///< a sentence
  std::string remedy;   ///< a sentence; may be empty where the message says it all

  /// "place: message Remedy."
  [[nodiscard]] std::string text() const;
};

/// At least one problem; readers report all they found, not only the first.
struct Error {
  std::vector<Problem> problems;

  Error() = default;
  Error(Problem problem) { problems.push_back(std::move(problem)); }
  Error(ErrorCode code, std::string place, std::string message, std::string remedy = {}) {
    problems.push_back({code, std::move(place), std::move(message), std::move(remedy)});
  }
  [[nodiscard]] bool empty() const { return problems.empty(); }
  void add(ErrorCode code, std::string place, std::string message, std::string remedy = {}) {
    problems.push_back({code, std::move(place), std::move(message), std::move(remedy)});
  }
  /// One line a problem.
  [[nodiscard]] std::string text() const;
};

template <class T>
using Result = std::expected<T, Error>;

/// `return fail(ErrorCode::syntax, "a.bvh:3", "...", "...");` in a function that returns Result<T>.
[[nodiscard]] inline std::unexpected<Error> fail(ErrorCode code, std::string place, std::string message, std::string remedy = {}) {
  return std::unexpected<Error>(Error(code, std::move(place), std::move(message), std::move(remedy)));
}
[[nodiscard]] inline std::unexpected<Error> fail(Error error) { return std::unexpected<Error>(std::move(error)); }

}  // namespace ugoki
