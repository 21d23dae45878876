#pragma once
// For tests that steps allocate nothing. Linking ugoki_allocation_count replaces operator new in the whole program.

namespace ugoki {

/// Calls of operator new by this program so far, from any thread.
[[nodiscard]] long allocations_so_far();

}  // namespace ugoki
