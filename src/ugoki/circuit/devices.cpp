#include "ugoki/circuit/devices.h"

#include <algorithm>
#include <cctype>

#include "ugoki/base/number.h"
#include "ugoki/json/fields.h"

namespace ugoki::circuit {
namespace {

using json::Json;

// Limits of an `input` message, far above the values of real devices. Longer lists and key names are refused, larger numbers clamped.
constexpr std::size_t max_keys = 64, max_code_length = 32, max_axes = 32, max_buttons = 64;
constexpr double max_notches = 1000;

struct MousePin {
  const char* name;
  double (*value)(const MouseState&);
  bool press;  ///< true: the pin is a button, which DeviceFeed::presses observes
};
constexpr MousePin mouse_pins[] = {
    {"x", [](const MouseState& m) { return m.x; }, false},
    {"y", [](const MouseState& m) { return m.y; }, false},
    {"left", [](const MouseState& m) { return m.left ? 1.0 : 0.0; }, true},
    {"middle", [](const MouseState& m) { return m.middle ? 1.0 : 0.0; }, true},
    {"right", [](const MouseState& m) { return m.right ? 1.0 : 0.0; }, true},
    {"wheel", [](const MouseState& m) { return m.wheel; }, false},
};

/// Returns 1 if the button is pressed at least half-way, otherwise 0.
double down(double button) { return button >= 0.5 ? 1 : 0; }

struct GamepadPin {
  const char* name;
  double (*value)(const GamepadState&);
  bool press;
};
constexpr GamepadPin gamepad_pins[] = {
    {"left x", [](const GamepadState& g) { return g.axes[0]; }, false},
    {"left y", [](const GamepadState& g) { return 0 - g.axes[1]; }, false},
    {"right x", [](const GamepadState& g) { return g.axes[2]; }, false},
    {"right y", [](const GamepadState& g) { return 0 - g.axes[3]; }, false},
    {"left trigger", [](const GamepadState& g) { return g.buttons[6]; }, false},
    {"right trigger", [](const GamepadState& g) { return g.buttons[7]; }, false},
    {"south", [](const GamepadState& g) { return down(g.buttons[0]); }, true},
    {"east", [](const GamepadState& g) { return down(g.buttons[1]); }, true},
    {"west", [](const GamepadState& g) { return down(g.buttons[2]); }, true},
    {"north", [](const GamepadState& g) { return down(g.buttons[3]); }, true},
};

std::optional<std::vector<std::string>> read_keys(json::Fields& f) {
  const Json* list = f.list("keyboard", max_keys, "keys");
  if (!list) return std::nullopt;
  std::vector<std::string> keys;
  for (const Json& key : *list) {
    const std::string code = key.is_string() ? key.get<std::string>() : std::string();
    const bool good = !code.empty() && code.size() <= max_code_length &&
                      std::ranges::all_of(code, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; });
    if (!good) {
      f.report(ErrorCode::syntax, f.path("keyboard") + "/" + std::to_string(&key - &(*list)[0]), "This is not the name of a key.",
               "Name keys by KeyboardEvent.code: Space, KeyW, ArrowUp.");
      return std::nullopt;
    }
    keys.push_back(code);
  }
  std::ranges::sort(keys);
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  return keys;
}

void read_mouse(json::Fields& f, DeviceChange& out) {
  const Json* object = f.find("mouse");
  if (!object) return;
  json::Fields m(*object, f.path("mouse"), f.problems());
  MouseState& mouse = out.mouse.emplace();
  m.number("x", mouse.x);
  m.number("y", mouse.y);
  m.boolean("left", mouse.left);
  m.boolean("middle", mouse.middle);
  m.boolean("right", mouse.right);
  m.number("wheel", mouse.wheel);
  m.refuse_others();
  out.mouse_moved[0] = m.has("x");
  out.mouse_moved[1] = m.has("y");
  mouse.x = std::clamp(mouse.x, 0.0, 1.0);
  mouse.y = std::clamp(mouse.y, 0.0, 1.0);
  mouse.wheel = std::clamp(mouse.wheel, -max_notches, max_notches);
}

/// Copies the list in field `key` into the first elements of `to`, clamped to [minimum, 1]. Further elements of the list are ignored.
void read_list(json::Fields& f, const char* key, std::size_t maximum, double minimum, std::span<double> to) {
  const Json* list = f.list(key, maximum, key);
  if (!list) return;
  for (std::size_t i = 0; i < list->size(); ++i) {
    const Json& x = (*list)[i];
    if (!x.is_number())
      f.report(ErrorCode::syntax, f.path(key) + "/" + std::to_string(i), "This is not a number.",
               "Give a number for each axis and button.");
    else if (i < to.size())
      to[i] = std::clamp(x.get<double>(), minimum, 1.0);
  }
}

void read_gamepads(json::Fields& f, DeviceChange& out) {
  const Json* list = f.list("gamepads", max_gamepads, "gamepads");
  if (!list) return;
  auto& gamepads = out.gamepads.emplace();
  for (std::size_t i = 0; i < list->size(); ++i) {
    if ((*list)[i].is_null()) continue;
    json::Fields g((*list)[i], f.path("gamepads") + "/" + std::to_string(i), f.problems());
    read_list(g, "axes", max_axes, -1, gamepads[i].axes);
    read_list(g, "buttons", max_buttons, 0, gamepads[i].buttons);
    g.refuse_others();
  }
}

}  // namespace

