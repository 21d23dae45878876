#include "ugoki/studio/interpreter_process.h"

#include <gtest/gtest.h>

#include <condition_variable>
#include <csignal>
#include <deque>
#include <mutex>
#include <nlohmann/json.hpp>

#include "fake_simulation.h"
#include "ugoki/content/display_frame.h"
#include "ugoki/studio/interpreter_child.h"
#include "ugoki/studio/player_simulation.h"

namespace ugoki::studio {
namespace {

using nlohmann::json;
using test::Frame;

/// Collects frames, messages and the end of the interpreter's process.
class Listener {
 public:
  InterpreterEvents events() {
    return {[this](std::vector<std::byte> f) {
              const std::scoped_lock lock(mutex);
              frames.push_back(test::parse_frame(f));
              changed.notify_all();
            },
            [this](std::string m) {
              const std::scoped_lock lock(mutex);
              messages.push_back(json::parse(m));
              changed.notify_all();
            },
            [this](Problem why) {
              const std::scoped_lock lock(mutex);
              reason = why.message + " " + why.remedy;
              location = why.location;
              changed.notify_all();
            }};
  }
  /// Waits up to 30 s until `fits()` is true.
  template <class Fits>
  bool wait(Fits fits) {
    std::unique_lock lock(mutex);
    return changed.wait_for(lock, std::chrono::seconds(30), fits);
  }
  json reply(int id) {
    json found;
    wait([&] {
      for (const json& m : messages) {
        if (m.value("reply", -1) == id) found = m;
      }
      return !found.is_null();
    });
    return found;
  }

  std::mutex mutex;
  std::condition_variable changed;
  std::vector<Frame> frames;
  std::vector<json> messages;
  std::string reason, location;
};

class ProcessTest : public testing::Test {
 protected:
  void start() {
    Result<std::unique_ptr<InterpreterProcess>> started =
        InterpreterProcess::start({"/proc/self/exe", {"interpret-fake"}}, listener.events());
    ASSERT_TRUE(started) << started.error().text();
    process = std::move(*started);
  }
  json ask(json request, const std::string& block = "") {
    request["request"] = ++last;
    EXPECT_TRUE(process->send(request.dump(), std::as_bytes(std::span(block.data(), block.size()))));
    return listener.reply(last);
  }
  json load(const std::string& more = "") {
    return ask({{"op", "load"}}, R"({"step":0.002,"duration":100,"rate":60,"cast":[{"id":"a","links":3}])" + more + "}");
  }

