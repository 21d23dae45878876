#include "ugoki/motion/jumps.h"

#include <gtest/gtest.h>

#include <cmath>

#include "ugoki/mechanism/state.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki {
namespace {

/// A fixed body, a link attached to the body by a ball joint, and a second link attached to the first by a hinge.
MechanismPtr arm() {
  MechanismSpec spec;
  spec.name = "arm";
  const auto add = [&](const std::string& name, const std::string& parent, JointType type) {
    LinkSpec l;
    l.name = name;
    l.parent = parent;
    l.joint.type = type;
    l.joint.axis = {0, 1, 0};
    l.inertia = Inertia::from_centre(1, {0, 0, 0.1}, {0.01, 0.01, 0.01, 0, 0, 0});
    spec.links.push_back(l);
  };
  add("base", "", JointType::fixed);
  add("ball", "base", JointType::spherical);
  add("hinge", "ball", JointType::revolute);
  return Mechanism::make(std::move(spec)).value();
}

/// The hinge swings at up to 30 rad/s; the ball joint rotates slowly. If `turned_over`, the ball joint is rotated by 180 degrees about an
/// axis of its parent in frames 30 to 59, as by a solver that crossed a singular position.
Motion measured(bool turned_over) {
  Motion motion;
  motion.rate = 120;
  motion.frames = 100;
  motion.nq = 5;
  for (int f = 0; f < motion.frames; ++f) {
    const double t = f / motion.rate;
    Quat r = exp_map(Vec3{0.3, -0.2, 0.5} * std::sin(2 * t));
    if (turned_over && f >= 30 && f < 60) r = exp_map({0, 0, pi}) * r;
    for (const double x : {r.w, r.x, r.y, r.z, 1.5 * std::sin(20 * t)}) motion.q.push_back(x);
  }
  return motion;
}

TEST(Jumps, FastMotionIsNoJump) {
  const MechanismPtr m = arm();
  EXPECT_TRUE(find_jumps(measured(false), *m).empty());
  EXPECT_EQ(without_jumps(measured(false), *m).q, measured(false).q);
}

TEST(Jumps, JumpAndItsReturnAreFoundAndRemoved) {
  const MechanismPtr m = arm();
  const Motion flawed = measured(true), truth = measured(false);
  const std::vector<Jump> jumps = find_jumps(flawed, *m);
  ASSERT_EQ(jumps.size(), 2u);
  EXPECT_EQ(m->link(jumps[0].link).name, "ball");
  EXPECT_EQ(jumps[0].frame, 30);
  EXPECT_EQ(jumps[1].frame, 60);
  const Motion repaired = without_jumps(flawed, *m);
  EXPECT_TRUE(find_jumps(repaired, *m).empty());
  // The true rotation during the frames of the two jumps is lost: 1.2 rad/s for one frame each, about different axes.
  std::vector<double> off(static_cast<std::size_t>(m->nv()));
  for (int f = 60; f < truth.frames; ++f) {
    difference(*m, std::span(repaired.frame(f), 5), std::span(truth.frame(f), 5), off);
    for (const double x : off) EXPECT_LT(std::fabs(x), 2 * 1.3 / 120) << f;
  }
  for (int f = 0; f < truth.frames; ++f) EXPECT_EQ(repaired.frame(f)[4], truth.frame(f)[4]) << "the hinge is not changed";
}

}  // namespace
}  // namespace ugoki
