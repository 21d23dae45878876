// Input devices: the text form of their state, and how it reaches the LSIs keyboard, mouse and gamepad.

#include "ugoki/circuit/devices.h"

#include "circuit_test.h"

namespace ugoki::circuit {
namespace {

constexpr const char* desk = R"({"version": 2, "name": "desk", "lsis": [
  {"id": "w", "type": "keyboard", "parameters": {"key": "KeyW"}}, {"id": "jump", "type": "keyboard"}, {"id": "again", "type": "keyboard"},
  {"id": "m", "type": "mouse"}, {"id": "g", "type": "gamepad", "parameters": {"pad": "1"}}, {"id": "o", "type": "osc"},
  {"id": "far", "type": "gamepad", "parameters": {"pad": "9"}}]})";

DeviceChange read(const std::string& text) {
  auto change = read_device_change(text);
  EXPECT_TRUE(change) << (change ? "" : change.error().text());
  return change ? *change : DeviceChange{};
}

TEST(Devices, UseListsEachDeviceOnce) {
  auto i = build(desk);
  ASSERT_TRUE(i);
  const DeviceUse use = DeviceFeed(*i).use();
  EXPECT_EQ(use, (DeviceUse{{"KeyW", "Space"}, true, {1}}));
  EXPECT_EQ(write_device_use(use), R"({"keyboard":["KeyW","Space"],"mouse":true,"gamepads":[1]})");
  EXPECT_EQ(write_device_use({}), R"({"keyboard":[],"mouse":false,"gamepads":[]})");
}

TEST(Devices, GiveSetsEveryPin) {
  auto i = build(desk);
  ASSERT_TRUE(i);
  const DeviceFeed feed(*i);
  DeviceState state;
  EXPECT_TRUE(feed.has(state)) << "no key or button is pressed at first";
  apply(read(R"({"op": "input", "keyboard": ["Space", "KeyQ", "Space"], "mouse": {"x": 0.25, "y": 7, "right": true, "wheel": 2},
                 "gamepads": [null, {"axes": [0.5, -1, 0.1, 0.75], "buttons": [1, 0, 0.2, 0.7, 0, 0, 0.3, 0.9]}]})"),
        state);
  EXPECT_FALSE(feed.has(state));
  feed.give(state);
  EXPECT_TRUE(feed.has(state));
  const std::pair<const char*, double> expected[] = {
      {"w.pressed", 0},         {"jump.pressed", 1}, {"again.pressed", 1}, {"m.x", 0.25},     {"m.y", 1},      {"m.left", 0},
      {"m.middle", 0},          {"m.right", 1},      {"m.wheel", 2},       {"g.left x", 0.5}, {"g.left y", 1}, {"g.right x", 0.1},
      {"g.right y", -0.75},     {"g.south", 1},      {"g.east", 0},        {"g.west", 0},     {"g.north", 1},  {"g.left trigger", 0.3},
      {"g.right trigger", 0.9}, {"far.south", 0},    {"o.value", 0}};
  for (const auto& [pin, x] : expected) EXPECT_EQ(value(*i, pin), x) << pin;
}

TEST(Devices, AbsentDevicesKeepTheirStateAndWheelAccumulates) {
  DeviceState state;
  apply(read(R"({"keyboard": ["KeyW"], "mouse": {"x": 0.25, "y": 0.5, "left": true, "wheel": 2}, "gamepads": [{"axes": [1]}]})"), state);
  const DeviceState before = state;
  apply(read(R"({"mouse": {"wheel": -3}})"), state);
  EXPECT_EQ(state.mouse, (MouseState{0.25, 0.5, false, false, false, -1})) << "x and y keep their values, buttons are replaced";
  EXPECT_EQ(state.keys, before.keys);
  EXPECT_EQ(state.gamepads, before.gamepads);
  apply(read(R"({"keyboard": [], "gamepads": []})"), state);
  EXPECT_TRUE(state.keys.empty());
  EXPECT_EQ(state.gamepads, DeviceState{}.gamepads);
}

TEST(Devices, PressesObserveOnlyKeysAndButtonsOfTheCircuit) {
  auto i = build(desk);
  ASSERT_TRUE(i);
  const DeviceFeed feed(*i);
  const auto pressed = [&](const char* before, const char* after) {
    DeviceState a, b;
    apply(read(before), a);
    apply(read(after), b);
    return feed.presses(a, b);
  };
  EXPECT_TRUE(pressed("{}", R"({"keyboard": ["KeyW"]})"));
  EXPECT_FALSE(pressed(R"({"keyboard": ["KeyW"]})", R"({"keyboard": ["KeyW"]})"));
  EXPECT_FALSE(pressed(R"({"keyboard": ["KeyW"]})", "{}"));
  EXPECT_FALSE(pressed("{}", R"({"keyboard": ["KeyQ"]})"));
  EXPECT_TRUE(pressed("{}", R"({"mouse": {"left": true}})"));
  EXPECT_FALSE(pressed("{}", R"({"mouse": {"x": 1, "wheel": 4}})"));
  EXPECT_TRUE(pressed("{}", R"({"gamepads": [null, {"buttons": [1]}]})"));
  EXPECT_FALSE(pressed("{}", R"({"gamepads": [{"buttons": [1]}]})"));
}

TEST(Devices, InvalidMessageIsRefusedWithLocation) {
  const auto location = [](const std::string& text) {
    const auto change = read_device_change(text);
    return change ? std::string("accepted") : change.error().problems[0].location;
  };
  EXPECT_EQ(location(R"({"keyboard": "KeyW"})"), "input/keyboard");
  EXPECT_EQ(location(R"({"keyboard": ["KeyW", "K W"]})"), "input/keyboard/1");
  EXPECT_EQ(location(R"({"keyboard": [""]})"), "input/keyboard/0");
  EXPECT_EQ(location(R"({"keyboard": [7]})"), "input/keyboard/0");
  EXPECT_EQ(location(R"({"mouse": 3})"), "input/mouse");
  EXPECT_EQ(location(R"({"mouse": {"x": "left"}})"), "input/mouse/x");
  EXPECT_EQ(location(R"({"mouse": {"z": 1}})"), "input/mouse/z");
  EXPECT_EQ(location(R"({"gamepads": [null, null, null, null, null]})"), "input/gamepads");
  EXPECT_EQ(location(R"({"gamepads": [{"axes": [null]}]})"), "input/gamepads/0/axes/0");
  EXPECT_EQ(location("[]").substr(0, 5), "input");
  EXPECT_EQ(location("{"), "input:1:2");
  std::string many = R"({"keyboard": [)";
  for (int k = 0; k < 65; ++k) many += std::string(k ? "," : "") + "\"F" + std::to_string(k) + "\"";
  EXPECT_EQ(location(many + "]}"), "input/keyboard");
}

TEST(Devices, ReplayRepeatsDeviceInputs) {
  auto a = build(desk), b = build(desk);
  ASSERT_TRUE(a && b);
  a->start_recording();
  const DeviceFeed feed(*a);
  DeviceState state;
  a->run(3);
  apply(read(R"({"keyboard": ["KeyW"], "mouse": {"x": 0.5}})"), state);
  feed.give(state);
  a->run(2);
  ASSERT_TRUE(b->replay(a->recording()));
  b->run(3);
  EXPECT_EQ(value(*b, "w.pressed"), 0);
  b->run(2);
  EXPECT_EQ(value(*b, "w.pressed"), 1);
  EXPECT_EQ(value(*b, "m.x"), 0.5);
}

}  // namespace
}  // namespace ugoki::circuit
