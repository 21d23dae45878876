#include "ugoki/plugin/run_program.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "ugoki/files/environment.h"
#include "ugoki/plugin/drain.h"

namespace ugoki::plugin {
namespace {

constexpr std::chrono::milliseconds look_period{20};  // a program that ended while its pipes stay open is noticed after this time

}  // namespace

Result<ProgramOutput> run_program(const std::vector<std::string>& arguments, const ProgramLimits& limits) {
  int out[2], err[2];
  if (::pipe2(out, O_CLOEXEC) != 0)
    return fail(ErrorCode::io, arguments[0], "No pipe can be opened for the program's output.", "Close other programs.");
  if (::pipe2(err, O_CLOEXEC) != 0) {
    ::close(out[0]);
    ::close(out[1]);
    return fail(ErrorCode::io, arguments[0], "No pipe can be opened for the program's output.", "Close other programs.");
  }
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, out[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, err[1], STDERR_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  std::vector<char*> argv;
  for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  pid_t pid = -1;
  files::Environment environment;
  if (!limits.temporary_folder.empty()) environment.set("TMPDIR", limits.temporary_folder);
  const int error = posix_spawnp(&pid, argv[0], &actions, nullptr, argv.data(), environment.pointers());
  posix_spawn_file_actions_destroy(&actions);
  ::close(out[1]);
  ::close(err[1]);
  ::fcntl(out[0], F_SETFL, O_NONBLOCK);
  ::fcntl(err[0], F_SETFL, O_NONBLOCK);
  ProgramOutput output;
  auto end = std::chrono::steady_clock::now() + limits.time;
  pollfd ends[2] = {{out[0], POLLIN, 0}, {err[0], POLLIN, 0}};
  std::string* texts[2] = {&output.out, &output.err};
  int status = 0;
  bool ended = error != 0, cancelled = false;
  // A process that the program has started may keep the pipes open. So read until the program has ended, then only bytes already there.
  while (!ended) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
    if (left.count() <= 0 && !output.timed_out) {
      output.timed_out = true;
      ::kill(pid, SIGKILL);
    }
    if (!cancelled && limits.cancelled && limits.cancelled()) {
      cancelled = true;
      ::kill(pid, SIGTERM);  // a compiler then ends the programs that it has started
      end = std::chrono::steady_clock::now() + std::chrono::seconds(1);
    }
    const auto wait = std::clamp(left, std::chrono::milliseconds(1), look_period);
    (void)::poll(ends, 2, static_cast<int>(wait.count()));
    const pid_t got = ::waitpid(pid, &status, WNOHANG);
    ended = got == pid || (got < 0 && errno != EINTR);
    for (int i = 0; i < 2; ++i)
      if (ends[i].fd >= 0 && !drain(ends[i].fd, *texts[i])) ends[i].fd = -1;
  }
  ::close(out[0]);
  ::close(err[0]);
  if (error != 0)
    return fail(ErrorCode::io, arguments[0], std::string("The program cannot be started: ") + std::strerror(error) + ".",
                "Check that the program exists and may be executed.");
  if (cancelled) return fail(ErrorCode::cancelled, arguments[0], "Stopped.", "Run the command again.");
  output.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return output;
}

}  // namespace ugoki::plugin
