#include "ugoki/plugin/guard.h"

#include <pthread.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <span>
#include <thread>

#include "ugoki/base/shadow_memory.h"

namespace ugoki::plugin {
namespace {

constexpr int crash_status = 70;                        // exit status after last words (EX_SOFTWARE of sysexits.h)
constexpr std::chrono::milliseconds check_period{100};  // the watching thread notices a hang at most this long after the patience ended

int words_fd = -1;                           // where last words are written
std::atomic<bool> ended = false;             // one thread is writing last words already
char phase[256];                             // zero-terminated
std::atomic<std::uint64_t> phase_number{0};  // odd during a phase; increases with every change

/// Last words: three lines, "location\nmessage\nremedy\n". Allocates nothing, so that a signal handler may use it.
class Words {
 public:
  Words& operator<<(std::string_view text) {
    for (const char c : text)
      if (size_ < sizeof text_) text_[size_++] = c == '\n' ? ' ' : c;
    return *this;
  }
  void end_line() {
    if (size_ < sizeof text_) text_[size_++] = '\n';
  }
  /// The unused memory, for a describe function of circuit/activity.h; add() then states how much it used.
  std::span<char> room() { return {text_ + size_, sizeof text_ - size_}; }
  void add(std::size_t n) { size_ += n; }
  void send() const {
    for (std::size_t sent = 0; sent < size_;) {
      const ssize_t n = ::write(words_fd, text_ + sent, size_ - sent);
      if (n <= 0) return;
      sent += static_cast<std::size_t>(n);
    }
  }

 private:
  char text_[2048];
  std::size_t size_ = 0;
};

/// Writes last words and ends the process. @param what happened ("divided an integer by zero") @param running null: no LSI runs
[[noreturn]] void end_with(std::string_view what, const circuit::RunningLsi* running) {
  if (!ended.exchange(true)) {
    Words words;
    if (running) {
      words << running->id;
      words.end_line();
      words.add(describe_lsi(*running, words.room()));
      words << " " << what;
      words.add(describe_time(*running, words.room()));
      words << ".";
      words.add(describe_inputs(*running, words.room()));
    } else if (phase_number.load() % 2 == 1) {
      words << "library";
      words.end_line();
      words << phase << " when it " << what << ".";
    } else {
      words << "interpreter";
      words.end_line();
      words << "The interpreter " << what << " while no LSI was running.";
    }
    words.end_line();
    words << (running || phase_number.load() % 2 == 1 ? "Correct the LSI, rebuild it and restart the circuit."
                                                      : "This is a bug in Ugoki; report it together with the project.");
    words.send();
  }
  _exit(crash_status);
}

/// What a signal means, as the end of a sentence whose subject is the LSI.
std::string_view words_for(int signal, const siginfo_t* info) {
  switch (signal) {
    case SIGFPE: return info->si_code == FPE_INTDIV ? "divided an integer by zero" : "caused an arithmetic error (SIGFPE)";
    case SIGSEGV:
      // The first page (4096 bytes) is never mapped: an access there is a null pointer, perhaps with the offset of a field.
      return reinterpret_cast<std::uintptr_t>(info->si_addr) < 4096 ? "used a null pointer (SIGSEGV)"
                                                                    : "accessed memory that it does not own (SIGSEGV)";
    case SIGBUS: return "accessed memory that does not exist (SIGBUS)";
    case SIGILL: return "executed an invalid instruction (SIGILL)";
    case SIGABRT: return "aborted (SIGABRT)";
    default: return "was ended by a signal";
  }
}

void on_crash(int signal, siginfo_t* info, void*) { end_with(words_for(signal, info), running_of(process_activity())); }

void on_exit() {
  if (const circuit::RunningLsi* running = running_of(process_activity())) end_with("ended the process (exit)", running);
}

/// Body of the watching thread: ends the process when one call of an LSI, or one phase, takes longer than `patience`.
[[noreturn]] void watch(std::chrono::milliseconds patience) {
  const circuit::RunningLsi* last = nullptr;
  std::uint64_t last_pass = 0, last_phase = 0;
  auto since = std::chrono::steady_clock::now();
  while (true) {
    std::this_thread::sleep_for(check_period);
    const circuit::Activity& activity = process_activity();
    const circuit::RunningLsi* running = running_of(activity);
    const std::uint64_t pass = passes_of(activity), number = phase_number.load();
    const auto now = std::chrono::steady_clock::now();
    const bool busy = running || number % 2 == 1;
    if (!busy || running != last || pass != last_pass || number != last_phase) {
      last = running;
      last_pass = pass;
      last_phase = number;
      since = now;
    } else if (now - since > patience) {
      char what[96];
      std::snprintf(what, sizeof what, "did not return within %.1f s and was stopped", 1e-3 * static_cast<double>(patience.count()));
      end_with(what, running);
    }
  }
}

/// Limits this process to half of the machine's memory. An LSI that allocates without end then fails here and does not take the memory of
/// the studio, which holds the project. Has no effect under sanitizers, which reserve much more address space.
void limit_memory() {
  if (has_shadow_memory) return;
  const auto half = static_cast<rlim_t>(::sysconf(_SC_PHYS_PAGES)) / 2 * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE));
  rlimit limit{};
  if (::getrlimit(RLIMIT_DATA, &limit) != 0 || limit.rlim_cur <= half) return;
  limit.rlim_cur = half;
  (void)::setrlimit(RLIMIT_DATA, &limit);
}

}  // namespace

