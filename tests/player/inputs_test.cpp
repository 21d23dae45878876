// Recorded inputs as JSON: reading returns the inputs that were written, and a run with them gives the same bits.

#include "ugoki/content/inputs.h"

#include <gtest/gtest.h>

#include "../content/fixture.h"

namespace ugoki::content {
namespace {

Player open() {
  const auto bytes = generate(testing::make_scenario(), testing::make_resources());
  EXPECT_TRUE(bytes);
  auto player = Player::open(*bytes, "park.ugx");
  EXPECT_TRUE(player) << player.error().text();
  return std::move(*player);
}

TEST(RecordedInputs, RepeatARunBitByBit) {
  Player first = open();
  circuit::DeviceState held;
  for (int i = 0; i < 300; ++i) {
    if (i == 20) first.push(0, 1, {31.4159, -2.71828, 1.0 / 3}, 0.07);
    if (i == 60) first.grab(1, 0, {0.01, 0.1 / 3, 0}, {2.9, 0.2, 0.7});
    if (i == 90) first.drag({2.5, 0.1, 0.9});
    if (i == 130) first.release();
    if (i == 140) first.throw_from(1, {1, 1, 1.5}, {0.1, -3, 2}, {1, 2, 3});
    ASSERT_TRUE(first.step());
  }
  const std::string text = write_inputs(first.inputs(), first.content());
  auto inputs = read_inputs(text, first.content(), "inputs.json");
  ASSERT_TRUE(inputs) << inputs.error().text();
  EXPECT_EQ(inputs->size(), 5u);
  Player second = open(), third = open();
  second.schedule(*inputs);
  for (int i = 0; i < 300; ++i) {
    ASSERT_TRUE(second.step());
    ASSERT_TRUE(third.step());
  }
  EXPECT_EQ(second.state_hash(), first.state_hash());
  EXPECT_NE(third.state_hash(), first.state_hash()) << "without the inputs the run should differ";
  EXPECT_EQ(write_inputs(second.inputs(), second.content()), text);
}

TEST(RecordedInputs, DeviceStatesAreKeptExactly) {
  const Player player = open();
  PlayerInput a, b;
  auto state = std::make_shared<circuit::DeviceState>();
  state->keys = {"KeyA", "Space"};
  state->mouse = {.x = 0.1, .y = 1.0 / 3, .left = true, .middle = false, .right = true, .wheel = 0.1 + 0.2};
  state->gamepads[1].axes[2] = -0.7;
  state->gamepads[1].buttons[16] = 0.25;
  a.step = 3;
  a.held = state;
  auto later = std::make_shared<circuit::DeviceState>(*state);
  later->keys.clear();
  later->mouse.wheel = 0.7;
  b.step = 3;
  b.held = later;
  const auto read = read_inputs(write_inputs({a, b}, player.content()), player.content(), "inputs.json");
  ASSERT_TRUE(read) << read.error().text();
  ASSERT_EQ(read->size(), 2u);
  EXPECT_EQ(*(*read)[0].held, *state);
  EXPECT_EQ(*(*read)[1].held, *later);
}

TEST(RecordedInputs, LinksAreFoundByNameLabelAndIndex) {
  const Player player = open();
  for (const char* link : {"\"leg\"", "\"shank left\"", "1"}) {
    const auto read = read_inputs(std::string(R"({"inputs": [{"step": 0, "type": "push", "character": "human", "link": )") + link +
                                      R"(, "force": [1, 2, 3], "duration": 0.1}]})",
                                  player.content(), "inputs.json");
    ASSERT_TRUE(read) << read.error().text();
    EXPECT_EQ((*read)[0].record.link, 1);
    EXPECT_EQ((*read)[0].record.a, (Vec3{1, 2, 3}));
  }
}

TEST(RecordedInputs, EveryProblemIsNamedWithItsLocation) {
  const Player player = open();
  const auto read = read_inputs(R"({"inputs": [
    {"step": 5, "type": "push", "character": "nobody", "link": 0, "force": [1, 0, 0], "duration": 1},
    {"step": 4, "type": "release"},
    {"step": 6, "type": "jump"},
    {"step": 7.5, "type": "release"},
    {"step": 8, "type": "push", "character": 0, "link": "tail", "force": [1, 0], "duration": 0},
    {"step": 9, "type": "input", "keyboard": ["no key"]}]})",
                                player.content(), "inputs.json");
  ASSERT_FALSE(read);
  const std::string text = read.error().text();
  for (const char* wanted : {"inputs/0/character", "It has: human, ball", "inputs/1/step", "inputs/2/type", "inputs/3/step",
                             "inputs/4/link", "inputs/4/force", "inputs/4/duration", "inputs/5"})
    EXPECT_NE(text.find(wanted), std::string::npos) << wanted << "\n" << text;
}

}  // namespace
}  // namespace ugoki::content
