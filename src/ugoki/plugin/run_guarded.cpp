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
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "ugoki/plugin/drain.h"
#include "ugoki/plugin/guard.h"
#include "ugoki/plugin/guard_block.h"
#include "ugoki/plugin/strays.h"

namespace ugoki::plugin {
namespace {

volatile sig_atomic_t guarded_child = 0;    // process id of the child while signals are passed on to it
volatile sig_atomic_t received_signal = 0;  // the last signal that was passed on; 0: none

/// Passes a signal on to the guarded child. Ctrl+C of a terminal (sent by the kernel) reaches the child without this.
void pass_on(int signal, siginfo_t* info, void*) {
  received_signal = signal;
  if (signal == SIGINT && info->si_code == SI_KERNEL) return;
  if (guarded_child > 0) ::kill(static_cast<pid_t>(guarded_child), signal);
}

/// Passes SIGINT, SIGTERM and SIGHUP on to a child process until it is destroyed.
class PassOnSignals {
 public:
  explicit PassOnSignals(pid_t child) {
    received_signal = 0;
    guarded_child = child;
    struct sigaction act{};
    act.sa_sigaction = pass_on;
    act.sa_flags = SA_SIGINFO | SA_RESTART;
    for (std::size_t i = 0; i < std::size(signals); ++i) ::sigaction(signals[i], &act, &usual_[i]);
  }
  PassOnSignals(const PassOnSignals&) = delete;
  PassOnSignals& operator=(const PassOnSignals&) = delete;
  ~PassOnSignals() {
    guarded_child = 0;
    for (std::size_t i = 0; i < std::size(signals); ++i) ::sigaction(signals[i], &usual_[i], nullptr);
  }

 private:
  static constexpr int signals[] = {SIGINT, SIGTERM, SIGHUP};
  struct sigaction usual_[std::size(signals)];
};

constexpr int looks_per_program_check = 10;           // the program of the child is compared after this number of look periods
constexpr std::chrono::milliseconds look_period{20};  // a child that ended while its pipe stays open is noticed after this time

/// How a process ended: "exit status 0" or "signal 9, Killed".
std::string end_text(int status) {
  if (WIFEXITED(status)) return "exit status " + std::to_string(WEXITSTATUS(status));
  return "signal " + std::to_string(WTERMSIG(status)) + ", " + strsignal(WTERMSIG(status));
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
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child < 0) {
    ::close(ends[0]);
    ::close(ends[1]);
    return fail(ErrorCode::io, "interpreter", "The guarded process cannot be started.", "Close other programs.");
  }
  if (child == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // nobody would read the results after the end of the parent
    if (::getppid() != parent) _exit(1);
    ::close(ends[0]);
    keep_results_apart();
    guard_process(ends[1], patience);
    int status = work() & 0xff;
    std::fflush(nullptr);
    if (status == 0 && std::ferror(results()) != 0) {  // for example a full disk
      std::fprintf(stderr, "ugoki: standard output: The output could not be written.\n");
      status = 1;
    }
    const std::string report = done_report(::getpid(), status);
    [[maybe_unused]] const ssize_t n = ::write(ends[1], report.data(), report.size());
    _exit(status);
  }
  ::close(ends[1]);
  ::fcntl(ends[0], F_SETFL, O_NONBLOCK);
  std::optional<PassOnSignals> signals(child);  // the child ends normally after a signal; this process waits for it
  const ProgramId program = program_of(parent);
  bool replaced = false;  // the child has replaced its program (exec), so that its guard no longer exists
  int looks = 0;
  std::string words;
  pollfd pipe{ends[0], POLLIN, 0};
  int status = 0;
  bool stopped = false, stopped_too_long = false;
  std::chrono::milliseconds stopped_time{0};  // a sum of periods, so that time in which this process is stopped too (Ctrl+Z) is not counted
  while (true) {
    (void)::poll(&pipe, 1, static_cast<int>(look_period.count()));
    if (pipe.fd >= 0 && pipe.revents != 0 && !drain(pipe.fd, words)) pipe.fd = -1;  // end of the pipe: the child ended or closed it
    const pid_t got = ::waitpid(child, &status, WNOHANG | WUNTRACED | WCONTINUED);
    if (got == child && !WIFSTOPPED(status) && !WIFCONTINUED(status)) break;
    if (got < 0 && errno != EINTR) break;
    if (got == child) {
      stopped = WIFSTOPPED(status);
      stopped_time = {};
    }
    if (!replaced && ++looks % looks_per_program_check == 0) {
      const ProgramId now = program_of(child);
      replaced = now.inode != 0 && now != program;
      if (replaced) ::kill(child, SIGKILL);
    }
    if (!stopped || stopped_too_long) continue;
    stopped_time += look_period;
    stopped_too_long = stopped_time > patience;
    if (stopped_too_long) ::kill(child, SIGKILL);
  }
  if (pipe.fd >= 0) (void)drain(pipe.fd, words);
  ::close(ends[0]);
  end_children_except(before);
  ::prctl(PR_SET_CHILD_SUBREAPER, was_reaper);
  signals.reset();
  if (received_signal != 0 && WIFSIGNALED(status) && WTERMSIG(status) == received_signal) {
    ::signal(WTERMSIG(status), SIG_DFL);
    ::raise(WTERMSIG(status));  // this process ends as the child did
  }
  if (replaced) return fail(missing_report(guard_block(), "replaced its process by another program (exec), which was ended"));
  if (WIFEXITED(status) && words.find(done_report(child, WEXITSTATUS(status))) != std::string::npos) return WEXITSTATUS(status);
  if (std::count(words.begin(), words.end(), '\n') >= 2 && !words.starts_with("done ")) return fail(read_last_words(words, ""));
  if (stopped_too_long) {
    char limit[32];
    std::snprintf(limit, sizeof limit, "%.1f s", 1e-3 * static_cast<double>(patience.count()));
    return fail(missing_report(guard_block(),
                               "stopped its process (SIGSTOP), which did not continue within " + std::string(limit) + " and was ended"));
  }
  return fail(missing_report(guard_block(), "ended its process (" + end_text(status) + ")"));
}

}  // namespace ugoki::plugin
