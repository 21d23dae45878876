#pragma once

namespace ugoki::testing {
/// Calls of operator new by this program so far.
[[nodiscard]] long allocation_count();
}  // namespace ugoki::testing