Result<DeviceChange> read_device_change(std::string_view text, std::string_view location) {
  const Result<Json> json = json::parse_json(text, location);
  if (!json) return fail(json.error());
  Error problems;
  json::Fields f(*json, std::string(location), problems);
  DeviceChange out;
  out.keys = read_keys(f);
  read_mouse(f, out);
  read_gamepads(f, out);
  if (!problems.empty()) return fail(std::move(problems));
  return out;
}

void apply(const DeviceChange& change, DeviceState& state) {
  if (change.keys) state.keys = *change.keys;
  if (change.gamepads) state.gamepads = *change.gamepads;
  if (!change.mouse) return;
  const MouseState before = state.mouse;
  state.mouse = *change.mouse;
  if (!change.mouse_moved[0]) state.mouse.x = before.x;
  if (!change.mouse_moved[1]) state.mouse.y = before.y;
  state.mouse.wheel += before.wheel;
}

std::string write_device_use(const DeviceUse& use) {
  return json::to_text(Json{{"keyboard", use.keys}, {"mouse", use.mouse}, {"gamepads", use.gamepads}});
}

double DeviceFeed::Slot::value(const DeviceState& state) const {
  if (mouse) return mouse_pins[pin].value(state.mouse);
  if (gamepad < max_gamepads) return gamepad_pins[pin].value(state.gamepads[gamepad]);
  return std::ranges::binary_search(state.keys, key) ? 1 : 0;
}

bool DeviceFeed::Slot::is_press() const {
  if (mouse) return mouse_pins[pin].press;
  return gamepad == max_gamepads || gamepad_pins[pin].press;
}

DeviceFeed::DeviceFeed(Interpreter& interpreter) {
  const auto named = [](const auto& pins, const std::string& name) {
    return static_cast<std::size_t>(std::ranges::find_if(pins, [&](const auto& p) { return name == p.name; }) - std::begin(pins));
  };
  for (const DeviceSlot& d : interpreter.devices()) {
    Slot slot;
    slot.number = d.numbers.data();
    if (d.device == "keyboard") {
      slot.key = d.address;
    } else if (d.device == "mouse") {
      slot.mouse = true;
      slot.pin = named(mouse_pins, d.pin);
      if (slot.pin == std::size(mouse_pins)) continue;
    } else if (d.device == "gamepad") {
      const std::optional<long> pad = parse_long(d.address);
      slot.pin = named(gamepad_pins, d.pin);
      if (!pad || *pad < 0 || *pad >= static_cast<long>(max_gamepads) || slot.pin == std::size(gamepad_pins)) continue;
      slot.gamepad = static_cast<std::size_t>(*pad);
    } else {
      continue;
    }
    slots_.push_back(std::move(slot));
  }
}

DeviceUse DeviceFeed::use() const {
  DeviceUse out;
  const auto add = [](auto& list, const auto& x) {
    const auto at = std::ranges::lower_bound(list, x);
    if (at == list.end() || *at != x) list.insert(at, x);
  };
  for (const Slot& s : slots_) {
    if (s.mouse)
      out.mouse = true;
    else if (s.gamepad < max_gamepads)
      add(out.gamepads, static_cast<int>(s.gamepad));
    else
      add(out.keys, s.key);
  }
  return out;
}

bool keep_presses(const DeviceState& before, const DeviceState& between, DeviceState& state) {
  const DeviceState wanted = state;
  for (const std::string& key : between.keys)
    if (!std::ranges::binary_search(before.keys, key) && !std::ranges::binary_search(state.keys, key))
      state.keys.insert(std::ranges::lower_bound(state.keys, key), key);
  for (bool MouseState::* const button : {&MouseState::left, &MouseState::middle, &MouseState::right})
    if (between.mouse.*button && !(before.mouse.*button)) state.mouse.*button = true;
  for (std::size_t pad = 0; pad < max_gamepads; ++pad)
    for (std::size_t b = 0; b < state.gamepads[pad].buttons.size(); ++b) {
      const double pressed = between.gamepads[pad].buttons[b];
      double& now = state.gamepads[pad].buttons[b];
      if (down(pressed) > down(before.gamepads[pad].buttons[b]) && down(now) == 0) now = pressed;
    }
  return !(state == wanted);
}

bool DeviceFeed::has(const DeviceState& state) const {
  return std::ranges::all_of(slots_, [&](const Slot& s) { return *s.number == s.value(state); });
}

bool DeviceFeed::presses(const DeviceState& before, const DeviceState& after) const {
  return std::ranges::any_of(slots_, [&](const Slot& s) { return s.is_press() && s.value(before) == 0 && s.value(after) != 0; });
}

void DeviceFeed::give(const DeviceState& state) const {
  for (const Slot& s : slots_) *s.number = s.value(state);
}

}  // namespace ugoki::circuit
