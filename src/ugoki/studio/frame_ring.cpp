#include "ugoki/studio/frame_ring.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace ugoki::studio {

// Slot n % slot_count contains frame n. Its sequence is 2 n + 1 while frame n is being written and 2 n + 2 when it is complete.
struct FrameRing::Slot {
  std::atomic<std::uint64_t> sequence;
  std::atomic<std::uint64_t> size;
  std::atomic<std::uint64_t> words[slot_bytes / 8];
};

struct FrameRing::Shared {
  std::atomic<std::uint64_t> written;  ///< number of frames written so far
  Slot slots[slot_count];
};

static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

namespace {
std::unexpected<Error> failed(const char* action) {
  return fail(ErrorCode::io, "shared memory", std::string("The memory for frames cannot be ") + action + ": " + std::strerror(errno) + ".",
              "Free some memory and restart the studio.");
}
}  // namespace

Result<FrameRing> FrameRing::make() {
  const int fd = memfd_create("ugoki-frames", MFD_CLOEXEC);
  if (fd < 0) return failed("created");
  if (ftruncate(fd, sizeof(Shared)) != 0) {
    close(fd);
    return failed("resized");
  }
  return attach(fd);
}

Result<FrameRing> FrameRing::attach(int fd) {
  void* memory = mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  if (memory == MAP_FAILED) {
    close(fd);
    return failed("mapped");
  }
  return FrameRing(fd, static_cast<Shared*>(memory));  // new memory is zero, which means: no frame written
}

FrameRing::FrameRing(FrameRing&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), shared_(std::exchange(other.shared_, nullptr)), next_(other.next_) {}

FrameRing::~FrameRing() {
  if (shared_ != nullptr) munmap(shared_, sizeof(Shared));
  if (fd_ >= 0) close(fd_);
}

bool FrameRing::write(std::span<const std::byte> frame) {
  if (frame.size() > slot_bytes) return false;
  const std::uint64_t n = shared_->written.load(std::memory_order_relaxed);
  Slot& slot = shared_->slots[n % slot_count];
  slot.sequence.store(2 * n + 1, std::memory_order_relaxed);
  std::atomic_thread_fence(std::memory_order_release);
  slot.size.store(frame.size(), std::memory_order_relaxed);
  for (std::size_t at = 0; at < frame.size(); at += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, frame.data() + at, std::min<std::size_t>(8, frame.size() - at));
    slot.words[at / 8].store(word, std::memory_order_relaxed);
  }
  slot.sequence.store(2 * n + 2, std::memory_order_release);
  shared_->written.store(n + 1, std::memory_order_release);
  return true;
}

std::optional<std::vector<std::byte>> FrameRing::read() {
  while (true) {
    const std::uint64_t written = shared_->written.load(std::memory_order_acquire);
    if (next_ >= written) return std::nullopt;
    // The writer may be overwriting the slot after the newest frame, so at most slot_count - 1 frames can still be read.
    if (written - next_ >= slot_count) next_ = written - slot_count + 1;
    const std::uint64_t n = next_++;
    const Slot& slot = shared_->slots[n % slot_count];
    if (slot.sequence.load(std::memory_order_acquire) != 2 * n + 2) continue;
    const std::uint64_t size = slot.size.load(std::memory_order_relaxed);
    if (size > slot_bytes) continue;  // the other process wrote a corrupt size; reading that many bytes could crash this process
    std::vector<std::byte> frame(size);
    for (std::size_t at = 0; at < size; at += 8) {
      const std::uint64_t word = slot.words[at / 8].load(std::memory_order_relaxed);
      std::memcpy(frame.data() + at, &word, std::min<std::size_t>(8, size - at));
    }
    std::atomic_thread_fence(std::memory_order_acquire);
    if (slot.sequence.load(std::memory_order_relaxed) == 2 * n + 2) return frame;
  }
}

}  // namespace ugoki::studio
