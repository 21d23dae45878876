#pragma once
// How the session reaches the pages. The server implements it with sockets, tests with lists.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace ugoki::studio {

using ClientId = std::uint64_t;  ///< one WebSocket; never reused
using FrameBytes = std::shared_ptr<const std::vector<std::byte>>;

/// All members may be called from any thread and never wait for a page.
class Outbox {
 public:
  virtual ~Outbox() = default;
  virtual void send(ClientId client, std::string text) = 0;
  virtual void broadcast(std::string text) = 0;
  /// A display frame; a page that is too slow gets the newest one only.
  virtual void broadcast_frame(FrameBytes frame) = 0;
  virtual void send_frame(ClientId client, FrameBytes frame) = 0;
};

}  // namespace ugoki::studio
