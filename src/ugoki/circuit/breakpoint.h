#pragma once
// Text form of breakpoint conditions.

#include <string_view>

#include "ugoki/base/result.h"
#include "ugoki/circuit/interpreter.h"

namespace ugoki::circuit {

/// Reads a breakpoint: "id.pin > 3" (operators > < == != =), "id.pin becomes true" (rises above 0) or "id.pin changes". Of a pin with
/// several numbers, number 0 is compared, or the one in brackets: "id.pin[2] > 3" (counted from 0). Errors have the location "condition".
[[nodiscard]] Result<Breakpoint> read_breakpoint(std::string_view text);

}  // namespace ugoki::circuit
