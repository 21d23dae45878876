#pragma once
// Last words of a process that foreign code ended or kept busy: which LSI, when, and with which inputs.

#include <chrono>
#include <functional>
#include <string>
#include <string_view>

#include "ugoki/base/result.h"
#include "ugoki/circuit/activity.h"

namespace ugoki::plugin {

inline constexpr std::chrono::milliseconds usual_patience{3000};

/// What interpreters of this process note (BuildOptions::activity), and what its last words tell.
[[nodiscard]] circuit::Activity& process_activity();
/// What else is going on ("The library 'springs' was being loaded"), for the time when no LSI runs yet; empty: nothing.
void set_phase(std::string_view what);

/// From now on this process ends with last words on `fd` when it crashes (a null pointer, a whole number divided by zero, abort, exit
/// while an LSI runs) or when one LSI, or a phase, takes longer than `patience`. Once in a process, on its main thread.
void guard_process(int fd, std::chrono::milliseconds patience = usual_patience);

/// Last words as an error (place: the LSI). Empty text: an error that only says `how` it ended.
[[nodiscard]] Error read_last_words(std::string_view words, std::string_view how);

/// Runs `work` in a guarded child of this process, which shares stdout and stderr; this process may have one thread only.
/// @return exit status of `work`; an error where it did not come to its end
[[nodiscard]] Result<int> run_guarded(const std::function<int()>& work, std::chrono::milliseconds patience = usual_patience);

}  // namespace ugoki::plugin
