#pragma once
// Memory that a guarded process shares with its parent, so that the parent can name the LSI when the process ended without a report.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>

#include "ugoki/base/result.h"
#include "ugoki/circuit/activity.h"

namespace ugoki::plugin {

/// Name of an LSI of a library in a circuit of the guarded process.
struct NamedLsi {
  const circuit::RunningLsi* address;  ///< address in the guarded process; the parent uses it as a key only
  char text[240];                      ///< text of describe_lsi(), zero-terminated; empty: the address now belongs to a built-in LSI
};

/// Data that the guarded process writes; the guarded process and its parent read them.
struct GuardBlock {
  static constexpr std::uint32_t max_lsis = 4096;  // LSIs of libraries whose names are stored; further LSIs run without a stored name
  circuit::Activity activity;
  char phase[256] = {};                        ///< description of the current phase (set_phase), zero-terminated
  std::atomic<std::uint64_t> phase_number{0};  ///< odd during a phase; increases with every change
  std::atomic<std::uint32_t> count{0};         ///< number of entries of `lsis` in use
  NamedLsi lsis[max_lsis];
};

/// The block of this process, in memory that is shared with processes forked later, or with the parent after attach_guard_block().
[[nodiscard]] GuardBlock& guard_block();
/// Clears the block, so that it contains no LSI and no phase.
void clear_guard_block();
/// Uses the memory of the file `fd` (GuardMemory::fd() of the parent) as the block of this process. Call it before the first call of
/// guard_block(). @return false: the memory cannot be used, and the parent will see an empty block
bool attach_guard_block(int fd);
/// Writes "'a' (LSI 'x/y' of library 'x'), 'b' (...)" to `buffer`: the first 4 LSIs of libraries, each once, and " and 7 more" if there are
/// further ones. Allocates nothing.
/// @return number of bytes written
std::size_t describe_known_lsis(const GuardBlock& block, char* buffer, std::size_t size);
/// The error of a process that ended without a report: names the LSI that was running, the phase, or the LSIs of libraries.
/// @param how how it ended, as the end of a sentence: "ended its process (exit status 0)"
[[nodiscard]] Error missing_report(const GuardBlock& block, const std::string& how);

/// Memory for the block of a process that is started with exec instead of fork. The child calls attach_guard_block().
class GuardMemory {
 public:
  [[nodiscard]] static Result<GuardMemory> make();
  GuardMemory(GuardMemory&& other) noexcept;
  GuardMemory& operator=(GuardMemory&&) = delete;
  ~GuardMemory();
  /// Descriptor that the child inherits; closed when exec is called unless it is duplicated.
  [[nodiscard]] int fd() const { return fd_; }
  /// The shared memory. The child may write to it at any time.
  [[nodiscard]] const GuardBlock& block() const { return *block_; }

 private:
  GuardMemory(int fd, const GuardBlock* block) : fd_(fd), block_(block) {}
  int fd_ = -1;
  const GuardBlock* block_ = nullptr;
};

}  // namespace ugoki::plugin
