#pragma once
// Deltas (differences) between two JSON documents, for undo histories. Internal to content and project.

#include "ugoki/base/result.h"
#include "ugoki/content/json_fields.h"

namespace ugoki::content {

/// Returns the delta, as JSON, that turns `from` into `to`; null if they are equal. The order of fields is significant.
///   {"v": value}                       replace the whole value
///   {"o": {"name": delta, ...}}        object with the same fields in the same order: change these fields
///   {"a": [[i, delta], ...]}           list of the same length: change the entries with these indices
///   {"s": [i, n, [value, ...]]}        list: at index i, remove n entries and insert these values
[[nodiscard]] Json make_delta(const Json& from, const Json& to);

/// Returns `from` after application of a delta from make_delta(). Error `structure`: the delta does not fit the document.
[[nodiscard]] Result<Json> apply_delta(const Json& from, const Json& delta);

}  // namespace ugoki::content
