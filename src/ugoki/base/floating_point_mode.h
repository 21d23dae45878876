#pragma once
// The floating-point mode of a thread: direction of rounding, treatment of subnormal numbers, precision and trapped exceptions. Foreign
// code may change the mode (fesetround, a library linked with -ffast-math); afterwards equal inputs no longer give equal bits.

#include <cfenv>
#include <cstdint>

namespace ugoki {

/// Mode of the calling thread, for comparison and set_floating_point_mode() only. Reads two registers.
[[nodiscard]] inline std::uint64_t floating_point_mode() {
#if defined(__x86_64__)
  constexpr std::uint32_t flags = 0x3f;  // record of exceptions that have occurred; not part of the mode (Intel SDM vol. 1, 10.2.3)
  std::uint32_t vector = 0;
  std::uint16_t x87 = 0;
  __asm__ volatile("stmxcsr %0" : "=m"(vector));
  __asm__ volatile("fnstcw %0" : "=m"(x87));
  return static_cast<std::uint64_t>(vector & ~flags) << 16 | x87;
#else
  return static_cast<std::uint64_t>(std::fegetround());
#endif
}

/// Sets the mode of the calling thread. @param mode a value that floating_point_mode() returned
inline void set_floating_point_mode(std::uint64_t mode) {
#if defined(__x86_64__)
  const auto vector = static_cast<std::uint32_t>(mode >> 16);
  const auto x87 = static_cast<std::uint16_t>(mode);
  __asm__ volatile("ldmxcsr %0" : : "m"(vector));
  __asm__ volatile("fldcw %0" : : "m"(x87));
#else
  std::fesetround(static_cast<int>(mode));
#endif
}

/// Restores the mode of the thread at the end of a scope that calls foreign code.
class KeepFloatingPointMode {
 public:
  KeepFloatingPointMode() = default;
  KeepFloatingPointMode(const KeepFloatingPointMode&) = delete;
  KeepFloatingPointMode& operator=(const KeepFloatingPointMode&) = delete;
  ~KeepFloatingPointMode() {
    if (floating_point_mode() != mode_) set_floating_point_mode(mode_);
  }

 private:
  std::uint64_t mode_ = floating_point_mode();
};

}  // namespace ugoki
