#include "ugoki/studio/interpreter_process.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/eventfd.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <utility>

#include "ugoki/plugin/guard.h"
#include "ugoki/plugin/strays.h"
#include "ugoki/studio/interpreter_child.h"

namespace ugoki::studio {
namespace {

// Time limit for sending a message. One thread of the child only reads the socket, so even a busy child reads a message in time.
constexpr std::chrono::milliseconds send_limit{3000};
// An LSI that replaces the process by another program (exec) is noticed when the process has been silent for this time.
constexpr std::chrono::milliseconds program_period{500};

/// Duplicates `fd` to a number of at least 16. The numbers in child_file are smaller, so dup2 in the child overwrites no duplicate.
int raised(int fd) { return fcntl(fd, F_DUPFD_CLOEXEC, 16); }

}  // namespace

Result<std::unique_ptr<InterpreterProcess>> InterpreterProcess::start(const InterpreterProgram& program, InterpreterEvents events) {
  Result<std::pair<Channel, Channel>> ends = Channel::make_pair();
  if (!ends) return fail(std::move(ends.error()));
  Result<FrameRing> ring = FrameRing::make();
  if (!ring) return fail(std::move(ring.error()));
  Result<plugin::GuardMemory> guard = plugin::GuardMemory::make();
  if (!guard) return fail(std::move(guard.error()));
  const int signal = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  int words[2] = {-1, -1};
  if (::pipe2(words, O_CLOEXEC | O_NONBLOCK) != 0) {
    close(signal);
    return fail(ErrorCode::io, program.path, "A pipe to the interpreter cannot be created.", "Close some programs and try again.");
  }
  const int handed[5] = {raised(ends->second.fd()), raised(ring->fd()), raised(signal), raised(words[1]), raised(guard->fd())};
  close(words[1]);

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, handed[0], child_file::control);
  posix_spawn_file_actions_adddup2(&actions, handed[1], child_file::frames);
  posix_spawn_file_actions_adddup2(&actions, handed[2], child_file::signal);
  posix_spawn_file_actions_adddup2(&actions, handed[3], child_file::words);
  posix_spawn_file_actions_adddup2(&actions, handed[4], child_file::guard);
  posix_spawn_file_actions_addclosefrom_np(&actions, child_file::guard + 1);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setpgroup(&attributes, 0);  // Ctrl+C in the terminal must end the studio only; the studio then ends the child
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETPGROUP);

  std::vector<char*> arguments = {const_cast<char*>(program.path.c_str())};
  for (const std::string& a : program.arguments) arguments.push_back(const_cast<char*>(a.c_str()));
  arguments.push_back(nullptr);
  static std::atomic<unsigned> started = 0;
  std::string mark = "UGOKI_INTERPRETER=" + std::to_string(getpid()) + "-" + std::to_string(++started);
  std::vector<char*> environment;
  for (char** e = environ; *e != nullptr; ++e) environment.push_back(*e);
  environment.push_back(mark.data());
  environment.push_back(nullptr);
  pid_t pid = -1;
  const int error = posix_spawn(&pid, program.path.c_str(), &actions, &attributes, arguments.data(), environment.data());
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  for (const int fd : handed) close(fd);
  if (error != 0) {
    close(signal);
    close(words[0]);
    return fail(ErrorCode::io, program.path, std::string("The interpreter cannot be started: ") + std::strerror(error) + ".",
                "Check that the program still exists and is executable.");
  }
  ends->first.set_send_limit(send_limit);
  return std::unique_ptr<InterpreterProcess>(new InterpreterProcess(std::move(ends->first), std::move(*ring), std::move(*guard), signal,
                                                                    words[0], pid, std::move(mark), std::move(events)));
}

InterpreterProcess::InterpreterProcess(Channel control, FrameRing ring, plugin::GuardMemory guard, int signal, int words, int pid,
                                       std::string mark, InterpreterEvents events)
    : control_(std::move(control)),
      ring_(std::move(ring)),
      guard_(std::move(guard)),
      signal_(signal),
      words_(words),
      pid_(pid),
      mark_(std::move(mark)),
      process_(static_cast<int>(::syscall(SYS_pidfd_open, pid, 0))),
      events_(std::move(events)),
      thread_([this] { listen(); }) {}

InterpreterProcess::~InterpreterProcess() {
  ending_ = true;
  control_.shut();
  thread_.join();
  close(signal_);
  close(words_);
  if (process_ >= 0) close(process_);
}

