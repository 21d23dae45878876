#pragma once
// Input by Open Sound Control (OSC 1.0) over UDP: controllers, tablets and other programs press keys and move axes of the content.

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <thread>

#include "ugoki/base/result.h"
#include "ugoki/circuit/devices.h"

namespace ugoki::player_native {

/// Applies the messages of one packet to the state of the devices. Addresses, each with one number unless stated otherwise (types i, f, d,
/// h, T, F):
///   /ugoki/key/CODE                 0 releases the key, other numbers press it; CODE is a KeyboardEvent.code, for example KeyW
///   /ugoki/mouse                    x and y, 0 ... 1
///   /ugoki/mouse/left, middle, right   0 or 1
///   /ugoki/mouse/wheel              notches to add
///   /ugoki/gamepad/PAD/axis/K       -1 ... 1; PAD 0 ... 3, K 0 ... 3
///   /ugoki/gamepad/PAD/button/K     0 ... 1; K 0 ... 16
/// @param packet a message or a bundle; time tags are ignored, so that a bundle acts at once
/// Errors: the packet is malformed; no such address; wrong number or type of arguments. Messages before the error have been applied.
[[nodiscard]] Result<void> apply_osc(std::span<const std::byte> packet, circuit::DeviceState& state);

/// Receives packets on a UDP port of 127.0.0.1 on a thread of its own.
class OscReceiver {
 public:
  /// @param port 0: any free port
  /// @param changed called on the receiver's thread after each packet that changed the devices, with their state as JSON (the fields
  /// keyboard, mouse and gamepads of docs/studio-protocol.md; `wheel` is the change)
  /// Errors: the port is in use.
  [[nodiscard]] static Result<std::unique_ptr<OscReceiver>> listen(std::uint16_t port, std::function<void(std::string)> changed);
  ~OscReceiver();
  OscReceiver(const OscReceiver&) = delete;
  OscReceiver& operator=(const OscReceiver&) = delete;

  [[nodiscard]] std::uint16_t port() const { return port_; }

 private:
  OscReceiver() = default;
  void run();

  int socket_ = -1;
  int wake_[2] = {-1, -1};  // a pipe that ends the thread
  std::uint16_t port_ = 0;
  std::function<void(std::string)> changed_;
  std::thread thread_;
};

}  // namespace ugoki::player_native
