// Foreign code that ends, stops or damages the guarded process without a crash report of its own. Each case must be an error that names the
// LSI, and must not hang the parent.

#include <signal.h>
#include <unistd.h>

#include <chrono>

#include "plugin_test.h"
#include "ugoki/plugin/guard.h"
#include "ugoki/plugin/guard_block.h"
#include "ugoki/plugin/run_program.h"

namespace ugoki::plugin {
namespace {

const char* const bad = R"(#define _GNU_SOURCE
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <unistd.h>
/// @library bad
double quits(double x) { _exit(0); return x; }
double closes(double x) { for (int i = 0; i < 1024; ++i) close(i); return x; }
double stops(double x) { raise(SIGSTOP); return x; }
double killed(double x) { raise(SIGKILL); return x; }
double forks(double x) { if (fork() == 0) { if (fork() == 0) sleep(1000); sleep(1000); _exit(0); } return x; }
static void* fault(void* p) { *(volatile int*)0 = 1; return p; }
double threads(double x) { pthread_t t; pthread_create(&t, 0, fault, 0); return x; }
double joined(double x) { pthread_t t; pthread_create(&t, 0, fault, 0); pthread_join(t, 0); return x; }
double signals_parent(double x) { kill(getppid(), SIGUSR1); return x; }
double tests_parent(double x) { return kill(getppid(), 0) == 0 ? x : 0 / x; }
double fine(double x) { return x; }
)";

class GuardTest : public PluginTest {
 protected:
  /// Runs the LSI for 3 ticks in a guarded process, which then allocates memory and waits `wait_ms`. @return the error, or "status N"
  std::string run(const std::string& lsi, int wait_ms = 0) {
    if (library_.empty()) library_ = build("bad.c", bad);
    const Result<int> done = run_guarded(
        [&] {
          LiveLibrary live(signals_, {}, {library_});
          auto i = circuit::Interpreter::build(*circuit::read_circuit(R"({"version": 1, "name": "t", "lsis": [{"id": "it", "type": "bad/)" +
                                                                      lsi + R"(", "values": {"x": 1}}]})"),
                                               *live.library(), nullptr, {.dt = 0.01, .activity = &process_activity()});
          if (!i) return 3;
          for (int k = 0; k < 3; ++k)
            if (!i->tick()) return 4;
          for (std::size_t k = 1; k < 200; ++k) free(malloc(100 * k));
          ::usleep(static_cast<useconds_t>(1000 * wait_ms));
          return 5;
        },
        std::chrono::milliseconds(600));
    return done ? "status " + std::to_string(*done) : done.error().text();
  }
  static void expect_part(const std::string& reported, const std::string& part) {
    EXPECT_NE(reported.find(part), std::string::npos) << reported;
  }
  std::string library_;
};

TEST_F(GuardTest, StatusOfWorkIsReturned) { EXPECT_EQ(run("fine"), "status 5"); }
TEST_F(GuardTest, EndWithStatusZeroIsAnError) {
  expect_part(run("quits"), "it: 'it' (LSI 'bad/quits' of library 'bad') ended its process (exit status 0) without a report.");
}
TEST_F(GuardTest, KilledProcessNamesTheLsi) {
  expect_part(run("killed"), "'it' (LSI 'bad/killed' of library 'bad') ended its process (signal 9, Killed) without a report.");
}
TEST_F(GuardTest, SignalToTheParentNamesTheLsiAndIsNotDelivered) {
  static volatile sig_atomic_t received = 0;
  received = 0;
  ::signal(SIGUSR1, [](int) { received = 1; });
  expect_part(
      run("signals_parent"),
      "'it' (LSI 'bad/signals_parent' of library 'bad') tried to send a signal to the process of Ugoki that runs it (kill) at 0.000 s");
  EXPECT_EQ(received, 0);
  EXPECT_EQ(run("tests_parent"), "status 5") << "a test for existence is not a signal";
  ::signal(SIGUSR1, SIG_DFL);
}
TEST_F(GuardTest, ClosedDescriptorsAreAnErrorThatNamesTheLsi) {
  const std::string reported = run("closes");
  expect_part(reported, "without a report");
  expect_part(reported, "'it' (LSI 'bad/closes' of library 'bad')");
}
TEST_F(GuardTest, StoppedProcessIsReportedAfterThePatience) {
  expect_part(run("stops"), "'it' (LSI 'bad/stops' of library 'bad') stopped its process (SIGSTOP), which did not continue within 0.6 s");
}
TEST_F(GuardTest, ForkedSleepersAreEndedAndDoNotHang) {
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);  // each process that was started has a copy of its writing end
  EXPECT_EQ(run("forks"), "status 5");
  ::close(ends[1]);
  char c;
  EXPECT_EQ(::read(ends[0], &c, 1), 0);  // end of file: no process has the writing end open
  ::close(ends[0]);
}
TEST_F(GuardTest, CrashInAThreadNamesTheLibrary) {
  expect_part(run("threads", 2000), "A thread of the library 'bad' used a null pointer (SIGSEGV).");
  expect_part(run("joined"), "A thread of the library 'bad' used a null pointer (SIGSEGV).");
}

