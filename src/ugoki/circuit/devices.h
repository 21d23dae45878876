#pragma once
// State of the user's input devices, and its transfer to the LSIs keyboard, mouse and gamepad of a circuit. The text form of the state is
// the message `input` of docs/studio-protocol.md.

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/circuit/interpreter.h"

namespace ugoki::circuit {

inline constexpr std::size_t max_gamepads = 4;

struct MouseState {
  double x = 0, y = 0;  ///< position in the viewport: (0, 0) is the top left corner, (1, 1) the bottom right one
  bool left = false, middle = false, right = false;  ///< true: the button is pressed
  double wheel = 0;                                  ///< notches turned so far, positive towards the user
  friend bool operator==(const MouseState&, const MouseState&) = default;
};

/// A gamepad in the W3C standard gamepad mapping. All zero: no gamepad is connected.
struct GamepadState {
  std::array<double, 4> axes{};      ///< left x, left y, right x, right y, each from -1 to 1; positive to the right and backwards
  std::array<double, 17> buttons{};  ///< state of each button, 0 (released) to 1 (fully pressed)
  friend bool operator==(const GamepadState&, const GamepadState&) = default;
};

struct DeviceState {
  std::vector<std::string> keys;  ///< pressed keys by KeyboardEvent.code; sorted, no duplicates
  MouseState mouse;
  std::array<GamepadState, max_gamepads> gamepads;
  friend bool operator==(const DeviceState&, const DeviceState&) = default;
};

/// New state of some devices. Devices without a value keep their state.
struct DeviceChange {
  std::optional<std::vector<std::string>> keys;
  std::optional<MouseState> mouse;  ///< its `wheel` is the change since the previous message, notches
  bool mouse_moved[2] = {};         ///< whether `mouse` specifies x and y; an unspecified coordinate keeps its value
  std::optional<std::array<GamepadState, max_gamepads>> gamepads;
};

/// Reads the fields `keyboard`, `mouse` and `gamepads` of a JSON object and ignores its other fields.
[[nodiscard]] Result<DeviceChange> read_device_change(std::string_view text, std::string_view location = "input");
void apply(const DeviceChange& change, DeviceState& state);
/// Presses in `state` again the keys and buttons that are released in `before` and in `state`, but pressed in `between`.
/// @return false if there are none
bool keep_presses(const DeviceState& before, const DeviceState& between, DeviceState& state);

/// The devices that a circuit reads.
struct DeviceUse {
  std::vector<std::string> keys;  ///< keys by KeyboardEvent.code; sorted, no duplicates
  bool mouse = false;
  std::vector<int> gamepads;  ///< indices of the gamepads; sorted, no duplicates
  friend bool operator==(const DeviceUse&, const DeviceUse&) = default;
};
/// JSON: {"keyboard": ["KeyW"], "mouse": true, "gamepads": [0]}
[[nodiscard]] std::string write_device_use(const DeviceUse& use);

/// Writes the state of the devices into the device LSIs of one interpreter. The interpreter must outlive the feed; a new interpreter
/// needs a new feed.
class DeviceFeed {
 public:
  DeviceFeed() = default;
  explicit DeviceFeed(Interpreter& interpreter);

  [[nodiscard]] DeviceUse use() const;
  /// True if the outputs of the device LSIs already equal this state.
  [[nodiscard]] bool has(const DeviceState& state) const;
  /// True if a key or button that the circuit reads is released in `before` and pressed in `after`.
  [[nodiscard]] bool presses(const DeviceState& before, const DeviceState& after) const;
  /// Writes the state to the outputs of the device LSIs. Call it between ticks only.
  void give(const DeviceState& state) const;

 private:
  struct Slot {
    std::string key;  // KeyboardEvent.code of a key; empty: not a keyboard slot
    bool mouse = false;
    std::size_t gamepad = max_gamepads;  // index of the gamepad; max_gamepads: not a gamepad slot
    std::size_t pin = 0;                 // mouse or gamepad: index into mouse_pins or gamepad_pins of devices.cpp
    double* number = nullptr;            // the output of the device LSI that the slot writes
    [[nodiscard]] double value(const DeviceState& state) const;
    [[nodiscard]] bool is_press() const;
  };
  std::vector<Slot> slots_;
};

}  // namespace ugoki::circuit
