#include "ugoki/plugin/guard.h"

#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <sys/resource.h>
#include <ucontext.h>
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
#include "ugoki/plugin/guard_block.h"
#include "ugoki/plugin/signal_filter.h"

namespace ugoki::plugin {
namespace {

constexpr int crash_status = 70;                        // exit status after the crash report (EX_SOFTWARE of sysexits.h)
constexpr std::chrono::milliseconds check_period{100};  // a hang is noticed at most this long after the time limit `patience`

int words_fd = -1;                   // file descriptor that receives the crash report ("last words"); -1: none
std::atomic<bool> ended = false;     // true: a thread has begun to write the crash report
pid_t main_thread = 0;               // id of the thread that runs the LSIs
std::FILE* result_stream = nullptr;  // stream returned by results(); null: stdout

/// Address range of the code of a loaded library, for crash reports.
struct CodeRange {
  std::atomic<std::uintptr_t> begin{0}, end{0};  // first address and end address; both 0: the entry is not in use
  char name[100];                                // name of the library, zero-terminated
};
CodeRange code_ranges[256];  // one for each loaded library; further libraries run without an entry

/// Text of a crash report ("last words"): three lines, "location\nmessage\nremedy\n". Allocates nothing, so that a signal handler may
/// use it.
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
  /// The unused bytes, into which a describe function of circuit/activity.h writes. Then pass the count of written bytes to add().
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

/// Sends the crash report ("last words") and ends the process. Only the first thread that calls this function sends a report.
template <class Fill>
[[noreturn]] void end_with_words(Fill fill) {
  if (!ended.exchange(true)) {
    Words words;
    fill(words);
    words.send();
  }
  _exit(crash_status);
}

constexpr std::string_view remedy = "Correct the LSI, rebuild it and restart the circuit.";

/// Writes the crash report and ends the process. @param what cause ("divided an integer by zero") @param running LSI; null: none runs
[[noreturn]] void end_with(std::string_view what, const circuit::RunningLsi* running) {
  end_with_words([&](Words& words) {
    const GuardBlock& block = guard_block();
    if (running) {
      words << running->id;
      words.end_line();
      words.add(describe_lsi(*running, words.room()));
      words << " " << what;
      words.add(describe_time(*running, words.room()));
      words << ".";
      words.add(describe_inputs(*running, words.room()));
    } else if (block.phase_number.load() % 2 == 1) {
      words << "library";
      words.end_line();
      words << block.phase << " when it " << what << ".";
    } else {
      words << "interpreter";
      words.end_line();
      words << "The interpreter " << what << " while no LSI was running.";
      char known[1024];
      const std::string_view names(known, describe_known_lsis(guard_block(), known, sizeof known));
      if (names.empty()) {
        words.end_line();
        words << "This is a bug in Ugoki; report it together with the project.";
        return;
      }
      words << " One of these LSIs of libraries probably damaged the memory: " << names << ".";
    }
    words.end_line();
    words << remedy;
  });
}

/// Writes the report of a crash that happened outside the main thread, and ends the process. @param address where the code crashed
[[noreturn]] void end_with_thread(std::string_view what, std::uintptr_t address) {
  end_with_words([&](Words& words) {
    words << "library";
    words.end_line();
    const CodeRange* owner = nullptr;
    for (const CodeRange& range : code_ranges)
      if (range.begin <= address && address < range.end) owner = &range;
    if (owner) {
      words << "A thread of the library '" << owner->name << "' " << what << ".";
    } else {
      char known[1024];
      const std::string_view names(known, describe_known_lsis(guard_block(), known, sizeof known));
      words << "A thread " << what << ".";
      if (!names.empty()) words << " It was probably started by one of these LSIs of libraries: " << names << ".";
    }
    words.end_line();
    words << "LSIs must not start threads that outlive their call. " << remedy;
  });
}

/// Address of the instruction at which a signal was raised; 0: unknown.
std::uintptr_t instruction_of(const void* context) {
  const auto* c = static_cast<const ucontext_t*>(context);
#if defined(__x86_64__)
  return static_cast<std::uintptr_t>(c->uc_mcontext.gregs[REG_RIP]);
#elif defined(__aarch64__)
  return static_cast<std::uintptr_t>(c->uc_mcontext.pc);
#else
  (void)c;
  return 0;
#endif
}

/// Description of a signal, as the end of a sentence whose subject is the LSI.
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
    case SIGSYS: return "tried to send a signal to the process of Ugoki that runs it (kill)";  // raised by forbid_signals_to_parent()
    default: return "was ended by a signal";
  }
}

