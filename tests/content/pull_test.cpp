// Pulls as events of the scenario: JSON form, checks, and equality with the pull of a user.

#include <gtest/gtest.h>

#include "command_fixture.h"

namespace ugoki::content {
namespace {

using testing::make_scenario;

class PullTest : public testing::CommandFixture {
 protected:
  PullTest() { document = make_scenario(); }
  static std::string add(const std::string& fields) {
    return R"({"type": "event.add", "event": {"type": "pull", "time": 0.2, "character": "ball", "link": "ball", )" + fields + "}}";
  }
  void bad(const std::string& fields, ErrorCode code, const std::string& location) { refuses(add(fields), code, location); }
};

TEST_F(PullTest, DocumentKeepsTheTargets) {
  document.events.clear();
  auto effect = apply_command(document, add(R"("duration": 0.5, "point": [0, 0, 0.1], "path": [[0, 3, 0, 1], [0.25, 3, -0.0, 1.5]])"),
                              catalogue, next_id);
  ASSERT_TRUE(effect) << effect.error().text();
  EXPECT_EQ(effect->label, "Add pull");
  document = std::move(effect->scenario);
  ASSERT_EQ(document.events.size(), 1u);
  EXPECT_EQ(document.events[0].path[1], (PullTarget{0.25, {3, 0, 1.5}}));
  const std::string text = write_scenario(document);
  const Result<Scenario> read = read_scenario(text, "scenario");
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(*read, document);
  EXPECT_EQ(write_scenario(*read), text);
}

TEST_F(PullTest, RefusesFaultyPulls) {
  document.events.clear();
  const std::string at = "scenario/events/0";
  bad(R"("path": [])", ErrorCode::structure, at + "/path");
  bad(R"("path": [[0.1, 0, 0, 1]])", ErrorCode::structure, at + "/path");
  bad(R"("path": [[0, 0, 0, 1], [0, 0, 0, 2]])", ErrorCode::structure, at + "/path/1");
  bad(R"("path": [[0, 0, 0, 1e6]])", ErrorCode::range, at + "/path/0");
  bad(R"("path": [[0, 0, 0, 1]], "duration": 0)", ErrorCode::range, at + "/duration");
  bad(R"("path": [[0, 0, 0, 1]], "point": [1000, 0, 0])", ErrorCode::range, at + "/point");
  bad(R"("path": [[0, 0, 0]])", ErrorCode::syntax, "command/event/path/0");
  bad(R"("path": [[0, 0, "x", 1]])", ErrorCode::syntax, "command/event/path/0");
}

/// A pull by a user, and the event with the same targets, give the same bits.
TEST_F(PullTest, EventRepeatsThePullOfAUser) {
  const std::uint64_t begin = 100, first_move = 150, second_move = 230, end = 300;  // steps of 2 ms
  Player live = open();
  const auto to = [&](std::uint64_t step) {
    while (live.step_count() < step) ASSERT_TRUE(live.step());
  };
  to(begin);
  live.grab(1, 0, {0, 0, 0.05}, {3, 0, 1});
  to(first_move);
  live.drag({3.2, 0.1, 1.2});
  to(second_move);
  live.drag({2.8, 0, 1.6});
  to(end);
  live.release();
  to(400);

  auto effect = apply_command(document, add(R"("duration": 0.4, "point": [0, 0, 0.05],
      "path": [[0, 3, 0, 1], [0.1, 3.2, 0.1, 1.2], [0.26, 2.8, 0, 1.6]])"),
                              catalogue, next_id);
  ASSERT_TRUE(effect) << effect.error().text();
  document = std::move(effect->scenario);
  Player event = open();
  while (event.step_count() < 400) ASSERT_TRUE(event.step());
  const auto a = live.interpreter().find_circuit_output("state")->numbers(),
             b = event.interpreter().find_circuit_output("state")->numbers();
  EXPECT_TRUE(std::equal(a.begin(), a.end(), b.begin(), b.end()));

  document = make_scenario();
  Player without = open();
  while (without.step_count() < 400) ASSERT_TRUE(without.step());
  const auto c = without.interpreter().find_circuit_output("state")->numbers();
  EXPECT_FALSE(std::equal(a.begin(), a.end(), c.begin(), c.end())) << "the pull moves the ball";
}

}  // namespace
}  // namespace ugoki::content
