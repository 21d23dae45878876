#pragma once
// Text form of breakpoint conditions.

#include <string_view>

#include "ugoki/base/result.h"
#include "ugoki/circuit/interpreter.h"

namespace ugoki::circuit {

/// The breakpoint written as "id.pin > 3" (one of > < == != or =), "id.pin becomes true" (above 0) or "id.pin changes". A pin of several
/// numbers is compared by number 0, or by the one in brackets: "id.pin[2] > 3" (counted from 0). Errors have the location "condition".
[[nodiscard]] Result<Breakpoint> read_breakpoint(std::string_view text);

}  // namespace ugoki::circuit
