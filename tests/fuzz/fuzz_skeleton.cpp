// Fuzz target of the body builder: the bytes are the structure of a skeleton (parents, names, offsets, DOFs) with two frames.
#include <array>
#include <cmath>
#include <string>

#include "fuzz_targets.h"
#include "ugoki/base/check.h"
#include "ugoki/body/body.h"

namespace ugoki {
namespace {

/// Reads the bytes one after the other; after the last byte it returns zeros.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  [[nodiscard]] bool more() const { return at_ < size_; }
  int next() { return at_ < size_ ? data_[at_++] : 0; }

 private:
  const std::uint8_t* data_;
  std::size_t size_, at_ = 0;
};

constexpr std::array names = {"",         "Hips",     "hip",     "Spine",         "Chest",    "Neck",      "Head",    "LeftUpLeg",
                              "LeftLeg",  "LeftFoot", "LeftToe", "RightUpLeg",    "RightLeg", "RightFoot", "LeftArm", "LeftForeArm",
                              "LeftHand", "RightArm", "tail",    "Bip01 L Thigh", "joint",    "\xc3\xa9"};
constexpr std::array lengths = {0.0, 1e-9, 1e-3, 0.05, 0.1, 0.3, 0.5, 2.0, 100.0, 1e6};  // m

double length_of(int byte) { return lengths[static_cast<std::size_t>(byte) / 2 % lengths.size()] * (byte % 2 == 0 ? 1 : -1); }

}  // namespace

/// Six bytes are one joint: parent, name, offset (three bytes), and DOFs (two bits), translation and end site (one bit each).
void fuzz_skeleton(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t max_joints = 60;
  constexpr int frames = 2;
  Bytes bytes(data, size);
  MeasuredMotion motion;
  motion.name = motion.source = "fuzz";
  motion.frames = frames;
  while (bytes.more() && motion.skeleton.joints.size() < max_joints) {
    SkeletonJoint joint;
    const int index = static_cast<int>(motion.skeleton.joints.size());
    joint.parent = index == 0 ? -1 : bytes.next() % (index + 1) - 1;
    joint.name = names[static_cast<std::size_t>(bytes.next()) % names.size()];
    joint.offset = {length_of(bytes.next()), length_of(bytes.next()), length_of(bytes.next())};
    const int flags = bytes.next();
    constexpr std::array<Vec3, 3> axes = {Vec3{0, 0, 1}, Vec3{1, 0, 0}, Vec3{0, 1, 0}};
    for (int i = 0; i < flags % 4; ++i) joint.dofs.push_back({axes[static_cast<std::size_t>(i)], (flags & 64) != 0, -1, 1});
    joint.translates = (flags & 16) != 0;
    if ((flags & 32) != 0) joint.end_sites.push_back({length_of(flags), 0, length_of(flags / 3)});
    motion.skeleton.joints.push_back(joint);
  }
  if (motion.skeleton.joints.empty()) return;
  for (int frame = 0; frame < frames; ++frame)
    for (const SkeletonJoint& joint : motion.skeleton.joints) {
      motion.translations.push_back(joint.offset + Vec3{0.01 * frame, 0, 0});
      const double half = joint.dofs.empty() ? 0 : 0.1 * frame;  // rad
      motion.rotations.push_back({std::cos(half), 0, 0, std::sin(half)});
    }
  const Result<body::Body> made = body::make_body(motion);
  if (made) {
    UGOKI_CHECK(made->mechanism != nullptr && std::isfinite(made->mechanism->mass()) && made->mechanism->mass() > 0);
    return;
  }
  for (const Problem& p : made.error().problems) UGOKI_CHECK(p.message.ends_with('.'));
  UGOKI_CHECK(!made.error().problems.empty());
}

}  // namespace ugoki