TEST_F(GuardTest, SuspectedLsisAreListedOnceWithTheNumberOfFurtherOnes) {
  const std::string library = build("bad.c", bad);
  LiveLibrary live(signals_, {}, {library});
  clear_guard_block();
  const auto circuit_of = [](int count) {
    std::string lsis;
    for (int i = 0; i < count; ++i)
      lsis += std::string(i > 0 ? "," : "") + R"({"id": "l)" + std::to_string(i) + R"(", "type": "bad/fine", "values": {"x": 1}})";
    return *circuit::read_circuit(R"({"version": 1, "name": "t", "lsis": [)" + lsis + "]}");
  };
  const auto known = [] {
    char text[1024];
    return std::string(text, describe_known_lsis(guard_block(), text, sizeof text));
  };
  const std::string one = "'l0' (LSI 'bad/fine' of library 'bad')";
  std::vector<circuit::Interpreter> kept;  // a rebuilt circuit has its LSIs at other addresses
  for (int i = 0; i < 3; ++i)
    kept.push_back(
        std::move(*circuit::Interpreter::build(circuit_of(1), *live.library(), nullptr, {.dt = 0.01, .activity = &process_activity()})));
  EXPECT_EQ(known(), one);
  kept.push_back(
      std::move(*circuit::Interpreter::build(circuit_of(7), *live.library(), nullptr, {.dt = 0.01, .activity = &process_activity()})));
  EXPECT_TRUE(known().starts_with(one + ", 'l1'")) << known();
  EXPECT_TRUE(known().ends_with("'l3' (LSI 'bad/fine' of library 'bad') and 3 more")) << known();
}

TEST(RunProgram, ProcessThatKeepsThePipesOpenDoesNotHang) {
  const auto begin = std::chrono::steady_clock::now();
  const Result<ProgramOutput> ran = run_program({"sh", "-c", "sleep 60 & echo done"}, {std::chrono::seconds(50)});
  ASSERT_TRUE(ran);
  EXPECT_EQ(ran->status, 0);
  EXPECT_FALSE(ran->timed_out);
  EXPECT_EQ(ran->out, "done\n");
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(40));
}

TEST(RunProgram, CancelledProgramEnds) {
  const auto begin = std::chrono::steady_clock::now();
  const Result<ProgramOutput> ran = run_program({"sleep", "60"}, {std::chrono::seconds(50), "", [] { return true; }});
  ASSERT_FALSE(ran);
  EXPECT_EQ(ran.error().problems.front().code, ErrorCode::cancelled);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(40));
}

TEST(RunProgram, TemporaryFolderIsPassedOn) {
  const Result<ProgramOutput> ran = run_program({"sh", "-c", "echo $TMPDIR"}, {std::chrono::seconds(50), "/somewhere"});
  ASSERT_TRUE(ran);
  EXPECT_EQ(ran->out, "/somewhere\n");
}

}  // namespace
}  // namespace ugoki::plugin
