#include "ugoki/motion/upsample.h"

#include <gtest/gtest.h>

#include <cmath>

#include "ugoki/motion/contact_labels.h"

namespace ugoki {
namespace {

/// A floating link that carries a hinge.
MechanismPtr character() {
  MechanismSpec spec;
  spec.name = "character";
  for (const char* name : {"root", "hinge"}) {
    LinkSpec l;
    l.name = name;
    l.parent = spec.links.empty() ? "" : "root";
    l.joint.type = spec.links.empty() ? JointType::floating : JointType::revolute;
    l.joint.axis = {0, 1, 0};
    l.inertia = Inertia::from_centre(1, {}, {0.01, 0.01, 0.01, 0, 0, 0});
    spec.links.push_back(l);
  }
  return Mechanism::make(std::move(spec)).value();
}

/// Coordinates at time t [s] of a motion with a period of 1 s: the root advances and turns, the hinge swings.
std::vector<double> truth(double t) {
  const double w = 2 * pi * t;
  const Quat turn = exp_map(Vec3{0.3, -0.2, 0.4} * std::sin(w + 0.3));
  return {1.5 * t, 0.1 * std::sin(w), 0.8 + 0.05 * std::cos(2 * w), turn.w, turn.x, turn.y, turn.z, 0.7 * std::sin(w + 1)};
}

Motion recorded(const Mechanism& m, double rate, bool cyclic) {
  Motion motion;
  motion.rate = rate;
  motion.frames = static_cast<int>(rate) + 1;
  motion.nq = m.nq();
  motion.cyclic = cyclic;
  motion.contacts = {{"root", {}}};
  for (int f = 0; f < motion.frames; ++f) {
    const std::vector<double> q = truth(f / rate);
    motion.q.insert(motion.q.end(), q.begin(), q.end());
    motion.contacts[0].on.push_back(f < motion.frames / 2 ? 1 : 0);
    for (int k = 3; f % 3 == 1 && k < 7; ++k) motion.frame(f)[k] *= -1;  // the same rotation
  }
  return motion;
}

TEST(Upsample, NewFramesAreOnTheSmoothMotionAndGivenFramesStay) {
  const MechanismPtr m = character();
  for (const bool cyclic : {false, true}) {
    const Motion coarse = recorded(*m, 12, cyclic), fine = upsampled(coarse, *m, 115);
    EXPECT_TRUE(check_motion(fine, *m).empty()) << check_motion(fine, *m).text();
    ASSERT_EQ(fine.rate, 120);
    ASSERT_EQ(fine.frames, 121);
    EXPECT_DOUBLE_EQ(fine.duration(), coarse.duration());
    double worst = 0;
    for (int f = 0; f < fine.frames; ++f) {
      // At the ends of a motion that is not cyclic, accelerations are assumed.
      if (!cyclic && (f < 10 || f > 110)) continue;
      const std::vector<double> q = truth(f / 120.0);
      const double sign = fine.frame(f)[3] * q[3] < 0 ? -1 : 1;
      for (int k = 0; k < m->nq(); ++k)
        worst = std::max(worst, std::fabs(q[static_cast<std::size_t>(k)] - (k >= 3 && k < 7 ? sign : 1) * fine.frame(f)[k]));
    }
    EXPECT_LT(worst, 0.006) << "with linear interpolation 0.025";
    for (int f = 0; f < coarse.frames; ++f)
      for (int k = 0; k < m->nq(); ++k) EXPECT_NEAR(fine.frame(10 * f)[k], coarse.frame(f)[k], 1e-12);
    ASSERT_EQ(fine.contacts[0].on.size(), 121U);
    EXPECT_EQ(fine.contacts[0].on[54], 1);
    EXPECT_EQ(fine.contacts[0].on[56], 0);
  }
}

TEST(Upsample, MotionsWithEnoughFramesAndPosesStay) {
  const MechanismPtr m = character();
  const Motion fast = recorded(*m, 120, false);
  EXPECT_EQ(upsampled(fast, *m, 120).q, fast.q);
  Motion pose = recorded(*m, 12, false);
  pose.frames = 1;
  pose.q.resize(static_cast<std::size_t>(pose.nq));
  pose.contacts[0].on.resize(1);
  EXPECT_EQ(upsampled(pose, *m, 120).frames, 1);
  EXPECT_EQ(upsampled(pose, *m, 120).q, pose.q);
  EXPECT_EQ(upsampled(pose, *m, 120).rate, pose.rate) << "a pose has no intervals to divide";
  Motion two = recorded(*m, 12, false);
  two.frames = 2;
  two.q.resize(static_cast<std::size_t>(2 * two.nq));
  two.contacts.clear();
  const Motion line = upsampled(two, *m, 120);
  ASSERT_EQ(line.frames, 11);
  EXPECT_NEAR(line.frame(5)[0], 0.5 * (two.frame(0)[0] + two.frame(1)[0]), 1e-12);
}

// A dog of three joints in each limb has a carpus and a hock instead of paws.
TEST(FindFeet, ACarpusWithoutAPawIsAFoot) {
  MechanismSpec spec;
  spec.name = "dog";
  const auto add = [&](const std::string& label, const std::string& parent, bool shape) {
    LinkSpec l;
    l.name = l.label = label;
    l.parent = parent;
    l.joint.type = parent.empty() ? JointType::floating : JointType::spherical;
    l.inertia = Inertia::from_centre(1, {}, {0.01, 0.01, 0.01, 0, 0, 0});
    if (shape) l.shapes.push_back(Shape::sphere(0.02));
    spec.links.push_back(l);
  };
  add("pelvis", "", true);
  add("hock left", "pelvis", true);
  add("paw hind left", "hock left", true);
  add("hock right", "pelvis", true);
  add("paw hind right", "hock right", false);  // its bone has no shape
  add("carpus left", "pelvis", true);
  add("carpus right", "pelvis", false);
  const MechanismPtr m = Mechanism::make(std::move(spec)).value();
  std::vector<std::string> feet;
  for (const int i : find_feet(*m)) feet.push_back(m->link(i).label);
  EXPECT_EQ(feet, (std::vector<std::string>{"paw hind left", "hock right", "carpus left"}));
}

}  // namespace
}  // namespace ugoki
