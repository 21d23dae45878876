#pragma once
// Record of the running LSI (component of a circuit). A signal handler or a watchdog thread reads the record when an LSI crashes or hangs.

#include <cstddef>
#include <cstdint>
#include <span>

#include "ugoki/circuit/lsi_class.h"

namespace ugoki::circuit {

struct RunningLsi {
  const char* id = "";  ///< path: ids of the enclosing circuits, then the LSI's own id: "arm/elbow"
  const LsiClass* lsi_class = nullptr;
  const Call* call = nullptr;  ///< arguments of the LSI's functions; null while the circuit is built
};

/// Owned by the host. Interpreters write it (BuildOptions::activity) with one atomic store per word.
struct Activity {
  const RunningLsi* running = nullptr;  ///< description of the LSI that is running; null: none
  std::uint64_t passes = 0;             ///< number of ticks and refreshes begun; while an LSI is stuck, it does not increase
  /// Called for each LSI when a circuit is built, before any function of the LSI; null: not called. The host may pass the LSI's name to
  /// a process that cannot read `running`.
  void (*announce)(const RunningLsi&) = nullptr;
};

/// The LSI that another thread is running, or null. The load has acquire order, so that names, tick and inputs of the LSI can be read next.
[[nodiscard]] inline const RunningLsi* running_of(const Activity& a) { return __atomic_load_n(&a.running, __ATOMIC_ACQUIRE); }
[[nodiscard]] inline std::uint64_t passes_of(const Activity& a) { return __atomic_load_n(&a.passes, __ATOMIC_RELAXED); }
inline void set_running(Activity& a, const RunningLsi* lsi) { __atomic_store_n(&a.running, lsi, __ATOMIC_RELEASE); }

/// Writes "'quotient' (LSI 'divide' of library 'mine')", zero-terminated and truncated at the end of the buffer. Allocates nothing.
/// @return bytes written, without the terminating zero
std::size_t describe_lsi(const RunningLsi& lsi, std::span<char> buffer);
/// Writes " at 0.123 s (tick 61)" or " while the circuit was built", with the same buffer and result as describe_lsi.
std::size_t describe_time(const RunningLsi& lsi, std::span<char> buffer);
/// Writes " Its inputs were 'a' = 4, 'b' = 0.": the first 6 numeric inputs of at most 7 numbers each. Empty if the LSI has none.
std::size_t describe_inputs(const RunningLsi& lsi, std::span<char> buffer);

}  // namespace ugoki::circuit