void on_crash(int signal, siginfo_t* info, void* context) {
  if (::gettid() != main_thread) end_with_thread(words_for(signal, info), instruction_of(context));
  end_with(words_for(signal, info), running_of(process_activity()));
}

void on_exit() {
  if (const circuit::RunningLsi* running = running_of(process_activity())) end_with("ended the process (exit)", running);
}

/// True if the main thread has ended while the process continues. This is the effect of pthread_exit.
bool main_thread_ended() {
  char path[48], text[256];
  std::snprintf(path, sizeof path, "/proc/self/task/%d/stat", static_cast<int>(main_thread));
  const int fd = ::open(path, O_RDONLY | O_CLOEXEC);
  if (fd < 0) return false;  // not known, because an LSI closed or used up the file descriptors
  const ssize_t n = ::read(fd, text, sizeof text);
  ::close(fd);
  const std::string_view stat(text, n > 0 ? static_cast<std::size_t>(n) : 0);  // has the form "PID (NAME) STATE ..."
  const std::size_t end = stat.rfind(") ");
  return end != std::string_view::npos && end + 2 < stat.size() && (stat[end + 2] == 'Z' || stat[end + 2] == 'X');
}

/// Writes the crash report after the end of the main thread, and ends the process. The end of the thread has run the destructors of the
/// interpreter, so the LSI may be unknown.
[[noreturn]] void end_without_main_thread() {
  constexpr std::string_view what = "ended the main thread of its process (pthread_exit)";
  if (const circuit::RunningLsi* running = running_of(process_activity())) end_with(what, running);
  end_with_words([&](Words& words) {
    char known[1024];
    const std::string_view names(known, describe_known_lsis(guard_block(), known, sizeof known));
    words << "interpreter";
    words.end_line();
    words << "An LSI " << what << ".";
    if (!names.empty()) words << " It is one of these LSIs of libraries: " << names << ".";
    words.end_line();
    words << remedy;
  });
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
    const std::uint64_t pass = passes_of(activity), number = guard_block().phase_number.load();
    const auto now = std::chrono::steady_clock::now();
    if (main_thread_ended()) end_without_main_thread();
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

circuit::Activity& process_activity() { return guard_block().activity; }

void set_phase(std::string_view what) {
  GuardBlock& block = guard_block();
  if (!what.empty()) {
    const std::size_t n = std::min(what.size(), sizeof block.phase - 1);
    std::memcpy(block.phase, what.data(), n);
    block.phase[n] = '\0';
  }
  const std::uint64_t now = block.phase_number.load();
  block.phase_number = (now + 2) / 2 * 2 + (what.empty() ? 0 : 1);
}

void note_code(std::string_view name, std::uintptr_t begin, std::uintptr_t end) {
  for (CodeRange& range : code_ranges) {
    if (range.end != 0) continue;
    const std::size_t n = std::min(name.size(), sizeof range.name - 1);
    std::memcpy(range.name, name.data(), n);
    range.name[n] = '\0';
    range.begin = begin;
    range.end = end;
    return;
  }
}

void forget_code(std::uintptr_t begin) {
  for (CodeRange& range : code_ranges)
    if (range.begin == begin) range.begin = range.end = 0;
}

std::FILE* results() { return result_stream ? result_stream : stdout; }

/// Runs in a copy of this process that an LSI has made with fork. The copy must not write results or reports, which would appear twice.
void silence_copy() {
  const int nothing = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (nothing < 0) return;
  if (result_stream) ::dup2(nothing, ::fileno(result_stream));
  if (words_fd >= 0) ::dup2(nothing, words_fd);
  ::close(nothing);
}

void keep_results_apart() {
  std::fflush(stdout);
  const int copy = ::fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 3);
  if (copy < 0) return;
  result_stream = ::fdopen(copy, "w");
  if (result_stream) ::dup2(STDERR_FILENO, STDOUT_FILENO);
}

void guard_process(int fd, std::chrono::milliseconds patience) {
  words_fd = fd;
  ::pthread_atfork(nullptr, nullptr, silence_copy);
  main_thread = ::gettid();
  (void)guard_block();
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
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGSYS}) ::sigaction(signal, &action, nullptr);
  std::atexit(on_exit);
  (void)forbid_signals_to_parent();
  // The watching thread blocks all signals, so that the main thread handles Ctrl+C.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  std::thread(watch, patience).detach();
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

}  // namespace ugoki::plugin
