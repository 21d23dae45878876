#pragma once
// Counts allocations, for tests that a step allocates nothing. Linking ugoki_allocation_count replaces operator new in the program.

namespace ugoki {

/// Number of calls of operator new in this program so far, in all threads.
[[nodiscard]] long allocations_so_far();

}  // namespace ugoki
