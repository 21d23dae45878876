#pragma once
// Crash reports for processes that run foreign code. When an LSI crashes or does not return, its process writes a report to a pipe and
// ends. The report ("last words") names the LSI, the time and the inputs; the parent process turns it into an error.

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>
#include <string_view>

#include "ugoki/base/result.h"
#include "ugoki/circuit/activity.h"

namespace ugoki::plugin {

/// Time after which one call of an LSI counts as hung, if the user does not set another one.
inline constexpr std::chrono::milliseconds usual_patience{3000};

/// Record of the LSI that runs in this process now. Pass the record to interpreters as BuildOptions::activity; crash reports read it.
[[nodiscard]] circuit::Activity& process_activity();
/// Begins a phase: `what` describes foreign code that runs outside of any LSI ("The library 'springs' was being loaded"), for crash
/// reports. An empty text ends the phase. Call it from one thread only. At most 255 bytes are kept.
void set_phase(std::string_view what);

/// Guards this process from now on. When it crashes (null pointer, division of an integer by zero, abort), when an LSI calls exit, or when
/// one call of an LSI or one phase takes longer than `patience`, the process writes a crash report to `fd` and ends with status 70. The
/// same happens when foreign code tries to send a signal to the parent process. The process may then use at most half of the machine's
/// memory. Call it once in a process, on its main thread.
void guard_process(int fd, std::chrono::milliseconds patience = usual_patience);

/// Converts a crash report to an error whose location is the LSI. @param how how the process ended ("was ended by signal 9"); used as the
/// message if the report `words` is empty or incomplete
[[nodiscard]] Error read_last_words(std::string_view words, std::string_view how);

/// Records the addresses from `begin` to `end` of the code of a loaded library, so that the report of a crash in a thread names the
/// library. forget_code() removes the record.
void note_code(std::string_view name, std::uintptr_t begin, std::uintptr_t end);
void forget_code(std::uintptr_t begin);

/// Stream for the results of this process. It is stdout; after keep_results_apart() it is another stream to the same file.
[[nodiscard]] std::FILE* results();
/// Redirects stdout to stderr, so that text that foreign code prints does not mix with results(). run_guarded calls it in the child.
void keep_results_apart();

/// Runs `work` in a guarded child process (fork), which shares stderr and results() with this one. Call it while this process has only one
/// thread. Processes that foreign code started are ended with the child.
/// @return the return value of `work`, 0 ... 255. Errors, which name the LSI if one was running: the child crashed, hung, was stopped for
/// longer than `patience`, was killed, or ended without the report that `work` returned, whatever its exit status.
[[nodiscard]] Result<int> run_guarded(const std::function<int()>& work, std::chrono::milliseconds patience = usual_patience);

}  // namespace ugoki::plugin
