#pragma once
// Binary display frames of docs/studio-protocol.md.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "ugoki/spatial/spatial.h"

namespace ugoki::studio {

namespace frame_flag {
inline constexpr std::uint32_t playing = 1, simulate = 2, live = 4, grab = 8;
}

struct FrameContact {
  Vec3 point, force;        ///< m, N; world
  int character = 0, link = 0;
};

/// What a frame tells of a character besides its links.
struct FrameCharacter {
  std::uint32_t state = 0;  ///< 0 tracking, 1 let go, 2 passive, 3 edit
  Vec3 assist_force, assist_moment;  ///< N, N m
  double assist_over_cap = 0;
  double weight = 0;        ///< N
  Vec3 centre_of_mass;      ///< m
};

/// Writes one frame: begin, then for each character character and its links, then contacts.
class FrameWriter {
 public:
  explicit FrameWriter(std::vector<std::byte>& out) : out_(out) {}
  /// Time, number and flags are zero until set_frame_marks.
  void begin(int characters);
  void grab(const Vec3& point, const Vec3& target);  ///< sets the flag "grab active"
  void character(const FrameCharacter& character, int links);
  void link(const Pose& X_WB);
  void contact(const FrameContact& contact);

 private:
  void u32(std::uint32_t value);
  void f32(double value);
  void vec3(const Vec3& v);
  std::vector<std::byte>& out_;
  std::uint32_t contacts_ = 0;
};

/// Sets the head's time, frame number and flags; "grab active" is kept.
void set_frame_marks(std::span<std::byte> frame, double time, std::uint32_t number, std::uint32_t flags);
[[nodiscard]] double frame_time(std::span<const std::byte> frame);

}  // namespace ugoki::studio
