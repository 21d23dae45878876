#include "ugoki/circuit/arena.h"

#include <utility>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace ugoki::circuit {

Arena::Arena(std::size_t words) : size_(words) {
#if defined(__linux__)
  constexpr std::size_t page = 1 << 16;  // bytes; a multiple of the page sizes 4, 16 and 64 KiB
  constexpr std::size_t alignment = 64;  // size of a cache line, bytes
  const std::size_t bytes = (words * sizeof(std::uint64_t) + alignment - 1) / alignment * alignment;
  const std::size_t inner = (bytes + page - 1) / page * page;
  void* mapped = ::mmap(nullptr, inner + 2 * page, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (mapped != MAP_FAILED) {
    mapped_ = mapped;
    mapped_bytes_ = inner + 2 * page;
    auto* const first = static_cast<std::byte*>(mapped) + page;
    if (::mprotect(first, inner, PROT_READ | PROT_WRITE) == 0) {
      // The memory ends where the last page ends: most wrong writes are past the end, and so hit the guard page at once.
      data_ = reinterpret_cast<std::uint64_t*>(first + inner - bytes);
      return;
    }
  }
#endif
  own_.resize(words);
  data_ = own_.data();
}

Arena::~Arena() {
#if defined(__linux__)
  if (mapped_) ::munmap(mapped_, mapped_bytes_);
#endif
}

Arena::Arena(Arena&& other) noexcept { *this = std::move(other); }

Arena& Arena::operator=(Arena&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(size_, other.size_);
  std::swap(mapped_, other.mapped_);
  std::swap(mapped_bytes_, other.mapped_bytes_);
  std::swap(own_, other.own_);
  return *this;
}

}  // namespace ugoki::circuit
