#pragma once
// Messages between the studio and its interpreter over a socket pair: a text, and with it perhaps a block of memory.

#include <chrono>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::studio {

struct ChannelMessage {
  std::string text;
  std::vector<std::byte> block;  ///< empty: none came with it
};

class Channel {
 public:
  Channel() = default;
  explicit Channel(int fd) : fd_(fd) {}  ///< takes the socket
  Channel(Channel&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Channel& operator=(Channel&& other) noexcept;
  Channel(const Channel&) = delete;
  Channel& operator=(const Channel&) = delete;
  ~Channel();

  /// Both ends.
  [[nodiscard]] static Result<std::pair<Channel, Channel>> make_pair();

  [[nodiscard]] int fd() const { return fd_; }
  /// A send that the other end does not take within `time` fails from now on.
  void set_send_limit(std::chrono::milliseconds time);
  /// False if the other end is gone or takes nothing. The block goes through shared memory, whatever its size.
  bool send(std::string_view text, std::span<const std::byte> block = {});
  /// Waits for the next message; none when the other end is gone.
  [[nodiscard]] std::optional<ChannelMessage> receive();
  /// Ends both directions; a receive() that waits returns.
  void shut();

 private:
  int fd_ = -1;
};

}  // namespace ugoki::studio
