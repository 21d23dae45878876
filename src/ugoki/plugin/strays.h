#pragma once
// Ends processes that foreign code has started and that outlive the process in which the foreign code ran.

#include <sys/types.h>

#include <string>
#include <string_view>
#include <vector>

namespace ugoki::plugin {

/// File of the program that a process runs.
struct ProgramId {
  dev_t device = 0;
  ino_t inode = 0;  ///< 0: the process has ended
  friend bool operator==(const ProgramId&, const ProgramId&) = default;
};
[[nodiscard]] ProgramId program_of(pid_t pid);

/// Process ids of the living children of this process.
[[nodiscard]] std::vector<pid_t> children();

/// Kills the children of this process except those in `kept`, and waits until they have ended. If this process is a subreaper
/// (PR_SET_CHILD_SUBREAPER), its children include the orphaned descendants of ended processes.
void end_children_except(const std::vector<pid_t>& kept);

/// Kills all processes of this user that were started with the entry `variable` ("NAME=VALUE") in their environment, whatever their
/// session, process group or parent. Does not find a process that cleared its environment before it executed another program.
void end_marked(std::string_view variable);

}  // namespace ugoki::plugin
