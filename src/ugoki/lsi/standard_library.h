#pragma once
// The library of all built-in LSIs (function blocks of circuits).

#include "ugoki/circuit/library.h"

namespace ugoki::lsi {

/// Returns the LSIs for signals and the LSIs of this module. The library is created at the first call and never changed.
[[nodiscard]] const circuit::Library& standard_library();

}  // namespace ugoki::lsi
