// Foreign code that crashes, hangs, writes outside of its memory or returns values that are not finite. Each case must give a message with
// the LSI, the pin and the time, and must not end the test process.

#include <chrono>
#include <thread>

#include "plugin_test.h"
#include "ugoki/plugin/guard.h"
#include "ugoki/plugin/shelf.h"

namespace ugoki::plugin {
namespace {

// Functions that fail at the tick at 0.02 s; their input is the time.
const char* const bad = R"(#include <stdlib.h>
#include <math.h>
/// @library bad
int quotient(int a, int b) { return a / b; }
double null(double x) { return x > 0.015 ? *(volatile double*)0 : x; }
double forever(double x) { while (x > 0.015) { __asm__ volatile(""); } return x; }
double nan_after(double x) { return x > 0.015 ? NAN : x; }
double gives_up(double x) { if (x > 0.015) abort(); return x; }
double leaves(double x) { if (x > 0.015) exit(0); return x; }
static double deep(double x) { volatile char room[100000]; room[0] = (char)x; return deep(x + room[0]) + room[0]; }
double recurses(double x) { return x > 0.015 ? deep(x) : x; }
double far_beyond(double x, double y[3]) { for (int i = 0; i < (x > 0.015 ? 400000000 : 3); ++i) y[i] = x; return x; }
double beyond(double x, double y[3]) { int i = x > 0.015 ? 3 : 0; y[i] = x; return x; }
void before(double x, double y[3]) { int i = x > 0.015 ? -1 : 0; y[i] = x; }
struct memory { double past[4]; };
double forgets(struct memory* m, double x) { int i = x > 0.015 ? 4 : 0; m->past[i] = x; return x; }
double wild(double x) { if (x > 0.015) *(volatile double*)0x7fff00000000ull = x; return x; }
)";

class CrashTest : public PluginTest {
 protected:
  void SetUp() override {
    PluginTest::SetUp();
    library_ = build("bad.c", bad);
  }
  /// Runs the LSI for 10 ticks of 10 ms in a guarded process; its input is the time. @return the error message, or "status N"
  std::string run(const std::string& lsi, const std::string& input, const std::string& other = {}) {
    const Result<int> done = run_guarded(
        [&] {
          LiveLibrary live(signals_, {}, {library_});
          auto i = circuit::Interpreter::build(
              *circuit::read_circuit(R"({"version": 1, "name": "t", "lsis": [{"id": "c", "type": "clock"}, {"id": "lsi-x", "type": "bad/)" +
                                     lsi + "\"" + other + R"(}], "wires": [{"from": "c.time", "to": "lsi-x.)" + input + R"("}]})"),
              *live.library(), nullptr, {.dt = 0.01, .check_finite = true, .activity = &process_activity()});
          if (!i) {
            fputs(i.error().text().c_str(), stderr);
            return 3;
          }
          for (int k = 0; k < 10; ++k)
            if (!i->tick()) {
              reported_ = i->stopped()->text();
              return reported_ ==
                             "'lsi-x' of library 'bad' stopped at 0.020 s (tick 2): Number 0 of its output 'out' is "
                             "not finite. Its inputs were 'x' = 0.02."
                         ? 42
                         : 43;
            }
          return 0;
        },
        std::chrono::milliseconds(600));
    return done ? "status " + std::to_string(*done) : done.error().text();
  }
  /// Expects that the message names the LSI, what happened, the time and the inputs.
  void expect_named(const std::string& reported, const std::string& what, const std::string& lsi) {
    EXPECT_NE(reported.find("'lsi-x' (LSI 'bad/" + lsi + "' of library 'bad')"), std::string::npos) << reported;
    EXPECT_NE(reported.find(what), std::string::npos) << reported;
    EXPECT_NE(reported.find(" at 0.020 s (tick 2). Its inputs were 'x' = 0.02."), std::string::npos) << reported;
  }
  std::string library_, reported_;
};

