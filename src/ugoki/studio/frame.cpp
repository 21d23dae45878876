#include "ugoki/studio/frame.h"

#include <bit>
#include <cstring>

#include "ugoki/base/check.h"

namespace ugoki::studio {
namespace {

static_assert(std::endian::native == std::endian::little, "frames are little-endian");

constexpr std::uint32_t magic = 0x46474b55, version = 1;
constexpr std::size_t head_size = 64, time_at = 8, number_at = 16, flags_at = 20, contacts_at = 28, grab_at = 32;

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

void FrameWriter::u32(std::uint32_t value) {
  const auto* p = reinterpret_cast<const std::byte*>(&value);
  out_.insert(out_.end(), p, p + sizeof value);
}

void FrameWriter::f32(double value) { u32(std::bit_cast<std::uint32_t>(static_cast<float>(value))); }

void FrameWriter::vec3(const Vec3& v) {
  f32(v.x);
  f32(v.y);
  f32(v.z);
}

void FrameWriter::begin(int characters) {
  out_.assign(head_size, std::byte{0});
  contacts_ = 0;
  put(out_, 0, magic);
  put(out_, 4, version);
  put(out_, 24, static_cast<std::uint32_t>(characters));
}

void FrameWriter::grab(const Vec3& point, const Vec3& target) {
  const float values[6] = {static_cast<float>(point.x),  static_cast<float>(point.y),  static_cast<float>(point.z),
                           static_cast<float>(target.x), static_cast<float>(target.y), static_cast<float>(target.z)};
  std::memcpy(out_.data() + grab_at, values, sizeof values);
  put(out_, flags_at, get<std::uint32_t>(out_, flags_at) | frame_flag::grab);
}

void FrameWriter::character(const FrameCharacter& c, int links) {
  u32(static_cast<std::uint32_t>(links));
  u32(c.state);
  vec3(c.assist_force);
  vec3(c.assist_moment);
  f32(c.assist_over_cap);
  f32(c.weight);
  vec3(c.centre_of_mass);
  f32(0);
}

void FrameWriter::link(const Pose& X_WB) {
  vec3(X_WB.p);
  const Quat q = to_quat(X_WB.R);
  f32(q.w);
  f32(q.x);
  f32(q.y);
  f32(q.z);
}

void FrameWriter::contact(const FrameContact& c) {
  vec3(c.point);
  vec3(c.force);
  u32(static_cast<std::uint32_t>(c.character));
  u32(static_cast<std::uint32_t>(c.link));
  put(out_, contacts_at, ++contacts_);
}

void set_frame_marks(std::span<std::byte> frame, double time, std::uint32_t number, std::uint32_t flags) {
  put(frame, time_at, time);
  put(frame, number_at, number);
  put(frame, flags_at, (get<std::uint32_t>(frame, flags_at) & frame_flag::grab) | flags);
}

double frame_time(std::span<const std::byte> frame) { return get<double>(frame, time_at); }

}  // namespace ugoki::studio
