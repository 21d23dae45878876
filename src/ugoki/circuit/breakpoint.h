#pragma once
// Conditions of breakpoints as text.

#include <string_view>

#include "ugoki/base/result.h"
#include "ugoki/circuit/interpreter.h"

namespace ugoki::circuit {

/// "id.pin > 3" with one of > < == != (or =), "id.pin becomes true" (above 0), "id.pin changes". Of a pin of several numbers the first
/// counts, or the one that is named: "id.pin[2] > 3", from 0. An error has the place "condition".
[[nodiscard]] Result<Breakpoint> read_breakpoint(std::string_view text);

}  // namespace ugoki::circuit
