#pragma once
// From what a user holds in hand to the LSIs keyboard, mouse and gamepad. The text form is the message `input` of docs/studio-protocol.md.

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/circuit/interpreter.h"

namespace ugoki::circuit {

inline constexpr std::size_t most_gamepads = 4;

struct MouseState {
  double x = 0, y = 0;  ///< over the viewport: 0 left, top; 1 right, bottom
  bool left = false, middle = false, right = false;
  double wheel = 0;  ///< notches so far, positive towards the user
  friend bool operator==(const MouseState&, const MouseState&) = default;
};

/// In the standard mapping of the W3C; zeros: there is none.
struct GamepadState {
  std::array<double, 4> axes{};      ///< left x, left y, right x, right y from -1 to 1: to the right and backwards
  std::array<double, 17> buttons{};  ///< 0 to 1
  friend bool operator==(const GamepadState&, const GamepadState&) = default;
};

struct DeviceState {
  std::vector<std::string> keys;  ///< that are down, by KeyboardEvent.code; sorted, each once
  MouseState mouse;
  std::array<GamepadState, most_gamepads> gamepads;
  friend bool operator==(const DeviceState&, const DeviceState&) = default;
};

/// News of some devices; what is absent stays as it was.
struct DeviceChange {
  std::optional<std::vector<std::string>> keys;
  std::optional<MouseState> mouse;  ///< its wheel: notches since the news before
  bool mouse_moved[2] = {};         ///< whether x and y are told
  std::optional<std::array<GamepadState, most_gamepads>> gamepads;
};

/// Reads `keyboard`, `mouse` and `gamepads` of a JSON object; other fields of it are somebody else's.
[[nodiscard]] Result<DeviceChange> read_device_change(std::string_view text, std::string_view place = "input");
void apply(const DeviceChange& change, DeviceState& state);

/// What a circuit reads.
struct DeviceUse {
  std::vector<std::string> keys;  ///< sorted, each once
  bool mouse = false;
  std::vector<int> gamepads;  ///< sorted, each once
  friend bool operator==(const DeviceUse&, const DeviceUse&) = default;
};
/// {"keyboard": ["KeyW"], "mouse": true, "gamepads": [0]}
[[nodiscard]] std::string write_device_use(const DeviceUse& use);

/// The device outputs of one interpreter, which must outlive it; made anew where that is replaced.
class DeviceFeed {
 public:
  DeviceFeed() = default;
  explicit DeviceFeed(Interpreter& interpreter);

  [[nodiscard]] DeviceUse use() const;
  /// Whether the circuit has got just this.
  [[nodiscard]] bool has(const DeviceState& state) const;
  /// Whether a key or a button that the circuit reads goes down from one state to the other.
  [[nodiscard]] bool presses(const DeviceState& before, const DeviceState& after) const;
  /// To be called between ticks.
  void give(const DeviceState& state) const;

 private:
  struct Slot {
    std::string key;  // of the keyboard
    bool mouse = false;
    std::size_t gamepad = most_gamepads;  // most_gamepads: it is none
    std::size_t pin = 0;                  // of mouse or gamepad, in the tables of devices.cpp
    double* number = nullptr;
    [[nodiscard]] double value(const DeviceState& state) const;
    [[nodiscard]] bool is_press() const;
  };
  std::vector<Slot> slots_;
};

}  // namespace ugoki::circuit
