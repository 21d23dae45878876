#pragma once
// Runs a program without a shell.

#include <chrono>
#include <functional>
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

/// Limits of a program.
struct ProgramLimits {
  std::chrono::seconds time;             ///< the program is killed after this time
  std::string temporary_folder = {};     ///< folder for the temporary files of the program; empty: the same as for this program
  std::function<bool()> cancelled = {};  ///< true: the program is killed; may be empty
};

/// Runs a program to its end and collects its output. Its stdin is empty. Errors: the program cannot be started; `cancelled`.
/// @param arguments the first one is the path of the program, or its name in PATH
[[nodiscard]] Result<ProgramOutput> run_program(const std::vector<std::string>& arguments, const ProgramLimits& limits);

}  // namespace ugoki::plugin
