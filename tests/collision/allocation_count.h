#pragma once

namespace ugoki::collision::test {
/// Calls of operator new by this program so far.
long allocations();
}  // namespace ugoki::collision::test
