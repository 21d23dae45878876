#pragma once
// Open Sound Control 1.0 over UDP, from this computer only: numbers for the LSIs `osc` of a circuit.

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::plugin {

/// Reads a packet (a message or a bundle); visit(address, numbers): floats, doubles, whole numbers and truth values, others are left out.
/// False: it is damaged; what came before the damage was visited.
bool read_osc(std::span<const std::byte> packet,
              const std::function<void(std::string_view address, std::span<const double> numbers)>& visit);

class OscReceiver {
 public:
  /// Listens on 127.0.0.1. @param port 0: any free one
  [[nodiscard]] static Result<OscReceiver> open(std::uint16_t port);
  OscReceiver(OscReceiver&& other) noexcept;
  OscReceiver(const OscReceiver&) = delete;
  OscReceiver& operator=(const OscReceiver&) = delete;
  OscReceiver& operator=(OscReceiver&&) = delete;
  ~OscReceiver();

  [[nodiscard]] std::uint16_t port() const { return port_; }
  /// Visits all that came since; never waits.
  void poll(const std::function<void(std::string_view address, std::span<const double> numbers)>& visit);

 private:
  OscReceiver(int socket, std::uint16_t port) : socket_(socket), port_(port) {}
  int socket_ = -1;
  std::uint16_t port_ = 0;
};

}  // namespace ugoki::plugin
