#include "program.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>

namespace ugoki::cli {
namespace {

pid_t start(const std::vector<std::string>& arguments, const std::vector<std::string>& environment, int out, int err) {
  const pid_t child = ::fork();
  if (child != 0) return child;
  ::dup2(out, STDOUT_FILENO);
  ::dup2(err, STDERR_FILENO);
  for (const std::string& line : environment) ::putenv(const_cast<char*>(line.c_str()));
  std::vector<char*> argv = {const_cast<char*>(UGOKI_PROGRAM)};
  for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  ::execv(UGOKI_PROGRAM, argv.data());
  ::_exit(126);
}

}  // namespace

int wait_for(pid_t child) {
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

pid_t start_program(const std::vector<std::string>& arguments, const std::vector<std::string>& environment) {
  const int null = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  const pid_t child = start(arguments, environment, null, null);
  ::close(null);
  return child;
}

Output run_program(const std::vector<std::string>& arguments, const std::vector<std::string>& environment) {
  int out[2], err[2];
  Output output;
  if (::pipe2(out, O_CLOEXEC) != 0 || ::pipe2(err, O_CLOEXEC) != 0) return output;
  const pid_t child = start(arguments, environment, out[1], err[1]);
  ::close(out[1]);
  ::close(err[1]);
  pollfd ends[2] = {{out[0], POLLIN, 0}, {err[0], POLLIN, 0}};
  std::string* texts[2] = {&output.out, &output.err};
  for (int open = 2; open > 0;) {
    ::poll(ends, 2, -1);
    for (int i = 0; i < 2; ++i) {
      if (ends[i].fd < 0 || ends[i].revents == 0) continue;
      char buffer[4096];
      const ssize_t n = ::read(ends[i].fd, buffer, sizeof buffer);
      if (n > 0) {
        texts[i]->append(buffer, static_cast<std::size_t>(n));
      } else {
        ::close(ends[i].fd);
        ends[i].fd = -1;
        --open;
      }
    }
  }
  output.status = wait_for(child);
  return output;
}

}  // namespace ugoki::cli
