#pragma once
// Differences between two JSON documents, for undo histories. Internal to content and project.

#include "ugoki/base/result.h"
#include "ugoki/content/json_fields.h"

namespace ugoki::content {

/// What makes `to` of `from`, as JSON; null if they are equal. The order of fields counts.
///   {"v": value}                       replace the whole
///   {"o": {"name": delta, ...}}        an object with the same fields in the same order: change these
///   {"a": [[i, delta], ...]}           a list of the same length: change these entries
///   {"s": [i, n, [value, ...]]}        a list: at i take n entries out and put these in
[[nodiscard]] Json make_delta(const Json& from, const Json& to);

/// Applies a delta made by make_delta. A delta that does not fit is a problem.
[[nodiscard]] Result<Json> apply_delta(const Json& from, const Json& delta);

}  // namespace ugoki::content
