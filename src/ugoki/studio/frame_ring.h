#pragma once
// Display frames from one writing process to one reading process through shared memory. The writer never waits; a reader
// that comes too late misses frames, and never sees a torn one (a sequence lock on each slot).

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
  static constexpr std::size_t slot_bytes = std::size_t{1} << 20;  ///< greatest frame; untouched pages cost nothing

  /// New shared memory; fd() is handed to the other process.
  [[nodiscard]] static Result<FrameRing> make();
  /// The same memory in the other process. Takes `fd`.
  [[nodiscard]] static Result<FrameRing> attach(int fd);
  FrameRing(FrameRing&& other) noexcept;
  FrameRing(const FrameRing&) = delete;
  FrameRing& operator=(const FrameRing&) = delete;
  FrameRing& operator=(FrameRing&&) = delete;
  ~FrameRing();

  [[nodiscard]] int fd() const { return fd_; }
  /// False if the frame is larger than a slot. One writer.
  bool write(std::span<const std::byte> frame);
  /// The next frame that was not read yet, or none. One reader.
  [[nodiscard]] std::optional<std::vector<std::byte>> read();

 private:
  struct Slot;
  struct Shared;
  FrameRing(int fd, Shared* shared) : fd_(fd), shared_(shared) {}
  int fd_ = -1;
  Shared* shared_ = nullptr;
  std::uint64_t next_ = 0;  ///< reader's: number of the next frame
};

}  // namespace ugoki::studio
