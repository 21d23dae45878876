#pragma once
// Ring buffer in shared memory that passes display frames from one writing process to one reading process. The writer never waits.
// A slow reader misses frames, but never sees a half-written one: each slot has a sequence lock.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::studio {

class FrameRing {
 public:
  static constexpr std::size_t slot_count = 16;
  static constexpr std::size_t slot_bytes = std::size_t{1} << 20;  ///< maximum size of a frame; unwritten memory pages cost nothing

  /// Creates the shared memory. Pass fd() to the other process.
  [[nodiscard]] static Result<FrameRing> make();
  /// Maps the memory in the other process. Takes ownership of `fd`, also on failure.
  [[nodiscard]] static Result<FrameRing> attach(int fd);
  FrameRing(FrameRing&& other) noexcept;
  FrameRing(const FrameRing&) = delete;
  FrameRing& operator=(const FrameRing&) = delete;
  FrameRing& operator=(FrameRing&&) = delete;
  ~FrameRing();

  [[nodiscard]] int fd() const { return fd_; }
  /// Writes a frame. Returns false if it is larger than a slot. To be called by one writer only.
  bool write(std::span<const std::byte> frame);
  /// Returns the next unread frame; nullopt if there is none. To be called by one reader only.
  [[nodiscard]] std::optional<std::vector<std::byte>> read();

 private:
  struct Slot;
  struct Shared;
  FrameRing(int fd, Shared* shared) : fd_(fd), shared_(shared) {}
  int fd_ = -1;
  Shared* shared_ = nullptr;
  std::uint64_t next_ = 0;  ///< reader's state: index of the next frame to read
};

}  // namespace ugoki::studio
