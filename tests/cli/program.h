#pragma once
// Runs the program as a user does: its own process, its output in pipes.

#include <string>
#include <vector>

#include <sys/types.h>

namespace ugoki::cli {

struct Output {
  int status = -1;  ///< exit status; 128 + signal if a signal ended it
  std::string out, err;
};

/// @param environment lines "NAME=value" on top of this process's own
Output run_program(const std::vector<std::string>& arguments, const std::vector<std::string>& environment);

/// The same without waiting. @return process number
pid_t start_program(const std::vector<std::string>& arguments, const std::vector<std::string>& environment);
int wait_for(pid_t child);

}  // namespace ugoki::cli