TEST_F(CrashTest, IntegerDivisionByZeroIsReported) {
  const std::string reported = run("quotient", "a", R"(, "values": {"b": 0})");
  EXPECT_NE(reported.find("'lsi-x' (LSI 'bad/quotient' of library 'bad') divided an integer by zero at 0.000 s (tick 0). Its inputs were "
                          "'a' = 0, 'b' = 0."),
            std::string::npos)
      << reported;
}
TEST_F(CrashTest, NullPointerIsReported) { expect_named(run("null", "x"), "used a null pointer", "null"); }
TEST_F(CrashTest, WildPointerIsReported) { expect_named(run("wild", "x"), "accessed memory that it does not own", "wild"); }
TEST_F(CrashTest, WriteFarBeyondAnOutputIsReported) {
  expect_named(run("far_beyond", "x"), "accessed memory that it does not own", "far_beyond");
}
TEST_F(CrashTest, WriteJustOutsideOwnMemoryStopsTheCircuit) {
  const std::pair<const char*, const char*> cases[] = {{"beyond", "It wrote beyond its output 'y', which has 3 numbers."},
                                                       {"before", "It wrote in front of its outputs."},
                                                       {"forgets", "It wrote beyond its state of 32 bytes."}};
  LiveLibrary live(signals_, {}, {library_});
  for (const auto& [lsi, sentence] : cases) {
    auto i = circuit::Interpreter::build(
        *circuit::read_circuit(R"({"version": 1, "name": "t", "lsis": [{"id": "c", "type": "clock"}, {"id": "it", "type": "bad/)" +
                               std::string(lsi) + R"("}], "wires": [{"from": "c.time", "to": "it.x"}]})"),
        *live.library(), nullptr, {.dt = 0.01});
    ASSERT_TRUE(i) << i.error().text();
    for (int round = 0; round < 2; ++round, i->reset()) {
      EXPECT_TRUE(i->tick() && i->tick());
      EXPECT_FALSE(i->tick()) << lsi;
      ASSERT_NE(i->stopped(), nullptr);
      EXPECT_EQ(i->stopped()->text(), std::string("'it' of library 'bad' stopped at 0.020 s (tick 2): ") + sentence);
    }
  }
}
TEST_F(CrashTest, ExceptionOfAPlainFunctionStopsTheCircuitWithItsText) {
  const std::string path =
      build("throws.cpp", "#include <stdexcept>\ndouble f(double x) { if (x > 0.015) throw std::runtime_error(\"No rope\"); return x; }\n");
  LiveLibrary live(signals_, {}, {path});
  auto i = circuit::Interpreter::build(
      *circuit::read_circuit(R"({"version": 1, "name": "t", "lsis": [{"id": "c", "type": "clock"}, {"id": "it", "type": "throws/f"}],
                                 "wires": [{"from": "c.time", "to": "it.x"}]})"),
      *live.library(), nullptr, {.dt = 0.01});
  ASSERT_TRUE(i) << i.error().text();
  EXPECT_EQ(i->run(5), 2u);
  EXPECT_EQ(i->stopped()->text(), "'it' of library 'throws' stopped at 0.020 s (tick 2): No rope. Its inputs were 'x' = 0.02.");
}
TEST_F(CrashTest, InfiniteLoopIsReported) { expect_named(run("forever", "x"), "did not return within 0.6 s and was stopped", "forever"); }
TEST_F(CrashTest, AbortIsReported) { expect_named(run("gives_up", "x"), "aborted", "gives_up"); }
TEST_F(CrashTest, ExitIsReported) { expect_named(run("leaves", "x"), "ended the process", "leaves"); }
TEST_F(CrashTest, InfiniteRecursionIsReported) { expect_named(run("recurses", "x"), "accessed memory that it does not own", "recurses"); }
TEST_F(CrashTest, NotANumberNamesThePin) { EXPECT_EQ(run("nan_after", "x"), "status 42"); }

TEST_F(CrashTest, LibraryThatHangsOrCrashesWhileLoadingIsReported) {
  for (const char* body : {"for (;;) __asm__ volatile(\"\");", "*(volatile int*)0 = 1;"}) {
    const std::string path = build(
        "early.c", std::string("__attribute__((constructor)) static void early(void) { ") + body + " }\ndouble f(double x) { return x; }");
    const Result<int> done = run_guarded(
        [&] {
          LiveLibrary live(signals_, {}, {path});
          return 0;
        },
        std::chrono::milliseconds(500));
    ASSERT_FALSE(done);
    EXPECT_NE(done.error().text().find("The library 'early.so' was being loaded when it "), std::string::npos) << done.error().text();
  }
}

TEST_F(CrashTest, LongRunsAndIdleTimeAreNotHangs) {
  // Many short ticks, which together take longer than the time limit of 250 ms for a hang.
  const Result<int> done = run_guarded(
      [&] {
        LiveLibrary live(signals_, {}, {library_});
        auto i = circuit::Interpreter::build(
            *circuit::read_circuit(
                R"({"version": 1, "name": "t", "lsis": [{"id": "q", "type": "bad/quotient", "values": {"a": 1, "b": 1}}]})"),
            *live.library(), nullptr, {.dt = 0.01, .check_finite = true, .activity = &process_activity()});
        const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(500);
        while (std::chrono::steady_clock::now() < end)
          if (!i->tick()) return 1;
        std::this_thread::sleep_for(std::chrono::milliseconds(400));  // idle time is not a hang either
        return 0;
      },
      std::chrono::milliseconds(250));
  ASSERT_TRUE(done) << done.error().text();
  EXPECT_EQ(*done, 0);
}

}  // namespace
}  // namespace ugoki::plugin
