#include <cmath>
#include <cstdio>

#include "interpreter_fixture.h"

namespace ugoki::studio {
namespace {

TEST_F(InterpreterTest, WithoutContentRequestsAreRejectedWithRemedy) {
  for (const Result<void>& r : {interpreter.play(std::nullopt), interpreter.pause(), interpreter.seek(1), interpreter.restart(),
                                interpreter.set_mode(PlayMode::simulate), interpreter.grab("a", "0", {}, {}), interpreter.release()}) {
    ASSERT_FALSE(r);
    EXPECT_FALSE(r.error().problems[0].remedy.empty());
  }
  EXPECT_TRUE(std::isinf(interpreter.work()));
  EXPECT_FALSE(interpreter.load(bytes_of("not json")));
}

TEST_F(InterpreterTest, LogReportsContactsThatWereNotSolved) {
  open(content(R"(,"unsolved":0.5,"split":0.6)"));
  ASSERT_TRUE(interpreter.set_mode(PlayMode::simulate));
  ASSERT_TRUE(interpreter.play(1.0));
  pass(0.45);
  EXPECT_EQ(sink.count("log"), 0);
  pass(0.5);
  ASSERT_TRUE(interpreter.pause());
  double unsolved = 0, failed = 0, split = 0;
  for (const json& m : sink.messages) {
    if (m["event"] != "log") continue;
    EXPECT_EQ(m["level"], "warning");
    const std::string text = m["text"];
    double begin = 0, end = 0, a = 0, b = 0, c = 0;
    ASSERT_EQ(std::sscanf(text.c_str(),
                          "%lf to %lf s: %lf groups of contacts were not solved to the tolerance and %lf stages of steps failed; a shorter "
                          "step may help. %lf steps were split into substeps.",
                          &begin, &end, &a, &b, &c),
              5)
        << text;
    EXPECT_GE(end, 0.5);
    EXPECT_LT(begin, end);
    unsolved += a;
    failed += b;
    split += c;
  }
  const double head = sink.last("transport")["simulated"];
  EXPECT_NEAR(unsolved, 2 * (head - 0.5) / 0.002, 2.5);
  EXPECT_NEAR(failed, (head - 0.5) / 0.002, 1.5);
  EXPECT_NEAR(split, (head - 0.6) / 0.002, 1.5);
  const int logged = sink.count("log");
  EXPECT_LE(logged, 4) << "at most one message a second, and one at the end";
  ASSERT_TRUE(interpreter.seek(0.2));
  settle();
  EXPECT_EQ(sink.count("log"), logged) << "recorded steps are not reported again";
}

TEST_F(InterpreterTest, SingleTickBeforeHeadRecomputesWithRecordedInputs) {
  open();
  ASSERT_TRUE(interpreter.set_mode(PlayMode::simulate));
  ASSERT_TRUE(interpreter.seek(0.5));
  settle();
  ASSERT_TRUE(interpreter.push("a", "0", {70, 0, 0}, 0.2));
  ASSERT_TRUE(interpreter.seek(1));
  settle();
  const std::uint64_t pushed = interpreter.head_digest();
  ASSERT_TRUE(interpreter.seek(0.25));
  const double shown = interpreter.time();
  ASSERT_TRUE(interpreter.step_tick());
  EXPECT_NEAR(interpreter.time(), shown + 0.002, 1e-9);
  EXPECT_NEAR(interpreter.simulated(), shown + 0.002, 1e-9);
  EXPECT_FALSE(interpreter.playing());
  ASSERT_TRUE(interpreter.seek(1));
  settle();
  EXPECT_EQ(interpreter.head_digest(), pushed);

  ASSERT_TRUE(interpreter.seek(4));
  settle();
  EXPECT_FALSE(interpreter.step_tick()) << "the shown time is the end of the content";
}

TEST_F(InterpreterTest, FramesHaveDocumentedLayout) {
  open();
  ASSERT_TRUE(interpreter.set_mode(PlayMode::simulate));
  ASSERT_TRUE(interpreter.grab("b", "0", {}, {7, 0, 1}));
  const Frame& f = shown();
  EXPECT_EQ(f.flags, content::frame_simulate | content::frame_live | content::frame_grab);
  EXPECT_EQ(f.grab[3], 7);
  ASSERT_EQ(f.characters.size(), 2u);
  ASSERT_EQ(f.characters[0].links.size(), 3u);
  ASSERT_EQ(f.characters[1].links.size(), 1u);
  EXPECT_EQ(f.characters[0].assist_moment[2], 6);
  EXPECT_EQ(f.characters[0].assist_over_cap, 0.25f);
  EXPECT_EQ(f.characters[0].weight, 700);
  EXPECT_EQ(f.characters[0].links[2][1], 2);
  EXPECT_NEAR(f.characters[0].links[2][3], std::cos(0.25), 1e-6);
  EXPECT_NEAR(f.characters[0].links[2][6], std::sin(0.25), 1e-6);
  ASSERT_EQ(f.contacts.size(), 1u);
  EXPECT_EQ(f.contacts[0].force[2], 700);
}

TEST_F(InterpreterTest, EditModeShowsAndPlaysPoses) {
  open();
  ASSERT_TRUE(interpreter.seek(1.5));
  EXPECT_DOUBLE_EQ(shown().time, 1.5);
  EXPECT_EQ(shown().number, 90u);
  EXPECT_EQ(shown().flags, 0u);
  EXPECT_EQ(shown().characters[0].state, 3u);
  EXPECT_FLOAT_EQ(shown().characters[0].links[0][0], 15);
  ASSERT_TRUE(interpreter.step_frames(1));
  EXPECT_EQ(shown().number, 91u);
  ASSERT_TRUE(interpreter.step_frames(-1));
  ASSERT_TRUE(interpreter.step_frames(-1));
  EXPECT_EQ(shown().number, 89u);
  ASSERT_TRUE(interpreter.seek(-5));
  EXPECT_EQ(shown().time, 0);
  ASSERT_TRUE(interpreter.seek(1000));
  EXPECT_EQ(shown().time, 4);
  EXPECT_FALSE(interpreter.seek(std::nan("")));
  ASSERT_TRUE(interpreter.play(std::nullopt));  // at the end of the content: starts at 0
  pass(1);
  EXPECT_NEAR(shown().time, 1, 0.02);
  EXPECT_EQ(shown().flags, content::frame_playing);
  pass(4);
  EXPECT_EQ(shown().time, 4);
  EXPECT_FALSE(interpreter.playing());
  EXPECT_EQ(sink.last("transport")["status"], "end");
  EXPECT_EQ(interpreter.simulated(), 0);
  EXPECT_FALSE(interpreter.grab("a", "0", {}, {}));
}

TEST_F(InterpreterTest, Plays60FramesPerSimulatedSecond) {
  open();
  ASSERT_TRUE(interpreter.set_mode(PlayMode::simulate));
  sink.frames.clear();
  ASSERT_TRUE(interpreter.play(std::nullopt));
  pass(2.001);
  ASSERT_GE(sink.frames.size(), 119u);
  EXPECT_LE(sink.frames.size(), 122u);
  for (std::size_t i = 1; i < sink.frames.size(); ++i) EXPECT_EQ(sink.frames[i].number, sink.frames[i - 1].number + 1);
  EXPECT_NEAR(interpreter.simulated(), 2, 0.02);
  EXPECT_GE(sink.count("transport"), 4);
  EXPECT_LE(sink.count("transport"), 8);
  EXPECT_GE(sink.count("summary"), 6);
  EXPECT_LE(sink.count("summary"), 10);
  const json contacts = sink.last("summary")["contacts"];
  EXPECT_EQ(contacts[0]["feet"], 2);
  EXPECT_EQ(contacts[0]["character"], "a");
  EXPECT_NEAR(contacts[0]["to"].get<double>(), 0.5, 0.02);
  EXPECT_EQ(contacts[1]["feet"], 1);
  ASSERT_TRUE(interpreter.pause());
  EXPECT_EQ(shown().flags, content::frame_simulate | content::frame_live);
}

/// The values of one measure for all frames, put together from the events as a page does; checks that the events fit together.
std::vector<double> collect_measures(const std::vector<json>& messages, const char* key) {
  std::vector<double> values;
  for (const json& m : messages) {
    if (m["event"] != "measures") continue;
    EXPECT_LE(m["from"].get<std::size_t>(), values.size());
    values.resize(m["from"].get<std::size_t>());
    for (const json& value : m["characters"][0]["values"][key]) values.push_back(value.get<double>());
  }
  return values;
}

TEST_F(InterpreterTest, MeasuresOfAllFramesAreSentOnceAndAgainOnRequest) {
  open();
  ASSERT_TRUE(interpreter.set_mode(PlayMode::simulate));
  ASSERT_TRUE(interpreter.play(std::nullopt));
  pass(2);
  ASSERT_TRUE(interpreter.pause());
  const std::vector<double> steps = collect_measures(sink.messages, "foot_slip_cm");
  ASSERT_NEAR(static_cast<double>(steps.size()), 121, 2);
  for (std::size_t n = 0; n < steps.size(); ++n) EXPECT_NEAR(steps[n], static_cast<double>(n) / 60 / 0.002, 0.51);
  EXPECT_EQ(sink.last("measures")["rate"], 60);
  std::size_t sent = 0;
  double fell = -1;
  for (const json& m : sink.messages) {
    if (m["event"] != "measures" || m["from"] == 0) continue;
    sent += m["characters"][0]["values"]["foot_slip_cm"].size();
    EXPECT_EQ(m["frames"], m["characters"][0]["values"]["foot_slip_cm"].size());
    EXPECT_FALSE(m["characters"][0]["values"].contains("jerk")) << "no frame has a value";
    EXPECT_FALSE(m.contains("list"));
    const json& falls = m["characters"][0]["values"]["fell"];
    for (std::size_t n = 0; n < falls.size() && fell < 0; ++n)
      if (falls[n] > 0) fell = m["from"].get<double>() + static_cast<double>(n);
  }
  EXPECT_LE(sent, steps.size()) << "no frame is sent twice";
  const json& first = *std::ranges::find_if(sink.messages, [](const json& m) { return m["event"] == "measures" && m["from"] == 0; });
  EXPECT_EQ(first["list"].size(), naturalness::measure_count);
  EXPECT_EQ(first["list"][3]["key"], "foot_slip_cm");
  EXPECT_EQ(sink.last("measures")["characters"][0]["totals"]["foot_slip_cm"], 2.5);
  EXPECT_EQ(sink.last("measures")["characters"][0]["totals"]["toe_clearance_mm"], "no walking");
  EXPECT_EQ(fell, 60) << "step 500 of 2 ms is frame 60";
  sink.messages.clear();
  interpreter.resend_measures();
  pass(0.5);
  EXPECT_EQ(collect_measures(sink.messages, "foot_slip_cm"), steps);
  // Frames that are computed again replace the old ones.
  ASSERT_TRUE(interpreter.seek(0.5));
  ASSERT_TRUE(interpreter.push("a", "0", {500, 0, 0}, 0.1));
  ASSERT_TRUE(interpreter.play(std::nullopt));
  pass(1);
  ASSERT_TRUE(interpreter.pause());
  EXPECT_EQ(collect_measures(sink.messages, "foot_slip_cm").size(), collect_measures(sink.messages, "tracking_deg").size());
  EXPECT_NEAR(static_cast<double>(collect_measures(sink.messages, "foot_slip_cm").size()), 91, 2);
  ASSERT_TRUE(interpreter.restart());
  EXPECT_EQ(collect_measures(sink.messages, "foot_slip_cm").size(), 1u);
}

TEST_F(InterpreterTest, PlayingEndsAtTheOutPointOrLoopsToTheInPoint) {
  for (const PlayMode mode : {PlayMode::edit, PlayMode::simulate}) {
    open();
    ASSERT_TRUE(interpreter.set_mode(mode));
    interpreter.set_range(0.5, 1.5, false);
    ASSERT_TRUE(interpreter.seek(1));
    settle();
    ASSERT_TRUE(interpreter.play(1.0));
    pass(1);
    EXPECT_FALSE(interpreter.playing());
    EXPECT_NEAR(interpreter.time(), 1.5, 0.003);
    ASSERT_TRUE(interpreter.play(std::nullopt));  // at the out point: from the in point
    pass(0.25);
    EXPECT_NEAR(interpreter.time(), 0.75, 0.03);
    interpreter.set_range(0.5, 1.5, true);
    EXPECT_EQ(sink.last("transport")["loop"], true);
    for (int i = 0; i < 40; ++i) {
      pass(0.1);
      EXPECT_TRUE(interpreter.playing());
      EXPECT_GE(interpreter.time(), 0.499);
      EXPECT_LE(interpreter.time(), 1.503);
    }
    ASSERT_TRUE(interpreter.pause());
    ASSERT_TRUE(interpreter.seek(2));  // after the out point, playing continues to the end
    settle();
    interpreter.set_range(0.5, 1.5, false);
    ASSERT_TRUE(interpreter.play(4.0));
    pass(1);
    EXPECT_FALSE(interpreter.playing());
    EXPECT_NEAR(interpreter.time(), 4, 0.003);
    interpreter.set_range(0, std::numeric_limits<double>::infinity(), false);
    ASSERT_TRUE(interpreter.seek(0));
  }
}

TEST_F(InterpreterTest, LoopBeforeTheHeadIsSimulatedFirst) {
  open();
  ASSERT_TRUE(interpreter.set_mode(PlayMode::simulate));
  interpreter.set_range(3, 3.5, true);
  ASSERT_TRUE(interpreter.seek(4));
  settle();
  ASSERT_TRUE(interpreter.restart());
  ASSERT_TRUE(interpreter.play(8.0));
  pass(3);
  EXPECT_TRUE(interpreter.playing());
  EXPECT_GE(interpreter.time(), 2.999);
  EXPECT_LE(interpreter.time(), 3.503);
}

TEST_F(InterpreterTest, SlowMotionAndFastForwardShow60FramesPerSecond) {
  open();
  ASSERT_TRUE(interpreter.set_mode(PlayMode::simulate));
  EXPECT_FALSE(interpreter.play(0.0));
  EXPECT_FALSE(interpreter.play(100.0));
  EXPECT_FALSE(interpreter.play(std::nan("")));
  ASSERT_TRUE(interpreter.play(0.25));
  sink.frames.clear();
  pass(2.001);
  EXPECT_NEAR(static_cast<double>(sink.frames.size()), 120, 2);
  EXPECT_NEAR(interpreter.simulated(), 0.5, 0.02);
  ASSERT_TRUE(interpreter.play(4.0));
  sink.frames.clear();
  pass(0.5);
  EXPECT_NEAR(static_cast<double>(sink.frames.size()), 30, 2);
  EXPECT_NEAR(interpreter.simulated(), 2.5, 0.08);
}

TEST_F(InterpreterTest, ScrubbingShowsRecordedFramesAndPlayContinues) {
  open();
  ASSERT_TRUE(interpreter.set_mode(PlayMode::simulate));
  ASSERT_TRUE(interpreter.play(std::nullopt));
  pass(2);
  ASSERT_TRUE(interpreter.pause());
  const double head = interpreter.simulated();
  const std::uint64_t digest = interpreter.head_digest();
  ASSERT_TRUE(interpreter.seek(1));
  EXPECT_EQ(shown().number, 60u);
  EXPECT_EQ(shown().flags, content::frame_simulate);  // without frame_live: the frame is recorded
  const float there = shown().characters[0].links[0][0];
  ASSERT_TRUE(interpreter.step_frames(-1));
  EXPECT_EQ(shown().number, 59u);
  EXPECT_LT(shown().characters[0].links[0][0], there);
  ASSERT_TRUE(interpreter.step_frames(1));
  EXPECT_EQ(shown().characters[0].links[0][0], there);
  EXPECT_EQ(interpreter.simulated(), head);
  ASSERT_TRUE(interpreter.play(std::nullopt));
  pass(0.5);
  EXPECT_EQ(shown().flags, content::frame_simulate | content::frame_playing);
  EXPECT_EQ(interpreter.head_digest(), digest);
  pass(1);
  EXPECT_GT(interpreter.simulated(), head);
  EXPECT_EQ(shown().flags, content::frame_simulate | content::frame_playing | content::frame_live);
  EXPECT_NEAR(shown().time, 2.5, 0.02);
}

TEST_F(InterpreterTest, SlowMotionInterpolatesRecordedFrames) {
  open();
  ASSERT_TRUE(interpreter.set_mode(PlayMode::simulate));
  ASSERT_TRUE(interpreter.seek(3));
  settle();
  ASSERT_TRUE(interpreter.seek(1));
  ASSERT_TRUE(interpreter.play(0.1));
  sink.frames.clear();
  pass(2);
  ASSERT_GT(sink.frames.size(), 110u);
  std::vector<float> moves;
  for (std::size_t i = 1; i < sink.frames.size(); ++i) {
    moves.push_back(sink.frames[i].characters[0].links[0][0] - sink.frames[i - 1].characters[0].links[0][0]);
    EXPECT_NEAR(sink.frames[i].characters[0].links[0][3], std::cos(0.25), 1e-6);
    EXPECT_NEAR(sink.frames[i].time - sink.frames[i - 1].time, 0.1 / 60, 1e-9);
  }
  const auto [minimum, maximum] = std::ranges::minmax(moves);
  EXPECT_GT(minimum, 0.5f * maximum);  // the motion between frames is nearly uniform
}

TEST_F(InterpreterTest, SeekingAndSteppingReachTheSameState) {
  open();
  ASSERT_TRUE(interpreter.set_mode(PlayMode::simulate));
  ASSERT_TRUE(interpreter.seek(3));
  EXPECT_EQ(sink.last("transport")["status"], "simulating");
  settle();
  EXPECT_EQ(shown().number, 180u);
  EXPECT_EQ(sink.last("transport")["status"], "paused");
  const std::uint64_t sought = interpreter.head_digest();
  ASSERT_TRUE(interpreter.restart());
  EXPECT_EQ(interpreter.simulated(), 0);
  EXPECT_EQ(shown().number, 0u);
  for (int i = 0; i < 180; ++i) {
    ASSERT_TRUE(interpreter.step_frames(1));
    settle();
    EXPECT_EQ(shown().number, static_cast<std::uint32_t>(i + 1));
  }
  EXPECT_EQ(interpreter.head_digest(), sought);
}

TEST_F(InterpreterTest, LiveInputsReplayBitIdentically) {
  open();
  ASSERT_TRUE(interpreter.set_mode(PlayMode::simulate));
  ASSERT_TRUE(interpreter.play(std::nullopt));
  pass(0.5);
  const std::uint64_t untouched = interpreter.head_digest();
  ASSERT_TRUE(interpreter.push("a", "chest", {1000, 0, 0}, 0.2));
  pass(0.3);
  ASSERT_TRUE(interpreter.grab("b", "0", {}, {-3, 0, 1}));
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(interpreter.drag({-3.0 - i, 0, 1}));
    pass(0.01);
  }
  ASSERT_TRUE(interpreter.release());
  pass(0.3);
  ASSERT_TRUE(interpreter.pause());
  const std::uint64_t digest = interpreter.head_digest();
  const double head = interpreter.simulated();
  EXPECT_NE(digest, untouched);
  // Loading the same content recomputes it up to the shown time with the recorded inputs.
  open();
  settle();
  EXPECT_DOUBLE_EQ(interpreter.simulated(), head);
  EXPECT_EQ(interpreter.head_digest(), digest);
  // Other content with another wind uses the same recorded inputs.
  open(content(R"(,"wind":2)"));
  settle();
  EXPECT_DOUBLE_EQ(interpreter.simulated(), head);
  EXPECT_NE(interpreter.head_digest(), digest);
  open();
  settle();
  EXPECT_EQ(interpreter.head_digest(), digest);
  // Loading another cast drops the recorded inputs.
  open(R"({"step":0.002,"duration":4,"rate":60,"cast":[{"id":"a","links":3}]})");
  open();
  settle();
  EXPECT_DOUBLE_EQ(interpreter.simulated(), head);
  EXPECT_NE(interpreter.head_digest(), digest);
}

TEST_F(InterpreterTest, InputBeforeHeadReplacesLaterRecording) {
  open();
  ASSERT_TRUE(interpreter.set_mode(PlayMode::simulate));
  ASSERT_TRUE(interpreter.seek(2));
  settle();
  const std::uint64_t untouched = interpreter.head_digest();
  ASSERT_TRUE(interpreter.restart());
  ASSERT_TRUE(interpreter.play(std::nullopt));
  pass(1);
  ASSERT_TRUE(interpreter.push("a", "0", {500, 0, 0}, 0.1));
  pass(1.3);
  ASSERT_TRUE(interpreter.pause());
  ASSERT_TRUE(interpreter.seek(0.8));
  ASSERT_TRUE(interpreter.push("a", "0", {-500, 0, 0}, 0.1));
  EXPECT_NEAR(interpreter.simulated(), 0.8, 0.003);
  ASSERT_TRUE(interpreter.seek(2));
  settle();
  const std::uint64_t digest = interpreter.head_digest();
  // The same push gives the same result if nothing was recorded before.
  ASSERT_TRUE(interpreter.restart());
  ASSERT_TRUE(interpreter.seek(0.8));
  settle();
  ASSERT_TRUE(interpreter.push("a", "0", {-500, 0, 0}, 0.1));
  ASSERT_TRUE(interpreter.seek(2));
  settle();
  EXPECT_EQ(interpreter.head_digest(), digest);
  // A restart drops all recorded inputs.
  ASSERT_TRUE(interpreter.restart());
  ASSERT_TRUE(interpreter.seek(2));
  settle();
  EXPECT_EQ(interpreter.head_digest(), untouched);
}

TEST_F(InterpreterTest, InvalidInputsAreRejectedWithLocation) {
  open();
  ASSERT_TRUE(interpreter.set_mode(PlayMode::simulate));
  const auto location = [](const Result<void>& r) { return r ? std::string("accepted") : r.error().problems[0].location; };
  EXPECT_EQ(location(interpreter.grab("nobody", "0", {}, {})), "character");
  EXPECT_EQ(location(interpreter.grab("a", "3", {}, {})), "link");
  EXPECT_EQ(location(interpreter.grab("a", "-1", {}, {})), "link");
  EXPECT_EQ(location(interpreter.grab("a", "tail", {}, {})), "link");
  EXPECT_EQ(location(interpreter.grab("a", "0", {std::nan(""), 0, 0}, {})), "target");
  EXPECT_EQ(location(interpreter.push("a", "0", {1e9, 0, 0}, 0.1)), "force");
  EXPECT_EQ(location(interpreter.push("a", "0", {1, 0, 0}, 0)), "duration");
  EXPECT_EQ(location(interpreter.drag({0, std::nan(""), 0})), "target");
  EXPECT_EQ(location(interpreter.drag({1, 0, 0})), "accepted");  // a drag without a grab is ignored
  EXPECT_FALSE(shown().flags & content::frame_grab);
}

TEST_F(InterpreterTest, FailedStepStopsPlayingAndKeepsRecording) {
  open(content(R"(,"blow_up":1)"));
  ASSERT_TRUE(interpreter.set_mode(PlayMode::simulate));
  ASSERT_TRUE(interpreter.play(std::nullopt));
  pass(2);
  EXPECT_FALSE(interpreter.playing());
  ASSERT_EQ(sink.count("stopped"), 1);
  EXPECT_NE(sink.last("stopped")["reason"].get<std::string>().find("joint hip"), std::string::npos);
  EXPECT_NEAR(interpreter.simulated(), 1, 0.003);
  EXPECT_FALSE(interpreter.play(std::nullopt));
  ASSERT_TRUE(interpreter.seek(0.5));
  EXPECT_EQ(shown().number, 30u);
  ASSERT_TRUE(interpreter.play(std::nullopt));  // plays the recording up to the failed step
  pass(1);
  EXPECT_FALSE(interpreter.playing());
  open();  // content without the failure
  settle();
  ASSERT_TRUE(interpreter.play(std::nullopt));
  pass(1);
  EXPECT_GT(interpreter.simulated(), 1.5);
}

TEST_F(InterpreterTest, PlayingContinuesAfterLoad) {
  open();
  ASSERT_TRUE(interpreter.set_mode(PlayMode::simulate));
  ASSERT_TRUE(interpreter.play(std::nullopt));
  pass(1);
  open(content(R"(,"wind":3)"));
  pass(0.5);
  EXPECT_TRUE(interpreter.playing());
  EXPECT_NEAR(interpreter.simulated(), 1.5, 0.05);
  const std::uint64_t digest = interpreter.head_digest();
  const auto steps = std::llround(interpreter.simulated() / 0.002);
  ASSERT_TRUE(interpreter.pause());
  ASSERT_TRUE(interpreter.restart());
  ASSERT_TRUE(interpreter.seek(static_cast<double>(steps) * 0.002));
  settle();
  EXPECT_EQ(interpreter.head_digest(), digest);
  // After loading content that is shorter than the shown time, the shown time is within the content.
  open(R"({"duration":0.5,"cast":[{"id":"a","links":3}]})");
  settle();
  EXPECT_LE(interpreter.time(), 0.5);
}

TEST_F(InterpreterTest, SwitchToSimulateKeepsShownTime) {
  open();
  ASSERT_TRUE(interpreter.seek(2));
  ASSERT_TRUE(interpreter.set_mode(PlayMode::simulate));
  settle();
  EXPECT_NEAR(shown().time, 2, 0.002);
  EXPECT_EQ(shown().characters[0].state, 0u);
  ASSERT_TRUE(interpreter.set_mode(PlayMode::edit));
  EXPECT_EQ(shown().characters[0].state, 3u);
  ASSERT_TRUE(interpreter.seek(1));
  ASSERT_TRUE(interpreter.set_mode(PlayMode::simulate));
  EXPECT_EQ(shown().number, 60u);
  EXPECT_NEAR(interpreter.simulated(), 2, 0.002);
}

TEST_F(InterpreterTest, StepFramesFollowsContentFrameRate) {
  for (const int rate : {24, 25, 30, 50, 120}) {
    open(R"({"rate":)" + std::to_string(rate) + R"(,"duration":2,"cast":[{"id":"a","links":1}]})");
    ASSERT_TRUE(interpreter.set_mode(PlayMode::simulate));
    ASSERT_TRUE(interpreter.restart());
    for (int i = 1; i <= rate; ++i) {
      ASSERT_TRUE(interpreter.step_frames(1));
      settle();
      ASSERT_EQ(shown().number, static_cast<std::uint32_t>(i)) << rate;
    }
    for (int i = rate - 1; i >= 0; --i) {
      ASSERT_TRUE(interpreter.step_frames(-1));
      ASSERT_EQ(shown().number, static_cast<std::uint32_t>(i)) << rate;
    }
  }
}

TEST_F(InterpreterTest, SlowComputerSlowsPlayingWithoutStopping) {
  open();
  ASSERT_TRUE(interpreter.set_mode(PlayMode::simulate));
  ASSERT_TRUE(interpreter.play(std::nullopt));
  for (int i = 0; i < 50; ++i) {  // the process gets processor time only once in 0.5 s
    now += 0.5;
    interpreter.work();
    settle();
  }
  EXPECT_TRUE(interpreter.playing());
  EXPECT_LT(interpreter.simulated(), 4);
}

}  // namespace
}  // namespace ugoki::studio
