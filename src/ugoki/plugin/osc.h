#pragma once
// Receives Open Sound Control 1.0 over UDP, from this computer only. The received values feed the `osc` LSIs of a circuit.
// Source of the packet format: The Open Sound Control 1.0 Specification (opensoundcontrol.org).

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::plugin {

/// Reads a packet: a message or a bundle of messages. Calls visit(address, numbers) for each message. `numbers` are the arguments that are
/// floats, doubles, integers or booleans (1, 0); values that are not finite become 0, and arguments of other types are skipped.
/// @return false if the packet is damaged; the messages before the damage have been visited
bool read_osc(std::span<const std::byte> packet,
              const std::function<void(std::string_view address, std::span<const double> numbers)>& visit);

/// A UDP socket that listens for OSC packets. Movable; closes the socket when it is destroyed.
class OscReceiver {
 public:
  /// Listens on 127.0.0.1. Error: the port cannot be opened, for example because it is in use. @param port 0: any free port
  [[nodiscard]] static Result<OscReceiver> open(std::uint16_t port);
  OscReceiver(OscReceiver&& other) noexcept;
  OscReceiver(const OscReceiver&) = delete;
  OscReceiver& operator=(const OscReceiver&) = delete;
  OscReceiver& operator=(OscReceiver&&) = delete;
  ~OscReceiver();

  [[nodiscard]] std::uint16_t port() const { return port_; }
  /// Reads the packets that have arrived since the last call, at most 1000, and visits their messages (see read_osc). Does not wait.
  void poll(const std::function<void(std::string_view address, std::span<const double> numbers)>& visit);

 private:
  OscReceiver(int socket, std::uint16_t port) : socket_(socket), port_(port) {}
  int socket_ = -1;
  std::uint16_t port_ = 0;
};

}  // namespace ugoki::plugin