circuit::Activity& process_activity() {
  static circuit::Activity activity;
  return activity;
}

void set_phase(std::string_view what) {
  if (!what.empty()) {
    const std::size_t n = std::min(what.size(), sizeof phase - 1);
    std::memcpy(phase, what.data(), n);
    phase[n] = '\0';
  }
  const std::uint64_t now = phase_number.load();
  phase_number = (now + 2) / 2 * 2 + (what.empty() ? 0 : 1);
}

void guard_process(int fd, std::chrono::milliseconds patience) {
  words_fd = fd;
  limit_memory();
  static char stack[1 << 16];  // the handler runs on this stack, so that it also works after a stack overflow
  stack_t other{};
  other.ss_sp = stack;
  other.ss_size = sizeof stack;
  ::sigaltstack(&other, nullptr);
  struct sigaction action{};
  action.sa_sigaction = on_crash;
  action.sa_flags = SA_SIGINFO | SA_ONSTACK;
  sigemptyset(&action.sa_mask);
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) ::sigaction(signal, &action, nullptr);
  std::atexit(on_exit);
  // The watching thread blocks all signals, so that the main thread handles Ctrl+C.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  std::thread(watch, patience).detach();
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

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
  std::fflush(nullptr);
  const pid_t child = ::fork();
  if (child < 0) {
    ::close(ends[0]);
    ::close(ends[1]);
    return fail(ErrorCode::io, "interpreter", "The guarded process cannot be started.", "Close other programs.");
  }
  if (child == 0) {
    ::close(ends[0]);
    guard_process(ends[1], patience);
    const int status = work();
    std::fflush(nullptr);
    _exit(status);
  }
  ::close(ends[1]);
  struct sigaction ignore{}, before{};
  ignore.sa_handler = SIG_IGN;  // Ctrl+C reaches the child too, which then ends regularly
  ::sigaction(SIGINT, &ignore, &before);
  std::string words;
  char buffer[1024];
  for (ssize_t n; (n = ::read(ends[0], buffer, sizeof buffer)) != 0;) {
    if (n > 0)
      words.append(buffer, static_cast<std::size_t>(n));
    else if (errno != EINTR)
      break;
  }
  ::close(ends[0]);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  ::sigaction(SIGINT, &before, nullptr);
  if (words.empty() && WIFEXITED(status)) return WEXITSTATUS(status);
  std::string how = "ended early";
  if (WIFSIGNALED(status)) how = "was ended by signal " + std::to_string(WTERMSIG(status)) + " (" + strsignal(WTERMSIG(status)) + ")";
  return fail(read_last_words(words, how));
}

}  // namespace ugoki::plugin
