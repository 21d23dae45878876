#include "ugoki/studio/frame.h"

#include <cstring>

#include "ugoki/base/check.h"
#include "ugoki/content/display_frame.h"

namespace ugoki::studio {
namespace {

constexpr std::size_t time_at = 8, number_at = 16, flags_at = 20;

template <class T>
void put(std::span<std::byte> frame, std::size_t at, T value) {
  UGOKI_CHECK(at + sizeof value <= frame.size());
  std::memcpy(frame.data() + at, &value, sizeof value);
}

template <class T>
T get(std::span<const std::byte> frame, std::size_t at) {
  T value;
  UGOKI_CHECK(at + sizeof value <= frame.size());
  std::memcpy(&value, frame.data() + at, sizeof value);
  return value;
}

}  // namespace

void set_frame_marks(std::span<std::byte> frame, double time, std::uint32_t number, std::uint32_t flags) {
  put(frame, time_at, time);
  put(frame, number_at, number);
  put(frame, flags_at, (get<std::uint32_t>(frame, flags_at) & content::frame_grab) | flags);
}

double frame_time(std::span<const std::byte> frame) { return get<double>(frame, time_at); }

}  // namespace ugoki::studio
