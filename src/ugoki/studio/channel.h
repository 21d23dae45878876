#pragma once
// Messages between the studio and its interpreter over a socket pair. A message is a text with an optional block of bytes.

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
  std::vector<std::byte> block;  ///< bytes sent with the text; empty: no block
};

class Channel {
 public:
  Channel() = default;
  explicit Channel(int fd) : fd_(fd) {}  ///< takes ownership of the socket
  Channel(Channel&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Channel& operator=(Channel&& other) noexcept;
  Channel(const Channel&) = delete;
  Channel& operator=(const Channel&) = delete;
  ~Channel();

  /// Returns the two ends of a new socket pair.
  [[nodiscard]] static Result<std::pair<Channel, Channel>> make_pair();

  [[nodiscard]] int fd() const { return fd_; }
  /// Sets the send timeout: a later send() fails if the other end does not read the message within `time`.
  void set_send_limit(std::chrono::milliseconds time);
  /// Sends a message. Returns false if the other end is closed or does not read in time, or if `text` exceeds 64 MiB.
  /// A block of any size is passed as a memory file (memfd), not through the socket.
  bool send(std::string_view text, std::span<const std::byte> block = {});
  /// Waits for the next message. Returns nullopt if the other end is closed or the message cannot be read.
  [[nodiscard]] std::optional<ChannelMessage> receive();
  /// Returns true if the other end is closed: its process has ended or is ending.
  [[nodiscard]] bool other_end_closed() const;
  /// Shuts down both directions; a waiting receive() returns.
  void shut();

 private:
  int fd_ = -1;
};

}  // namespace ugoki::studio
