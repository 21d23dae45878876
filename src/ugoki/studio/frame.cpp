#include "ugoki/studio/frame.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "ugoki/base/check.h"
#include "ugoki/content/display_frame.h"

namespace ugoki::studio {
namespace {

// Byte offsets in the header of a display frame, and sizes of its parts, bytes.
constexpr std::size_t time_at = 8, number_at = 16, flags_at = 20, characters_at = 24;
constexpr std::size_t head_size = 64, character_size = 56, link_size = 28;

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

void set_frame_header(std::span<std::byte> frame, double time, std::uint32_t number, std::uint32_t flags) {
  put(frame, time_at, time);
  put(frame, number_at, number);
  put(frame, flags_at, (get<std::uint32_t>(frame, flags_at) & content::frame_grab) | flags);
}

void blend_poses(std::span<std::byte> frame, std::span<const std::byte> next, double s) {
  const auto characters = get<std::uint32_t>(frame, characters_at);
  if (get<std::uint32_t>(next, characters_at) != characters) return;
  const auto t = static_cast<float>(s);
  std::size_t at = head_size;
  for (std::uint32_t c = 0; c < characters; ++c) {
    if (at + character_size > std::min(frame.size(), next.size())) return;
    const auto links = get<std::uint32_t>(frame, at);
    if (get<std::uint32_t>(next, at) != links) return;
    at += character_size;
    for (std::uint32_t l = 0; l < links; ++l, at += link_size) {
      if (at + link_size > std::min(frame.size(), next.size())) return;
      float a[7], b[7];
      std::memcpy(a, frame.data() + at, sizeof a);
      std::memcpy(b, next.data() + at, sizeof b);
      // The quaternions q and -q are the same rotation, so b gets the sign that is closer to a. The rotation between neighbouring frames
      // is small, so normalised linear interpolation replaces slerp.
      const float sign = a[3] * b[3] + a[4] * b[4] + a[5] * b[5] + a[6] * b[6] < 0 ? -1.0f : 1.0f;
      float squares = 0;
      for (int i = 0; i < 7; ++i) {
        a[i] += t * ((i < 3 ? 1.0f : sign) * b[i] - a[i]);
        if (i >= 3) squares += a[i] * a[i];
      }
      const float size = std::sqrt(squares);
      for (int i = 3; i < 7 && size > 0; ++i) a[i] /= size;
      std::memcpy(frame.data() + at, a, sizeof a);
    }
  }
}

double frame_time(std::span<const std::byte> frame) { return get<double>(frame, time_at); }

}  // namespace ugoki::studio
