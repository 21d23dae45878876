#pragma once
// The library of all built-in LSIs.

#include "ugoki/circuit/library.h"

namespace ugoki::lsi {

/// The signal LSIs and the LSIs of this module. Created at the first call, never changed.
[[nodiscard]] const circuit::Library& standard_library();

}  // namespace ugoki::lsi
