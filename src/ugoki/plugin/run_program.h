#pragma once
// Runs a program without a shell.

#include <chrono>
#include <string>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::plugin {

/// Exit status and output of a program.
struct ProgramOutput {
  int status = -1;         ///< exit status, or 128 + the number of the signal that ended the program
  bool timed_out = false;  ///< the program was killed because it exceeded the time limit
  std::string out, err;    ///< text of stdout and stderr
};

/// Runs a program to its end and collects its output. Its stdin is empty. Kills the program after `limit`. Error: the program cannot be
/// started. @param arguments the first one is the path of the program, or its name in PATH
[[nodiscard]] Result<ProgramOutput> run_program(const std::vector<std::string>& arguments, std::chrono::seconds limit);

}  // namespace ugoki::plugin
