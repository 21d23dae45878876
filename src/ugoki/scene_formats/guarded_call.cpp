#include "ugoki/scene_formats/guarded_call.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <new>

#include "ugoki/base/shadow_memory.h"

namespace ugoki::scene_formats {
namespace {

constexpr int exit_done = 0, exit_no_memory = 77, exit_exception = 78;

/// Size of the address space of this process, bytes.
std::size_t own_size() {
  std::size_t pages = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "r")) {
    if (std::fscanf(file, "%zu", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

void set_limit(int resource, rlim_t value) {
  rlimit limit{value, value};
  (void)setrlimit(resource, &limit);
}

/// Writes all bytes. Returns false on error.
bool write_all(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(file, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
  return true;
}

/// Main function of the child process: runs the call, writes the answer and exits. It never returns into the copied stack of the caller.
[[noreturn]] void run_child(const std::function<std::string()>& call, int out, const GuardLimits& limits, std::size_t size) {
  (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
  for (const int number : {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT, SIGTERM, SIGINT, SIGPIPE, SIGALRM}) (void)signal(number, SIG_DFL);
  set_limit(RLIMIT_CORE, 0);
  set_limit(RLIMIT_FSIZE, 0);
  set_limit(RLIMIT_CPU, static_cast<rlim_t>(std::ceil(limits.seconds)) + 1);
  if (!has_shadow_memory) set_limit(RLIMIT_AS, size + limits.memory);
  try {
    const std::string answer = call();
    _exit(write_all(out, answer) ? exit_done : exit_exception);
  } catch (const std::bad_alloc&) {
    _exit(exit_no_memory);
  } catch (...) {
    _exit(exit_exception);
  }
}

/// Describes the end of the child process.
struct Outcome {
  bool in_time = true;       ///< true: it ended within the time limit
  bool within_limit = true;  ///< true: the answer did not exceed its maximum size
  int status = 0;            ///< exit status from waitpid()
};

/// Reads the child's answer to its end. If the limit of time or of size is exceeded, kills the child process instead.
Outcome collect(pid_t child, int in, const GuardLimits& limits, std::string& answer) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(limits.seconds));
  Outcome outcome;
  std::string buffer(1 << 16, '\0');
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
    if (left <= 0) {
      outcome.in_time = false;
      break;
    }
    pollfd wait{in, POLLIN, 0};
    const int ready = ::poll(&wait, 1, static_cast<int>(std::min<long long>(left, 1000)));
    if (ready < 0 && errno != EINTR) break;
    if (ready <= 0) continue;
    const ssize_t n = ::read(in, buffer.data(), buffer.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    answer.append(buffer, 0, static_cast<std::size_t>(n));
    if (answer.size() > limits.answer) {
      outcome.within_limit = false;
      break;
    }
  }
  if (!outcome.in_time || !outcome.within_limit) (void)kill(child, SIGKILL);
  while (waitpid(child, &outcome.status, 0) < 0 && errno == EINTR) {
  }
  return outcome;
}

}  // namespace

Result<std::string> call_guarded(const std::function<std::string()>& call, std::string_view location, const GuardLimits& limits) {
  const std::string at(location);
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0)
    return fail(ErrorCode::io, at,
                "No pipe could be created to read the file in a child process (" + std::string(std::strerror(errno)) + ").",
                "Close other programs and try again.");
  const std::size_t size = own_size();
  const pid_t child = ::fork();
  if (child < 0) {
    const std::string why = std::strerror(errno);
    ::close(ends[0]);
    ::close(ends[1]);
    return fail(ErrorCode::io, at, "No child process could be started to read the file (" + why + ").",
                "Close other programs and try again.");
  }
  if (child == 0) {
    ::close(ends[0]);
    run_child(call, ends[1], limits, size);
  }
  ::close(ends[1]);
  std::string answer;
  const Outcome outcome = collect(child, ends[0], limits, answer);
  ::close(ends[0]);
  if (!outcome.in_time || (WIFSIGNALED(outcome.status) && WTERMSIG(outcome.status) == SIGXCPU))
    return fail(ErrorCode::io, at,
                "Reading the file took longer than " + std::to_string(std::lround(limits.seconds)) + " s and was stopped.",
                "Export a shorter motion, or use another format (glTF, BVH).");
  if (!outcome.within_limit)
    return fail(ErrorCode::range, at, "The file has more motion than can be read at once.", "Export a shorter motion.");
  if (WIFEXITED(outcome.status) && WEXITSTATUS(outcome.status) == exit_done) return answer;
  if (WIFEXITED(outcome.status) && WEXITSTATUS(outcome.status) == exit_no_memory)
    return fail(ErrorCode::range, at,
                "Reading the file needs more memory than the limit of 4 GB; it is damaged or has much more than a skeleton.",
                "Export it again, with the skeleton and its motion only.");
  return fail(ErrorCode::syntax, at, "The library that reads this format crashed: the file is damaged or uses unusual features.",
              "Export it again, in another version of the format or as glTF or BVH.");
}

}  // namespace ugoki::scene_formats
