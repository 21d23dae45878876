#include "ugoki/content/display_frame.h"

#include <cstring>

namespace ugoki::content {
namespace {

class Writer {
 public:
  explicit Writer(std::vector<std::byte>& out) : out_(out) { out_.clear(); }
  void u32(std::uint32_t x) { put(x); }
  void f64(double x) { put(x); }
  void f32(double x) { put(static_cast<float>(x)); }
  void f32(const Vec3& v) {
    f32(v.x);
    f32(v.y);
    f32(v.z);
  }

 private:
  template <class T>
  void put(T x) {
    const std::size_t at = out_.size();
    out_.resize(at + sizeof x);
    std::memcpy(out_.data() + at, &x, sizeof x);
  }
  std::vector<std::byte>& out_;
};

}  // namespace

void encode_frame(const DisplayFrame& frame, std::uint32_t number, std::uint32_t flags, std::vector<std::byte>& out) {
  Writer w(out);
  w.u32(0x46474b55);  // the characters "UKGF"
  w.u32(1);           // version of the format
  w.f64(frame.time);
  w.u32(number);
  w.u32(flags | (frame.grabbed ? frame_grab : 0u));
  w.u32(static_cast<std::uint32_t>(frame.characters.size()));
  w.u32(static_cast<std::uint32_t>(frame.contacts.size()));
  w.f32(frame.grab_point);
  w.f32(frame.grab_target);
  w.u32(0);  // count of closest pairs; the host program of a viewer adds them
  w.u32(1);  // the contacts are followed by their normals
  for (const DisplayCharacter& c : frame.characters) {
    w.u32(static_cast<std::uint32_t>(c.links.size()));
    w.u32(static_cast<std::uint32_t>(c.state));
    w.f32(c.assist_force);
    w.f32(c.assist_moment);
    w.f32(c.assist_ratio);
    w.f32(c.weight);
    w.f32(c.centre_of_mass);
    w.f32(0.0);  // reserved
    for (const DisplayPose& x : c.links) {
      w.f32(x.p);
      w.f32(x.r.w);
      w.f32(x.r.vec());
    }
  }
  for (const DisplayContact& c : frame.contacts) {
    w.f32(c.point);
    w.f32(c.force);
    w.u32(static_cast<std::uint32_t>(c.character));
    w.u32(static_cast<std::uint32_t>(c.link));
  }
  for (const DisplayContact& c : frame.contacts) w.f32(c.normal);
}

}  // namespace ugoki::content
