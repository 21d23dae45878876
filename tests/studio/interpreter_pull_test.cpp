// Pulls of the user that an interpreter reports, so that they can be kept as events.

#include <cmath>

#include "interpreter_fixture.h"

namespace ugoki::studio {
namespace {

TEST_F(InterpreterTest, AReleasedPullIsReportedAndCanBeForgotten) {
  open();
  ASSERT_TRUE(interpreter.set_mode(PlayMode::simulate));
  ASSERT_TRUE(interpreter.play(std::nullopt));
  pass(0.5);
  ASSERT_TRUE(interpreter.grab("a", "1", {0, 0, 0.1}, {1, 0, 1}));
  pass(0.1);
  ASSERT_TRUE(interpreter.drag({1.5, 0, 1}));
  ASSERT_TRUE(interpreter.drag({2, 0, 1}));
  pass(0.2);
  EXPECT_EQ(sink.count("pulled"), 0);
  ASSERT_TRUE(interpreter.release());
  ASSERT_TRUE(interpreter.release());
  ASSERT_EQ(sink.count("pulled"), 1) << "a second release ends nothing";
  const json pulled = sink.last("pulled");
  EXPECT_EQ(pulled["character"], "a");
  EXPECT_EQ(pulled["link"], 1);
  EXPECT_EQ(pulled["point"], json({0, 0, 0.1}));
  const double begin = pulled["time"];
  EXPECT_NEAR(begin, 0.5, 0.05);
  EXPECT_NEAR(pulled["duration"].get<double>(), 0.3, 0.05);
  ASSERT_EQ(pulled["path"].size(), 2u) << "of two positions before the same step, the last one acts: " << pulled;
  EXPECT_EQ(pulled["path"][0], json({0.0, 1, 0, 1}));
  EXPECT_EQ(pulled["path"][1][1], 2);
  pass(0.2);

  // the content is loaded again: the pull is repeated, and after forget_pull() it is not
  ASSERT_TRUE(interpreter.pause());
  const auto x_after_reload = [&] {
    open();
    pass(1);
    EXPECT_TRUE(interpreter.seek(0.9));
    pass(1);
    return sink.frames.back().characters[0].links[0][0];
  };
  const float pulled_x = x_after_reload();
  EXPECT_FALSE(interpreter.forget_pull(begin + 0.1)) << "no pull begins there";
  ASSERT_TRUE(interpreter.forget_pull(begin));
  EXPECT_FALSE(interpreter.forget_pull(begin)) << "it is gone";
  const float free_x = x_after_reload();
  EXPECT_GT(std::fabs(pulled_x - free_x), 0.01f);
}

}  // namespace
}  // namespace ugoki::studio
