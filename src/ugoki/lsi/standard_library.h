#pragma once
// Every LSI that content may use.

#include "ugoki/circuit/library.h"

namespace ugoki::lsi {

/// The signal LSIs and those of this module. Made once, never changed.
[[nodiscard]] const circuit::Library& standard_library();

}  // namespace ugoki::lsi