  Listener listener;
  std::unique_ptr<InterpreterProcess> process;
  int last = 0;
};

TEST_F(ProcessTest, PlaysAt60FramesPerSecondThroughSharedMemory) {
  start();
  ASSERT_TRUE(load()["ok"]);
  ASSERT_TRUE(ask({{"op", "mode"}, {"mode", "simulate"}})["ok"]);
  ASSERT_TRUE(ask({{"op", "play"}})["ok"]);
  ASSERT_TRUE(listener.wait([&] { return !listener.frames.empty() && listener.frames.back().time >= 1.5; }));
  ASSERT_TRUE(ask({{"op", "pause"}})["ok"]);
  const std::scoped_lock lock(listener.mutex);
  std::size_t playing = 0;
  for (const Frame& f : listener.frames) {
    EXPECT_TRUE(f.good);
    if ((f.flags & content::frame_playing) != 0) ++playing;
  }
  EXPECT_GE(static_cast<double>(playing), 50 * 1.5);  // at least 50 frames for each second of content
}

TEST_F(ProcessTest, RejectedRequestsAreAnswered) {
  start();
  const json before = ask({{"op", "play"}});
  EXPECT_FALSE(before["ok"]);
  EXPECT_NE(before["error"]["problems"][0]["message"], "");
  EXPECT_FALSE(ask({{"op", "load"}}, "garbage")["ok"]);
  EXPECT_FALSE(ask({{"op", "nonsense"}})["ok"]);
  ASSERT_TRUE(load()["ok"]);
  ASSERT_TRUE(ask({{"op", "mode"}, {"mode", "simulate"}})["ok"]);
  EXPECT_FALSE(ask({{"op", "grab"}, {"character", "z"}, {"link", "0"}, {"point", {0, 0, 0}}, {"target", {0, 0, 0}}})["ok"]);
  EXPECT_TRUE(ask({{"op", "grab"}, {"character", "a"}, {"link", "chest"}, {"point", {0, 0, 0}}, {"target", {1, 0, 0}}})["ok"]);
  EXPECT_TRUE(process->send("not json"));
  EXPECT_TRUE(process->send("[1,2]"));
  EXPECT_TRUE(ask({{"op", "ping"}})["ok"]);
}

TEST_F(ProcessTest, KilledChildIsReportedWithSignal) {
  start();
  ASSERT_TRUE(load()["ok"]);
  ASSERT_EQ(::kill(process->pid(), SIGKILL), 0);
  ASSERT_TRUE(listener.wait([&] { return !listener.reason.empty(); }));
  EXPECT_NE(listener.reason.find("signal 9"), std::string::npos) << listener.reason;
  EXPECT_FALSE(process->send("{}"));
  process.reset();
  listener.reason.clear();
  listener.messages.clear();
  start();
  EXPECT_TRUE(load()["ok"]);
}

TEST_F(ProcessTest, CrashInTheContentIsReported) {
  start();
  ASSERT_TRUE(load(R"(,"crash":0.2)")["ok"]);
  ASSERT_TRUE(ask({{"op", "mode"}, {"mode", "simulate"}})["ok"]);
  ASSERT_TRUE(process->send(R"({"op":"play"})"));
  ASSERT_TRUE(listener.wait([&] { return !listener.reason.empty(); }));
  EXPECT_NE(listener.reason.find("The project is safe"), std::string::npos);
}

TEST_F(ProcessTest, HangingChildIsKilled) {
  start();
  ASSERT_TRUE(load(R"(,"hang":0.1)")["ok"]);
  ASSERT_TRUE(ask({{"op", "mode"}, {"mode", "simulate"}})["ok"]);
  ASSERT_TRUE(process->send(R"({"op":"seek","time":1})"));
  process->kill_unanswering();
  ASSERT_TRUE(listener.wait([&] { return !listener.reason.empty(); }));
  EXPECT_NE(listener.reason.find("stopped responding"), std::string::npos);
  process.reset();
  start();
  ASSERT_TRUE(load(R"(,"hang":0.1)")["ok"]);
  ASSERT_TRUE(ask({{"op", "mode"}, {"mode", "simulate"}})["ok"]);
  ASSERT_TRUE(process->send(R"({"op":"seek","time":1})"));
  const int pid = process->pid();
  process.reset();
  EXPECT_NE(::kill(pid, 0), 0);
}

// A crash that the studio notices only after the time to respond is reported as a crash; SIGKILL is what the kernel sends when memory runs out.
TEST_F(ProcessTest, SignalOfAnUnansweringChildIsNamed) {
  for (const int signal : {SIGUSR2, SIGKILL}) {
    listener.reason.clear();
    start();
    ASSERT_TRUE(load(R"(,"hang":0.1)")["ok"]);
    ASSERT_TRUE(ask({{"op", "mode"}, {"mode", "simulate"}})["ok"]);
    ASSERT_TRUE(process->send(R"({"op":"seek","time":1})"));
    ASSERT_EQ(::kill(process->pid(), signal), 0);
    process->kill_unanswering();
    ASSERT_TRUE(listener.wait([&] { return !listener.reason.empty(); }));
    EXPECT_NE(listener.reason.find("signal " + std::to_string(signal)), std::string::npos) << listener.reason;
    process.reset();
  }
}

TEST_F(ProcessTest, MissingProgramIsReported) {
  const auto started = InterpreterProcess::start({"/nonexistent/ugoki", {}}, listener.events());
  ASSERT_FALSE(started);
  EXPECT_NE(started.error().problems[0].message.find("cannot be started"), std::string::npos);
}

TEST(FrameRing, FramesArriveInOrderAndOldestAreDropped) {
  Result<FrameRing> ring = FrameRing::make();
  ASSERT_TRUE(ring);
  EXPECT_FALSE(ring->read());
  for (int round = 0; round < 3; ++round) {
    for (std::size_t i = 0; i < 5; ++i) ASSERT_TRUE(ring->write(std::vector<std::byte>(i * 7 + 1, std::byte(i))));
    for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(ring->read(), std::vector<std::byte>(i * 7 + 1, std::byte(i)));
    EXPECT_FALSE(ring->read());
  }
  for (std::size_t i = 0; i < 100; ++i) ASSERT_TRUE(ring->write(std::vector<std::byte>(9, std::byte(i))));
  std::vector<std::byte> last;
  int count = 0;
  while (const auto frame = ring->read()) {
    last = *frame;
    ++count;
  }
  EXPECT_EQ(last, std::vector<std::byte>(9, std::byte{99}));
  EXPECT_EQ(count, static_cast<int>(FrameRing::slot_count) - 1);
  EXPECT_FALSE(ring->write(std::vector<std::byte>(FrameRing::slot_bytes + 1)));
}

TEST(FrameRing, ReaderNeverGetsHalfWrittenFrame) {
  Result<FrameRing> ring = FrameRing::make();
  ASSERT_TRUE(ring);
  Result<FrameRing> other = FrameRing::attach(::dup(ring->fd()));
  ASSERT_TRUE(other);
  std::atomic<bool> stop = false;
  std::thread writer([&] {
    for (std::size_t n = 0; !stop; ++n) ring->write(std::vector<std::byte>(1000 + n % 13 * 8, std::byte(n & 255)));
  });
  int read = 0;
  while (read < 2000) {
    const auto frame = other->read();
    if (!frame) continue;
    ++read;
    for (const std::byte b : *frame) ASSERT_EQ(b, frame->front());
  }
  stop = true;
  writer.join();
}

}  // namespace
}  // namespace ugoki::studio

int main(int argc, char** argv) {
  if (argc > 1 && std::string_view(argv[1]) == "interpret-fake")
    return ugoki::studio::run_interpreter(ugoki::studio::test::open_fake_simulation);
  if (argc > 1 && std::string_view(argv[1]) == "interpret") return ugoki::studio::run_interpreter(ugoki::studio::open_player);
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
