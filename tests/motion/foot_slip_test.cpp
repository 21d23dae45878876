#include "ugoki/motion/foot_slip.h"

#include <gtest/gtest.h>

#include <cmath>

namespace ugoki {
namespace {

/// A foot of 0.2 m (half length 0.1 m) with its sole at z = 0 in the neutral position.
MechanismPtr foot() {
  MechanismSpec spec;
  spec.name = "foot";
  LinkSpec l;
  l.name = "foot";
  l.label = "foot left";
  l.joint.type = JointType::floating;
  const Shape box = Shape::box({0.1, 0.04, 0.03}, {Mat3::identity(), {0, 0, 0.03}});
  l.inertia = solid_inertia(box, 1000);
  l.shapes.push_back(box);
  spec.links.push_back(l);
  return Mechanism::make(std::move(spec)).value();
}

struct Stance {
  MechanismPtr m = foot();
  FootSlip slip{*m, std::vector<int>{0}};
  void add(const Pose& X, bool on, double dt) {
    const std::uint8_t flag = on ? 1 : 0;
    slip.add(std::span(&X, 1), std::span(&flag, 1), dt);
  }
};

TEST(FootSlip, SlidingFootSlipsByItsDistanceWithoutTheMargins) {
  for (const double rate : {60.0, 120.0, 500.0}) {
    Stance s;
    const int n = static_cast<int>(rate);  // 1 s at 0.1 m/s
    for (int i = 0; i <= n; ++i) s.add({Mat3::identity(), {0.1 * i / rate, 0, 0}}, true, 1 / rate);
    s.add({}, false, 1 / rate);
    EXPECT_EQ(s.slip.stances(), 1);
    EXPECT_NEAR(s.slip.worst_cm(), 10 * (1 - 0.12), 0.41 * 60 / rate) << rate;
  }
}

TEST(FootSlip, PresentSlipGrowsDuringAStanceAndEndsWithIt) {
  Stance s;
  double before = 0;
  for (int i = 0; i <= 120; ++i) {  // 1 s at 0.1 m/s
    s.add({Mat3::identity(), {0.1 * i / 120, 0, 0}}, true, 1.0 / 120);
    EXPECT_GE(s.slip.now_cm(), before);
    before = s.slip.now_cm();
  }
  EXPECT_NEAR(before, 8.8, 0.3);
  EXPECT_EQ(before, s.slip.worst_cm());
  s.add({}, false, 1.0 / 120);
  EXPECT_EQ(s.slip.now_cm(), 0);
}

TEST(FootSlip, RollingFootDoesNotSlip) {
  Stance s;
  for (int i = 0; i <= 200; ++i) {  // rolls from 20 degrees on the heel to 30 degrees on the tip, about the edge that touches
    const double angle = (20 - 50.0 * i / 200) * pi / 180, edge = angle > 0 ? -0.1 : 0.1;
    const Mat3 R = rotation_about({0, 1, 0}, -angle);
    s.add({R, Vec3{edge, 0, 0} - R * Vec3{edge, 0, 0}}, true, 0.002);
  }
  EXPECT_LT(s.slip.worst_cm(), 0.05);
}

TEST(FootSlip, NoiseOfACaptureCancelsOut) {
  Stance s;
  for (int i = 0; i < 120; ++i) s.add({Mat3::identity(), {0.001 * (i % 2), 0.001 * (i / 2 % 2), 0}}, true, 1.0 / 120);
  EXPECT_LT(s.slip.worst_cm(), 0.15);  // cm; the noise moves the foot by 12 cm or more in total
}

TEST(FootSlip, RestoredMeasureGoesOnAsBefore) {
  Stance a, b;
  const auto pose = [](int i) { return Pose{Mat3::identity(), {0.0005 * i, 0.0002 * (i % 7), 0}}; };
  for (int i = 0; i < 90; ++i) a.add(pose(i), i % 40 != 0, 0.008);
  std::vector<double> memory(a.slip.memory_size());
  a.slip.save(memory);
  b.slip.restore(memory);
  for (int i = 90; i < 150; ++i) {
    a.add(pose(i), i % 40 != 0, 0.008);
    b.add(pose(i), i % 40 != 0, 0.008);
  }
  EXPECT_EQ(a.slip.mean_cm(), b.slip.mean_cm());
  EXPECT_EQ(a.slip.worst_cm(), b.slip.worst_cm());
  EXPECT_EQ(a.slip.stances(), b.slip.stances());
}

}  // namespace
}  // namespace ugoki
