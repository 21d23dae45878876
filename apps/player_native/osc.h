#pragma once
// Input by Open Sound Control (OSC 1.0) over UDP: controllers, tablets and other programs act as keyboard, mouse and gamepads.

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <thread>

#include "ugoki/base/result.h"
#include "ugoki/circuit/devices.h"

namespace ugoki::player_native {

/// Applies the messages of one packet to the state of the devices. Each message has one argument, a number of type i, f, d or h, or a
/// truth value of type T (1) or F (0); only /ugoki/mouse has two. Addresses and their arguments:
///   /ugoki/key/CODE                 0 releases the key, other numbers press it; CODE is a KeyboardEvent.code, for example KeyW
///   /ugoki/mouse                    x and y, 0 ... 1
///   /ugoki/mouse/left, middle, right   0 or 1
///   /ugoki/mouse/wheel              notches by which the wheel turns
///   /ugoki/gamepad/PAD/axis/K       -1 ... 1; PAD 0 ... 3, K 0 ... 3
///   /ugoki/gamepad/PAD/button/K     0 ... 1; K 0 ... 16
/// @param packet a message or a bundle (list of messages); time tags are ignored, so a bundle acts at once
/// Errors: the packet is malformed; no such address; wrong number or type of arguments. Messages before the error have been applied.
[[nodiscard]] Result<void> apply_osc(std::span<const std::byte> packet, circuit::DeviceState& state);

/// Receives OSC packets on a UDP port of 127.0.0.1, on a separate thread.
class OscReceiver {
 public:
  /// @param port 0: any free port
  /// @param changed called on the receiver's thread after each packet that changed the devices. Its argument is the state of the devices as
  /// JSON message `input` (docs/studio-protocol.md), in which `wheel` is the turn since the last call, in notches
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
  int wake_[2] = {-1, -1};  // pipe; a byte written to it ends the thread
  std::uint16_t port_ = 0;
  std::function<void(std::string)> changed_;
  std::thread thread_;
};

}  // namespace ugoki::player_native
