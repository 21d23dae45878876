#pragma once
// A function in a process of its own; internal to scene_formats.

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

#include "ugoki/base/result.h"

namespace ugoki::scene_formats {

struct GuardLimits {
  double seconds = 120;                       ///< by the clock
  std::size_t memory = std::size_t{4} << 30;  ///< bytes of address space beyond what this process has
  std::size_t answer = std::size_t{2} << 30;  ///< bytes
};

/// Runs `call` in a child process (a copy of this one) and gives what it returned. An Error (code io, at `place`) where the child crashed,
/// took longer, wanted more memory, or answered more. The call must not need other threads, and must not write to files.
[[nodiscard]] Result<std::string> call_guarded(const std::function<std::string()>& call, std::string_view place,
                                               const GuardLimits& limits = {});

}  // namespace ugoki::scene_formats
