#pragma once
// Which LSI is being executed right now: for a signal handler or a watching thread, when foreign code crashes or does not return.

#include <cstddef>
#include <cstdint>
#include <span>

#include "ugoki/circuit/lsi_class.h"

namespace ugoki::circuit {

struct RunningLsi {
  const char* id = "";  ///< "arm/elbow"
  const LsiClass* lsi_class = nullptr;
  const Call* call = nullptr;  ///< null while the circuit is built
};

/// Owned by the host, written by interpreters (BuildOptions::activity) with plain stores of one word each.
struct Activity {
  const RunningLsi* running = nullptr;  ///< null: none
  std::uint64_t passes = 0;             ///< ticks and refreshes begun: a running LSI is stuck if this does not change for long
};

/// Reads what another thread writes; with it come what the LSI reads: its names, the tick, its inputs.
[[nodiscard]] inline const RunningLsi* running_of(const Activity& a) { return __atomic_load_n(&a.running, __ATOMIC_ACQUIRE); }
[[nodiscard]] inline std::uint64_t passes_of(const Activity& a) { return __atomic_load_n(&a.passes, __ATOMIC_RELAXED); }
inline void set_running(Activity& a, const RunningLsi* lsi) { __atomic_store_n(&a.running, lsi, __ATOMIC_RELEASE); }

/// "'quotient' (LSI 'divide' of library 'mine')": zero-terminated, cut off where the buffer ends. Allocates nothing.
/// @return bytes written without the zero
std::size_t describe_lsi(const RunningLsi& lsi, std::span<char> buffer);
/// " at 0.123 s (tick 61)" or " while the circuit was built".
std::size_t describe_time(const RunningLsi& lsi, std::span<char> buffer);
/// " Its inputs were 'a' = 4, 'b' = 0." for inputs of few numbers; empty where there are none.
std::size_t describe_inputs(const RunningLsi& lsi, std::span<char> buffer);

}  // namespace ugoki::circuit
