#pragma once
// Runs a function in a child process with limits on time, memory and answer size. Internal to scene_formats.

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

#include "ugoki/base/result.h"

namespace ugoki::scene_formats {

/// Limits of a guarded call.
struct GuardLimits {
  double seconds = 120;                       ///< wall-clock time
  std::size_t memory = std::size_t{4} << 30;  ///< bytes of address space, added to the size of the calling process
  std::size_t answer = std::size_t{2} << 30;  ///< maximum size of the answer, bytes
};

/// Runs `call` in a child process (a fork of this process) and returns its result. An Error (at `location`) if the child crashes or exceeds
/// the time, memory or answer limit. The call must not depend on other threads and must not write to files. POSIX only.
[[nodiscard]] Result<std::string> call_guarded(const std::function<std::string()>& call, std::string_view location,
                                               const GuardLimits& limits = {});

}  // namespace ugoki::scene_formats
