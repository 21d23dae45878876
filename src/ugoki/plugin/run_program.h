#pragma once
// Runs a program without a shell.

#include <chrono>
#include <string>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::plugin {

struct ProgramOutput {
  int status = -1;  ///< exit status, or 128 + the number of the signal that ended it
  bool timed_out = false;
  std::string out, err;
};

/// Waits for its end; ends it after `limit`. @param arguments the first one is the program's path
[[nodiscard]] Result<ProgramOutput> run_program(const std::vector<std::string>& arguments, std::chrono::seconds limit);

}  // namespace ugoki::plugin
