#pragma once
// Interface through which the session sends to the pages. The server implements it with sockets, tests with lists.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace ugoki::studio {

using ClientId = std::uint64_t;  ///< identifies one WebSocket connection; never reused
using FrameBytes = std::shared_ptr<const std::vector<std::byte>>;

/// Sends messages and frames to the pages. All members are thread-safe and never wait for a page. Texts are the JSON messages of
/// docs/studio-protocol.md.
class Outbox {
 public:
  virtual ~Outbox() = default;
  virtual void send(ClientId client, std::string text) = 0;
  virtual void broadcast(std::string text) = 0;
  /// Sends a display frame to all pages; a page that is too slow gets the newest frame only.
  virtual void broadcast_frame(FrameBytes frame) = 0;
  virtual void send_frame(ClientId client, FrameBytes frame) = 0;
};

}  // namespace ugoki::studio
