#pragma once
// A filter of system calls that stops foreign code before it signals the process of Ugoki that runs it.

namespace ugoki::plugin {

/// From now on, kill() and related system calls of this process raise SIGSYS in the caller if they address the parent process, the own
/// process group or all processes. kill() with signal 0, which only tests for existence, is not affected. Threads and processes that are
/// started later have the same filter. Call it on the main thread, before other threads start. Side effect: programs that this process
/// starts cannot gain rights by set-user-ID.
/// @return false: the kernel does not support filters, and signals are not stopped
bool forbid_signals_to_parent();

}  // namespace ugoki::plugin