void InterpreterProcess::kill_unanswering() {
  if (!control_.other_end_closed()) unanswering_ = true;  // a process that has closed its end has ended: its signal is the cause
  control_.shut();
}

void InterpreterProcess::listen() {
  // The end of the process is observed too: a process that an LSI started may keep the socket open.
  pollfd files[3] = {{control_.fd(), POLLIN, 0}, {signal_, POLLIN, 0}, {process_, POLLIN, 0}};
  const plugin::ProgramId program = plugin::program_of(pid_);
  while (true) {
    const int ready = ::poll(files, 3, static_cast<int>(program_period.count()));
    if (ready < 0) {
      if (errno == EINTR) continue;
      break;
    }
    if (ready == 0) {
      const plugin::ProgramId now = plugin::program_of(pid_);
      replaced_ = now.inode != 0 && now != program;
      if (replaced_) break;
      continue;
    }
    // Read frames before the message: the child writes a frame to the ring before it sends a message about it.
    if ((files[1].revents & POLLIN) != 0 || files[0].revents != 0 || files[2].revents != 0) {
      std::uint64_t count = 0;
      [[maybe_unused]] const ssize_t n = ::read(signal_, &count, sizeof count);
      while (std::optional<std::vector<std::byte>> frame = ring_.read()) {
        if (!ending_) events_.frame(std::move(*frame));
      }
    }
    if (files[0].revents == 0 && files[2].revents != 0) break;
    if (files[0].revents == 0) continue;
    std::optional<ChannelMessage> message = control_.receive();
    if (!message) break;
    if (!ending_) events_.message(std::move(message->text));
  }
  Problem why = wait_for_end();
  if (!ending_) events_.ended(std::move(why));
}

Problem InterpreterProcess::wait_for_end() {
  const std::string safe = "The project is safe. Play to restart the interpreter.";
  bool ended = false, stopped = false;
  for (int i = 0; i < 100 && !ended && !replaced_; ++i) {  // the child ends when the socket is closed; wait at most 1 s (0.1 s if it hangs)
    siginfo_t info{};  // WNOWAIT: the process stays a zombie, so that its number still names its process group below
    if (::waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WSTOPPED | WNOHANG | WNOWAIT) != 0) break;
    stopped = stopped || (info.si_pid == pid_ && info.si_code == CLD_STOPPED);
    ended = info.si_pid == pid_ && info.si_code != CLD_STOPPED;
    if (!ended) std::this_thread::sleep_for(std::chrono::milliseconds(unanswering_ ? 1 : 10));
  }
  ::kill(-pid_, SIGKILL);  // the process group: the child, and processes that LSIs started
  int status = 0;
  pid_t got = 0;
  while ((got = waitpid(pid_, &status, 0)) < 0 && errno == EINTR) {
  }
  plugin::end_marked(mark_);  // processes that LSIs started in a group of their own (setsid)
  const auto named = [&](Problem problem) {
    problem.remedy = problem.remedy.empty() || problem.remedy == "Run it again." ? safe : problem.remedy + " " + safe;
    return problem;
  };
  std::string words(4096, '\0');  // the report was written before the process ended, so the read does not wait
  words.resize(static_cast<std::size_t>(std::max<ssize_t>(0, ::read(words_, words.data(), words.size()))));
  if (!words.empty()) return named(std::move(plugin::read_last_words(words, "ended").problems[0]));
  const auto missing = [&](const std::string& how) { return named(plugin::missing_report(guard_.block(), how).problems[0]); };
  if (replaced_) return missing("replaced its process by another program (exec), which was ended");
  if (stopped) return missing("stopped its process (SIGSTOP)");
  // on a loaded machine a crash can be recorded only after the time to respond is over: the signal is the cause
  const bool crashed = ended && got == pid_ && WIFSIGNALED(status);
  if (unanswering_ && !crashed) return missing("stopped responding and was ended");
  if (got == pid_ && WIFSIGNALED(status))
    return missing("ended its process (signal " + std::to_string(WTERMSIG(status)) + ", " + strsignal(WTERMSIG(status)) + ")");
  return missing("ended its process (exit status " + std::to_string(got == pid_ && WIFEXITED(status) ? WEXITSTATUS(status) : -1) + ")");
}

}  // namespace ugoki::studio
