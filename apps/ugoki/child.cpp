#include "child.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>

#include "output.h"
#include "ugoki/files/environment.h"
#include "ugoki/files/files.h"

namespace ugoki::cli {

namespace fs = std::filesystem;

namespace {
constexpr int pipe_size = 1 << 20;  // bytes: a sixteenth of the system calls of a usual pipe
}

Result<std::string> find_program(const std::string& given, std::initializer_list<const char*> names, const char* remedy) {
  if (!given.empty()) {
    if (::access(given.c_str(), X_OK) == 0) return given;
    return fail(ErrorCode::io, given, "This program does not exist or may not be run.", "Name an executable file.");
  }
  const char* path = std::getenv("PATH");
  for (const char* name : names) {
    std::string_view rest = path ? path : "/usr/bin:/bin";
    while (!rest.empty()) {
      const std::string folder(rest.substr(0, rest.find(':')));
      rest.remove_prefix(std::min(rest.size(), folder.size() + 1));
      const std::string file = folder + '/' + name;
      if (::access(file.c_str(), X_OK) == 0) return file;
    }
  }
  return fail(ErrorCode::io, *names.begin(), "The program was not found.", remedy);
}

Result<std::unique_ptr<Child>> Child::start(const std::vector<std::string>& words, bool pipe_input, const std::string& log,
                                            const std::vector<std::pair<const char*, std::string>>& variables) {
  int ends[2] = {-1, -1};
  if (pipe_input && ::pipe2(ends, O_CLOEXEC) != 0)
    return fail(ErrorCode::io, words[0], "No pipe to the program can be made.", "Close other programs.");
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  if (pipe_input)
    posix_spawn_file_actions_adddup2(&actions, ends[0], STDIN_FILENO);
  else
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  posix_spawn_file_actions_addclosefrom_np(&actions, 3);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setpgroup(&attributes, 0);  // Ctrl+C does not reach the child; this program ends the child
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  auto child = std::make_unique<Child>();
  files::Environment environment;
  for (const auto& [name, value] : variables) environment.set(name, value);
  const int status = ::posix_spawn(&child->pid_, words[0].c_str(), &actions, &attributes, arguments.data(), environment.pointers());
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (ends[0] >= 0) ::close(ends[0]);
  if (ends[1] >= 0) ::fcntl(ends[1], F_SETPIPE_SZ, pipe_size);  // the program also runs with the smaller pipe, only slower
  child->input_ = ends[1];
  if (status != 0) {
    child->pid_ = -1;
    return fail(ErrorCode::io, words[0], std::string("The program cannot be started: ") + std::strerror(status) + ".",
                "Check the program.");
  }
  return child;
}
Child::~Child() {
  close_input();
  if (pid_ < 0) return;
  ::kill(-pid_, SIGTERM);
  for (int i = 0; i < 50 && !ended(); ++i) ::usleep(20'000);
  if (pid_ < 0) return;
  ::kill(-pid_, SIGKILL);
  while (::waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

bool Child::write(std::string_view bytes) const {
  while (!bytes.empty()) {
    const ssize_t n = ::write(input_, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
  return true;
}
void Child::close_input() {
  if (input_ >= 0) ::close(input_);
  input_ = -1;
}
bool Child::ended() {
  int status = 0;
  if (pid_ >= 0 && ::waitpid(pid_, &status, WNOHANG) == pid_) {
    status_ = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    pid_ = -1;
  }
  return pid_ < 0;
}
bool Child::wait() {
  close_input();
  while (!ended() && !interrupted()) ::usleep(5'000);
  return pid_ < 0 && status_ == 0;
}

std::string tail_of(const fs::path& log) {
  const Result<std::string> text = files::read_file(log.string());
  if (!text || text->empty()) return "";
  const std::string end = text->substr(text->size() > 400 ? text->size() - 400 : 0);
  std::string line = end.substr(0, end.find_last_not_of("\n") + 1);
  std::ranges::replace(line, '\n', ' ');  // a message is one line
  return " It printed: " + line;
}

}  // namespace ugoki::cli
