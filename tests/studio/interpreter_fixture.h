#pragma once
// Test fixture: an interpreter with a simulated clock and simulated content.

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "fake_simulation.h"
#include "ugoki/content/display_frame.h"
#include "ugoki/studio/interpreter.h"

namespace ugoki::studio {
using nlohmann::json;
using test::Frame;
using test::parse_frame;

inline std::span<const std::byte> bytes_of(const std::string& text) { return std::as_bytes(std::span(text.data(), text.size())); }

class Collector final : public InterpreterSink {
 public:
  void frame(std::span<const std::byte> bytes) override {
    frames.push_back(parse_frame(bytes));
    EXPECT_TRUE(frames.back().good);
  }
  void message(std::string text) override { messages.push_back(json::parse(text)); }

  [[nodiscard]] int count(const std::string& event) const {
    return static_cast<int>(std::ranges::count_if(messages, [&](const json& m) { return m["event"] == event; }));
  }
  [[nodiscard]] json last(const std::string& event) const {
    for (auto it = messages.rbegin(); it != messages.rend(); ++it) {
      if ((*it)["event"] == event) return *it;
    }
    return {};
  }

  std::vector<Frame> frames;
  std::vector<json> messages;
};

/// An interpreter with a simulated clock that only the test advances.
class InterpreterTest : public testing::Test {
 protected:
  static std::string content(const std::string& more = "") {
    return R"({"step":0.002,"duration":4,"rate":60,"cast":[{"id":"a","links":3},{"id":"b","links":1}])" + more + "}";
  }
  void open(const std::string& text) {
    const Result<void> r = interpreter.load(bytes_of(text));
    ASSERT_TRUE(r) << r.error().text();
  }
  void open() { open(content()); }
  /// Advances the clock by `seconds` in small steps and does the due work.
  void pass(double seconds) {
    const double end = now + seconds;
    while (now < end) {
      const double wait = interpreter.work();
      now += std::min(std::max(wait, 1e-5), end - now + 1e-9);
    }
    settle();
  }
  /// Does the work that is due without advancing the clock.
  void settle() {
    for (int i = 0; i < 100000 && interpreter.work() == 0; ++i) {
    }
  }
  const Frame& shown() { return sink.frames.back(); }

  double now = 100;
  Collector sink;
  Interpreter interpreter{test::open_fake_simulation, sink, [this] { return now; }};
};

}  // namespace ugoki::studio
