#pragma once
// Runs the program as a child process and captures its output.

#include <string>
#include <vector>

#include <sys/types.h>

namespace ugoki::cli {

struct Output {
  int status = -1;  ///< exit status; 128 + signal if a signal ended it
  std::string out, err;
};

/// Runs the program and waits for its end.
/// @param environment "NAME=value" entries, added to the environment of this process
Output run_program(const std::vector<std::string>& arguments, const std::vector<std::string>& environment);

/// Starts the program without waiting. @return process id
pid_t start_program(const std::vector<std::string>& arguments, const std::vector<std::string>& environment);
int wait_for(pid_t child);

}  // namespace ugoki::cli
