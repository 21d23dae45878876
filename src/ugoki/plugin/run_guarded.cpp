// The parent's side of a guarded process: starts it, waits for its report, and makes an error if the report is missing.

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "ugoki/base/number.h"
#include "ugoki/plugin/guard.h"
#include "ugoki/plugin/guard_block.h"

namespace ugoki::plugin {
namespace {

constexpr std::chrono::milliseconds look_period{20};  // a child that ended while its pipe stays open is noticed after this time

/// Process ids of the living children of this process.
std::vector<pid_t> children() {
  std::vector<pid_t> out;
  std::error_code ec;
  for (const auto& entry : std::filesystem::directory_iterator("/proc", ec)) {
    const auto pid = parse_long(entry.path().filename().string());
    if (!pid) continue;
    std::ifstream file(entry.path() / "stat");
    std::string line;
    std::getline(file, line);
    const auto end = line.rfind(") ");  // "PID (NAME) STATE PARENT ..."
    if (end == std::string::npos || line.size() < end + 5) continue;
    if (parse_long(line.substr(end + 4, line.find(' ', end + 4) - end - 4)) == static_cast<long>(::getpid()))
      out.push_back(static_cast<pid_t>(*pid));
  }
  return out;
}

/// Ends processes that LSIs of the guarded process have started: they would keep stdout open after this program ended.
/// @param before children that this process had earlier
void end_strays(const std::vector<pid_t>& before) {
  for (int round = 0; round < 100; ++round) {  // each round makes the children of the ended processes visible
    bool found = false;
    for (const pid_t pid : children()) {
      if (std::find(before.begin(), before.end(), pid) != before.end()) continue;
      found = true;
      ::kill(pid, SIGKILL);
      while (::waitpid(pid, nullptr, 0) < 0 && errno == EINTR) {
      }
    }
    if (!found) return;
  }
}

/// How a process ended: "exit status 0" or "signal 9, Killed".
std::string end_text(int status) {
  if (WIFEXITED(status)) return "exit status " + std::to_string(WEXITSTATUS(status));
  return "signal " + std::to_string(WTERMSIG(status)) + ", " + strsignal(WTERMSIG(status));
}

/// The error of a process that ended without a report. @param how it ended: "ended its process (exit status 0)"
Error missing_report(const std::string& how) {
  const GuardBlock& block = guard_block();
  const char* const remedy = "Correct the LSI, rebuild it and restart the circuit.";
  const circuit::RunningLsi* running = running_of(block.activity);
  for (std::uint32_t i = 0; running && i < std::min(block.count.load(), GuardBlock::max_lsis); ++i) {
    if (block.lsis[i].address != running || block.lsis[i].text[0] == '\0') continue;
    const std::string who = block.lsis[i].text;
    return Error(ErrorCode::structure, who.substr(1, who.find('\'', 1) - 1), who + " " + how + " without a report.", remedy);
  }
  if (block.phase_number.load() % 2 == 1)
    return Error(ErrorCode::structure, "library", std::string(block.phase) + " when it " + how + " without a report.", remedy);
  char known[2048];
  const std::string names(known, describe_known_lsis(known, sizeof known));
  if (names.empty())
    return Error(ErrorCode::structure, "interpreter", "The process that runs the LSIs " + how + " without a report.", "Run it again.");
  return Error(ErrorCode::structure, "interpreter",
               "The process that runs the LSIs " + how +
                   " without a report. One of these LSIs of libraries ended it or closed its files: " + names + ".",
               remedy);
}

/// Reads what is in a pipe that does not block. @return false at its end
bool drain(int fd, std::string& to) {
  char buffer[1024];
  while (true) {
    const ssize_t n = ::read(fd, buffer, sizeof buffer);
    if (n > 0)
      to.append(buffer, static_cast<std::size_t>(n));
    else if (n == 0)
      return false;
    else if (errno != EINTR)
      return errno == EAGAIN;
  }
}

/// The report of work that ended: "done PID STATUS\n". Processes that an LSI forked have another PID.
std::string done_report(pid_t pid, int status) { return "done " + std::to_string(pid) + " " + std::to_string(status) + "\n"; }

}  // namespace

Error read_last_words(std::string_view words, std::string_view how) {
  const auto first = words.find('\n');
  const auto second = first == std::string_view::npos ? first : words.find('\n', first + 1);
  if (second == std::string_view::npos)
    return Error(ErrorCode::structure, "interpreter", "The process that runs the LSIs " + std::string(how) + ".", "Run it again.");
  return Error(ErrorCode::structure, std::string(words.substr(0, first)), std::string(words.substr(first + 1, second - first - 1)),
               std::string(words.substr(second + 1)));
}

Result<int> run_guarded(const std::function<int()>& work, std::chrono::milliseconds patience) {
  int ends[2];
  if (::pipe(ends) != 0)
    return fail(ErrorCode::io, "interpreter", "No pipe can be opened for the guarded process.", "Close other programs.");
  clear_guard_block();
  // Processes that LSIs start become children of this process when the guarded one ends.
  int was_reaper = 0;
  ::prctl(PR_GET_CHILD_SUBREAPER, &was_reaper);
  ::prctl(PR_SET_CHILD_SUBREAPER, 1);
  const std::vector<pid_t> before = children();
  std::fflush(nullptr);
  const pid_t child = ::fork();
  if (child < 0) {
    ::close(ends[0]);
    ::close(ends[1]);
    return fail(ErrorCode::io, "interpreter", "The guarded process cannot be started.", "Close other programs.");
  }
  if (child == 0) {
    ::close(ends[0]);
    keep_results_apart();
    guard_process(ends[1], patience);
    const int status = work() & 0xff;
    std::fflush(nullptr);
    const std::string report = done_report(::getpid(), status);
    [[maybe_unused]] const ssize_t n = ::write(ends[1], report.data(), report.size());
    _exit(status);
  }
  ::close(ends[1]);
  ::fcntl(ends[0], F_SETFL, O_NONBLOCK);
  struct sigaction ignore{}, usual{};
  ignore.sa_handler = SIG_IGN;  // Ctrl+C reaches the child too, which then ends regularly
  ::sigaction(SIGINT, &ignore, &usual);
  std::string words;
  pollfd pipe{ends[0], POLLIN, 0};
  int status = 0;
  bool stopped = false, stopped_too_long = false;
  std::chrono::milliseconds stopped_time{0};  // counted in periods, so that a stop of this process too (Ctrl+Z) does not count
  while (true) {
    (void)::poll(&pipe, 1, static_cast<int>(look_period.count()));
    if (pipe.fd >= 0 && pipe.revents != 0 && !drain(pipe.fd, words)) pipe.fd = -1;  // at its end, the child ends or has closed it
    const pid_t got = ::waitpid(child, &status, WNOHANG | WUNTRACED | WCONTINUED);
    if (got == child && !WIFSTOPPED(status) && !WIFCONTINUED(status)) break;
    if (got < 0 && errno != EINTR) break;
    if (got == child) {
      stopped = WIFSTOPPED(status);
      stopped_time = {};
    }
    if (!stopped || stopped_too_long) continue;
    stopped_time += look_period;
    stopped_too_long = stopped_time > patience;
    if (stopped_too_long) ::kill(child, SIGKILL);
  }
  if (pipe.fd >= 0) (void)drain(pipe.fd, words);
  ::close(ends[0]);
  end_strays(before);
  ::prctl(PR_SET_CHILD_SUBREAPER, was_reaper);
  ::sigaction(SIGINT, &usual, nullptr);
  if (WIFEXITED(status) && words.find(done_report(child, WEXITSTATUS(status))) != std::string::npos) return WEXITSTATUS(status);
  if (std::count(words.begin(), words.end(), '\n') >= 2 && !words.starts_with("done ")) return fail(read_last_words(words, ""));
  if (stopped_too_long) {
    char limit[32];
    std::snprintf(limit, sizeof limit, "%.1f s", 1e-3 * static_cast<double>(patience.count()));
    return fail(missing_report("stopped its process (SIGSTOP), which did not continue within " + std::string(limit) + " and was ended"));
  }
  return fail(missing_report("ended its process (" + end_text(status) + ")"));
}

}  // namespace ugoki::plugin
