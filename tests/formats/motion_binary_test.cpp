// Binary form of motions: the round trip keeps every bit, and damage is detected.
#include "ugoki/formats/motion_binary.h"

#include <gtest/gtest.h>

#include <cstring>

#include "ugoki/base/hash.h"
#include "ugoki/motion/torques.h"

namespace ugoki::formats {
namespace {

Motion a_motion() {
  Motion m;
  m.name = "walk";
  m.source = "made here";
  m.mechanism = "person";
  m.rate = 59.94;
  m.frames = 3;
  m.nq = 2;
  m.q = {0.1, -0.0, 1e-300, 3.0, 1.0 / 3, -7};
  m.contacts = {{"left foot", {1, 0, 1}}, {"right foot", {0, 1, 1}}};
  m.cyclic = true;
  return m;
}

MeasuredMotion a_measured_motion() {
  MeasuredMotion m;
  m.name = "m";
  m.source = "m.bvh";
  m.rate = 120;
  m.frames = 2;
  m.skeleton.name = "s";
  m.skeleton.unit = 0.01;
  m.skeleton.mass = 71;
  SkeletonJoint root, arm;
  root.name = "root";
  root.translates = true;
  root.end_sites = {{1, 2, 3}};
  arm.name = "arm";
  arm.parent = 0;
  arm.offset = {0.1, 0.2, 0.3};
  arm.rotation_order = "XY";
  arm.dofs = {{{1, 0, 0}, true, -1, std::numeric_limits<double>::infinity()}, {{0, 1, 0}}};
  m.skeleton.joints = {root, arm};
  m.translations = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {-0.0, 1e-310, 12}};
  m.rotations = {{}, {0, 1, 0, 0}, {0.6, 0, 0.8, 0}, {}};
  return m;
}

TEST(MotionBinary, RoundTripKeepsEveryBit) {
  const Motion m = a_motion();
  const auto back = read_motion(write_motion(m), "x");
  ASSERT_TRUE(back.has_value()) << back.error().text();
  EXPECT_EQ(back->name, m.name);
  EXPECT_EQ(back->source, m.source);
  EXPECT_EQ(back->mechanism, m.mechanism);
  EXPECT_EQ(back->rate, m.rate);
  EXPECT_EQ(back->frames, 3);
  EXPECT_EQ(back->nq, 2);
  EXPECT_TRUE(back->cyclic);
  ASSERT_EQ(back->q.size(), m.q.size());
  EXPECT_EQ(std::memcmp(back->q.data(), m.q.data(), m.q.size() * 8), 0);
  ASSERT_EQ(back->contacts.size(), 2U);
  EXPECT_EQ(back->contacts[1].link, "right foot");
  EXPECT_EQ(back->contacts[1].on, m.contacts[1].on);
  EXPECT_EQ(write_motion(*back), write_motion(m));
}

TEST(MotionBinary, ComputedMotionsStayComputedUntilTheyAreEdited) {
  Motion m = a_motion();
  EXPECT_FALSE(is_computed(m));
  EXPECT_FALSE(is_computed(read_motion(write_motion(m), "x").value()));
  mark_computed(m);
  EXPECT_TRUE(is_computed(m));
  EXPECT_EQ(torques_of(m), nullptr);
  Motion back = read_motion(write_motion(m), "x").value();
  EXPECT_TRUE(is_computed(back));
  EXPECT_EQ(write_motion(back), write_motion(m));
  back.q[2] += 1e-9;
  EXPECT_FALSE(is_computed(back));
  EXPECT_FALSE(is_computed(read_motion(write_motion(back), "x").value()));
}

TEST(MotionBinary, MeasuredMotionRoundTripKeepsEveryBit) {
  const MeasuredMotion m = a_measured_motion();
  const auto bytes = write_measured_motion(m);
  const auto back = read_measured_motion(bytes, "x");
  ASSERT_TRUE(back.has_value()) << back.error().text();
  EXPECT_EQ(write_measured_motion(*back), bytes);
  ASSERT_EQ(back->joint_count(), 2);
  EXPECT_EQ(back->skeleton.joints[1].rotation_order, "XY");
  EXPECT_EQ(back->skeleton.joints[1].dofs[0].upper, std::numeric_limits<double>::infinity());
  EXPECT_EQ(back->skeleton.joints[0].end_sites[0], (Vec3{1, 2, 3}));
  EXPECT_TRUE(back->skeleton.joints[0].translates);
  EXPECT_EQ(back->translations[2], (Vec3{7, 8, 9}));
  EXPECT_EQ(back->rotations[2], (Quat{0.6, 0, 0.8, 0}));
  EXPECT_EQ(back->skeleton.mass, 71);
}

/// The bytes with the correct size and checksum, so that a test reaches the checks after the checksum.
std::vector<std::byte> with_checksum(std::vector<std::byte> bytes) {
  Hash64 hash;
  hash.add_bytes(bytes.data() + 32, bytes.size() - 32);
  const std::uint64_t size = bytes.size() - 32, sum = hash.value();
  std::memcpy(bytes.data() + 16, &size, 8);
  std::memcpy(bytes.data() + 24, &sum, 8);
  return bytes;
}

TEST(MotionBinary, LayoutMatchesDocumentation) {
  const auto bytes = write_motion(a_motion());
  EXPECT_EQ(std::memcmp(bytes.data(), "UGOKIMOT\1\0\0\0\0\0\0\0", 16), 0);
  EXPECT_EQ(std::memcmp(bytes.data() + 32, "\4\0\0\0\0\0\0\0walk", 12), 0);
  EXPECT_EQ(with_checksum(bytes), bytes);
}

TEST(MotionBinary, DetectsEveryTruncationAndFlippedBit) {
  for (const auto& good : {write_motion(a_motion()), write_measured_motion(a_measured_motion())}) {
    const bool measured = good[5] == std::byte{'M'} && good[6] == std::byte{'E'};
    const auto refused = [&](const std::vector<std::byte>& bytes) {
      Error error;
      if (measured) {
        if (auto r = read_measured_motion(bytes, "row 7"); !r) error = std::move(r.error());
      } else {
        if (auto r = read_motion(bytes, "row 7"); !r) error = std::move(r.error());
      }
      return !error.empty() && error.problems[0].location.starts_with("row 7: byte ") && !error.problems[0].remedy.empty();
    };
    for (std::size_t n = 0; n < good.size(); ++n) {
      const std::vector<std::byte> cut(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(n));
      EXPECT_TRUE(refused(cut)) << n;
      if (n > 32) {
        EXPECT_TRUE(refused(with_checksum(cut))) << n << " with a correct checksum";
      }
    }
    for (std::size_t n = 0; n < good.size(); ++n) {
      if (n >= 12 && n < 16) continue;  // reserved bytes are not checked
      auto bad = good;
      bad[n] ^= std::byte{0x10};
      EXPECT_TRUE(refused(bad)) << n;
    }
    auto longer = good;
    longer.push_back(std::byte{0});
    EXPECT_TRUE(refused(with_checksum(longer)));
  }
}

TEST(MotionBinary, RejectsInvalidContents) {
  Motion m = a_motion();
  m.q[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(read_motion(write_motion(m), "x").has_value());
  m = a_motion();
  m.rate = 0;
  EXPECT_FALSE(read_motion(write_motion(m), "x").has_value());
  m = a_motion();
  m.frames = -3;
  EXPECT_FALSE(read_motion(write_motion(m), "x").has_value());
  m = a_motion();
  m.nq = 3;
  EXPECT_FALSE(read_motion(write_motion(m), "x").has_value());
  MeasuredMotion d = a_measured_motion();
  d.skeleton.joints[0].parent = 1;
  EXPECT_FALSE(read_measured_motion(write_measured_motion(d), "x").has_value());
  d = a_measured_motion();
  d.rotations[0].w = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(read_measured_motion(write_measured_motion(d), "x").has_value());
  EXPECT_FALSE(read_measured_motion(write_motion(a_motion()), "x").has_value()) << "wrong kind of motion";
}

}  // namespace
}  // namespace ugoki::formats
