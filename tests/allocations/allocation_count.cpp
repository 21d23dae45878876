#include "allocation_count.h"

#include <atomic>
#include <cstdlib>
#include <new>

namespace {
std::atomic<long> count{0};
}  // namespace

long ugoki::allocations_so_far() { return count.load(); }

// The thread sanitizer has its own operator new. In programs with this sanitizer no allocations are counted.
#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define UGOKI_COUNTS_NOTHING
#endif
#endif

#ifndef UGOKI_COUNTS_NOTHING
void* operator new(std::size_t size) {
  ++count;
  if (void* p = std::malloc(size > 0 ? size : 1)) return p;
  throw std::bad_alloc();
}
void* operator new[](std::size_t size) { return operator new(size); }
// Replaces all forms of operator new whose memory our operator delete frees, including nothrow (used by FCL). Memory from a form that the
// address sanitizer provides could not be freed by our free().
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++count;
  return std::malloc(size > 0 ? size : 1);
}
void* operator new[](std::size_t size, const std::nothrow_t& tag) noexcept { return operator new(size, tag); }
void operator delete(void* p) noexcept { std::free(p); }
void operator delete[](void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
void operator delete[](void* p, std::size_t) noexcept { std::free(p); }
void operator delete(void* p, const std::nothrow_t&) noexcept { std::free(p); }
void operator delete[](void* p, const std::nothrow_t&) noexcept { std::free(p); }
#endif
