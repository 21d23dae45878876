#pragma once
// Memory that a guarded process shares with its parent, so that the parent can name the LSI when the process ended without a report.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>

#include "ugoki/circuit/activity.h"

namespace ugoki::plugin {

/// Name of an LSI of a library in a circuit of the guarded process.
struct NamedLsi {
  const circuit::RunningLsi* address;  ///< in the guarded process; a key for the parent
  char text[240];                      ///< describe_lsi, zero-terminated; empty: the address now belongs to a built-in LSI
};

/// Written by the guarded process, read by it and its parent.
struct GuardBlock {
  static constexpr std::uint32_t max_lsis = 4096;  // LSIs of libraries that can be named; further ones run without a name here
  circuit::Activity activity;
  char phase[256] = {};                        ///< zero-terminated; see set_phase
  std::atomic<std::uint64_t> phase_number{0};  ///< odd during a phase; increases with every change
  std::atomic<std::uint32_t> count{0};         ///< entries of `lsis` in use
  NamedLsi lsis[max_lsis];
};

/// The block of this process, in memory that is shared with processes forked later.
[[nodiscard]] GuardBlock& guard_block();
/// Clears the block: no LSI, no phase.
void clear_guard_block();
/// Writes "'a' (LSI 'x/y' of library 'x'), 'b' (...)" for the first 4 LSIs of libraries. Allocates nothing. @return bytes written
std::size_t describe_known_lsis(char* buffer, std::size_t size);

}  // namespace ugoki::plugin
