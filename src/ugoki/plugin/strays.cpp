#include "ugoki/plugin/strays.h"

#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "ugoki/base/number.h"

namespace ugoki::plugin {
namespace {

constexpr int max_rounds = 100;  // processes start others until they are killed; each round finds those started in the round before

/// Calls `use` with the id and the folder in /proc of each process.
template <class Use>
void for_each_process(Use use) {
  std::error_code ec;
  for (const auto& entry : std::filesystem::directory_iterator("/proc", ec))
    if (const auto pid = parse_long(entry.path().filename().string())) use(static_cast<pid_t>(*pid), entry.path());
}

/// Whether the NUL-separated entries of /proc/PID/environ contain `variable`.
bool has_entry(const std::string& environment, std::string_view variable) {
  for (std::size_t at = 0; (at = environment.find(variable, at)) != std::string::npos; ++at) {
    const std::size_t end = at + variable.size();
    if ((at == 0 || environment[at - 1] == '\0') && (end == environment.size() || environment[end] == '\0')) return true;
  }
  return false;
}

}  // namespace

ProgramId program_of(pid_t pid) {
  struct stat file{};
  if (::stat(("/proc/" + std::to_string(pid) + "/exe").c_str(), &file) != 0) return {};
  return {file.st_dev, file.st_ino};
}

std::vector<pid_t> children() {
  std::vector<pid_t> out;
  for_each_process([&](pid_t pid, const std::filesystem::path& folder) {
    std::ifstream file(folder / "stat");
    std::string line;
    std::getline(file, line);
    const auto end = line.rfind(") ");  // the line is "PID (NAME) STATE PARENT ..."
    if (end == std::string::npos || line.size() < end + 5) return;
    if (parse_long(line.substr(end + 4, line.find(' ', end + 4) - end - 4)) == static_cast<long>(::getpid())) out.push_back(pid);
  });
  return out;
}

void end_children_except(const std::vector<pid_t>& kept) {
  for (int round = 0; round < max_rounds; ++round) {  // each round makes the children of the ended processes visible
    bool found = false;
    for (const pid_t pid : children()) {
      if (std::find(kept.begin(), kept.end(), pid) != kept.end()) continue;
      found = true;
      ::kill(pid, SIGKILL);
      while (::waitpid(pid, nullptr, 0) < 0 && errno == EINTR) {
      }
    }
    if (!found) return;
  }
}

void end_marked(std::string_view variable) {
  for (int round = 0; round < max_rounds; ++round) {
    bool found = false;
    for_each_process([&](pid_t pid, const std::filesystem::path& folder) {
      if (pid == ::getpid()) return;
      std::ifstream file(folder / "environ", std::ios::binary);  // empty for processes that have ended or belong to another user
      const std::string environment((std::istreambuf_iterator<char>(file)), {});
      if (has_entry(environment, variable)) found = ::kill(pid, SIGKILL) == 0 || found;
    });
    if (!found) return;
  }
}

}  // namespace ugoki::plugin
