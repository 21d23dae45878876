#include "ugoki/motion_edit/foot_lock.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "characters.h"
#include "ugoki/motion/measures.h"
#include "ugoki/motion_edit/edit.h"

namespace ugoki::motion_edit {
namespace {

/// The motion with its displacement over the ground scaled by `factor`, so that feet slide.
Motion stretched(const Mechanism& m, const Motion& motion, double factor) {
  Motion out = motion;
  for (int f = 0; f < out.frames; ++f) {
    const Placement root = root_placement(m, {motion.frame(f), at(motion.nq)});
    displace_root(m, {(factor - 1) * root.x, (factor - 1) * root.y, 0, 0}, {out.frame(f), at(out.nq)});
  }
  return out;
}

TEST(Feet, AreFoundByLabelOrByPosition) {
  const Character human = human_walk();
  const std::vector<FootLimb> feet = find_foot_limbs(human.m());
  ASSERT_EQ(feet.size(), 2U);
  for (const FootLimb& f : feet) {
    EXPECT_GT(f.length, 0.7);
    EXPECT_LT(f.length, 1.0);
    EXPECT_FALSE(f.heel.empty());
    EXPECT_FALSE(f.toe.empty());
  }
  const Character dog = dog_trot();
  EXPECT_EQ(find_foot_limbs(dog.m()).size(), 4U);
  // Without labels, the feet are found as the lowest ends of the limbs.
  MechanismSpec spec = dog.m().spec();
  for (LinkSpec& l : spec.links) l.label.clear();
  const MechanismPtr bare = Mechanism::make(spec).value();
  const std::vector<FootLimb> found = find_foot_limbs(*bare), labelled = find_foot_limbs(dog.m());
  ASSERT_EQ(found.size(), 4U);
  for (const FootLimb& f : found)
    EXPECT_TRUE(std::any_of(labelled.begin(), labelled.end(), [&](const FootLimb& l) {
      return std::find(l.parts.begin(), l.parts.end(), f.link) != l.parts.end();
    })) << bare->link(f.link).name;
  const std::vector<std::string> unknown = {"wing"};
  const auto wrong = find_foot_limbs(dog.m(), unknown);
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().text().find("wing"), std::string::npos);
}

TEST(FootContacts, DependLittleOnRateAndNoise) {
  const Character human = human_walk();
  const Motion walk = unrolled(human.m(), human.motion, 2);
  const FootContacts truth = find_contacts(human.m(), walk);
  for (const double rate : {30.0, 60.0, 250.0}) {
    const Motion other = resample(human.m(), walk, rate).value();
    const FootContacts found = find_contacts(human.m(), other);
    for (std::size_t k = 0; k < 2; ++k) {
      int wrong = 0;
      for (int f = 0; f < other.frames; ++f)
        wrong +=
            found.bears[k][at(f)] != truth.bears[k][at(std::min(walk.frames - 1, static_cast<int>(f * walk.rate / rate + 0.5)))] ? 1 : 0;
      EXPECT_LT(wrong / static_cast<double>(other.frames), 0.06) << rate << " frames a second, foot " << k;
    }
  }
  Motion noisy = walk;
  std::mt19937 random(7);
  std::normal_distribution<double> off(0, 0.001);
  for (int f = 0; f < noisy.frames; ++f)
    for (int k = 0; k < 3; ++k) noisy.frame(f)[k] += off(random);
  const FootContacts found = find_contacts(human.m(), noisy);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(found.stances(k).size(), truth.stances(k).size()) << "seed 7";
    int wrong = 0;
    for (int f = 0; f < walk.frames; ++f) wrong += found.bears[k][at(f)] != truth.bears[k][at(f)] ? 1 : 0;
    EXPECT_LT(wrong / static_cast<double>(walk.frames), 0.06);
  }
}

TEST(FootContacts, EstimatedGroundFollowsARaisedMotion) {
  const Character human = human_walk();
  Motion high = human.motion;
  for (int f = 0; f < high.frames; ++f) displace_root(human.m(), {0, 0, 0.37, 0}, {high.frame(f), at(high.nq)});
  const std::vector<FootLimb> feet = find_foot_limbs(human.m());
  EXPECT_NEAR(find_ground(human.m(), high, feet) - find_ground(human.m(), human.motion, feet), 0.37, 1e-9);
  FootContactOptions find;
  find.find_ground = true;
  const FootContacts lifted = find_contacts(human.m(), high, find), level = find_contacts(human.m(), human.motion, find);
  EXPECT_EQ(lifted.bears, level.bears);
}

TEST(FootLock, SlidingFeetAreLocked) {
  for (const Character& character : {human_walk(), dog_trot()}) {
    const Motion walk = unrolled(character.m(), character.motion, 3);
    FootContacts contacts = find_contacts(character.m(), walk);
    const Motion sliding = stretched(character.m(), walk, 0.9);
    FootLockReport report;
    const Motion locked = lock_feet(character.m(), sliding, contacts, {}, &report).value();
    EXPECT_GT(report.before.worst_cm, 3.0);
    EXPECT_LT(report.after.worst_cm, 0.5) << character.m().name();
    EXPECT_LT(report.max_miss, 0.003);
    // Check with the independent FootSkate, for the first link of each foot.
    std::vector<int> links;
    for (const FootLimb& f : contacts.feet) links.push_back(f.link);
    FootSkate skate(character.m(), links);
    std::vector<Pose> X(at(character.m().link_count()));
    std::vector<std::uint8_t> on(links.size());
    for (int f = 0; f < locked.frames; ++f) {
      calc_poses(character.m(), {locked.frame(f), at(locked.nq)}, X);
      for (std::size_t k = 0; k < on.size(); ++k) on[k] = contacts.bears[k][at(f)];
      skate.add(X, on, 1 / locked.rate);
    }
    if (contacts.feet[0].parts.size() == 1) EXPECT_LT(skate.worst_stance_cm(), 0.5);
    // The horizontal position of the root is not changed.
    for (int f = 0; f < locked.frames; ++f) {
      EXPECT_EQ(locked.frame(f)[0], sliding.frame(f)[0]);
      EXPECT_EQ(locked.frame(f)[1], sliding.frame(f)[1]);
    }
  }
}

// A foot that turns about a vertical axis, as in a pirouette, keeps its path: its pivot is not known. The foot of a walk is not such a
// foot.
TEST(FootLock, TurningFeetKeepTheirPaths) {
  const Character human = human_walk();
  const Motion walk = unrolled(human.m(), human.motion, 2);
  const FootContacts contacts = find_contacts(human.m(), walk);
  const std::vector<FootPath> walking = foot_paths(human.m(), walk, contacts);
  for (const FootPath& path : walking) EXPECT_EQ(std::ranges::count(turning_frames(path, walk.rate), 1), 0);
  const double rate = 100, ball = 0.13;  // frames per second; m: from the foot's origin to the pivot
  FootPath path;
  for (int f = 0; f <= 200; ++f) {  // still for 0.5 s, a turn by 120 degrees within 1 s about the pivot, and still again
    const double s = std::clamp((f / rate - 0.5) / 1.0, 0.0, 1.0), angle = 2.1 * s;
    const Mat3 R = rotation_about({0, 0, 1}, angle);
    path.X_WF.push_back({R, Vec3{ball, 0, 0} - R * Vec3{ball, 0, 0}});
    path.bears.push_back(1);
    for (const Vec3& p : {Vec3{-0.05, 0.04, 0}, Vec3{-0.05, -0.04, 0}, Vec3{0.2, 0.04, 0}, Vec3{0.2, -0.04, 0}})
      path.points.push_back({p, 0});
  }
  EXPECT_NEAR(static_cast<double>(std::ranges::count(turning_frames(path, rate), 1)), 100, 2);
  std::vector<FootPath> pinned = {path};
  pin_stances(pinned, rate, 0, 0.9, {});
  for (std::size_t f = 0; f < path.X_WF.size(); ++f) {
    EXPECT_LT(norm(pinned[0].X_WF[f].p - path.X_WF[f].p), 0.004) << f;
    EXPECT_LT(norm(log_map(to_quat(pinned[0].X_WF[f].R * path.X_WF[f].R.transposed()))), 0.03) << f;
  }
}

TEST(FootLock, JointsStaySmooth) {
  const Character character = human_walk();
  const Motion walk = unrolled(character.m(), character.motion, 3);
  const Motion locked = lock_feet(character.m(), stretched(character.m(), walk, 1.1), find_contacts(character.m(), walk)).value();
  const auto max_acceleration = [&](const Motion& motion) {
    std::vector<double> v(at(character.m().nv())), before;
    double maximum = 0;
    for (int f = 1; f < motion.frames; ++f) {
      difference(character.m(), {motion.frame(f - 1), at(motion.nq)}, {motion.frame(f), at(motion.nq)}, v);
      for (std::size_t k = 6; k < v.size() && !before.empty(); ++k)
        maximum = std::max(maximum, std::fabs(v[k] - before[k]) * motion.rate * motion.rate);
      before = v;
    }
    return maximum;
  };
  EXPECT_LT(max_acceleration(locked), 4 * max_acceleration(walk) + 300);  // rad/s^2; a knee that becomes straight in one frame has more
}

TEST(FootLock, LegTooShortLowersThePelvis) {
  const Character character = human_walk();
  const Motion walk = unrolled(character.m(), character.motion, 2);
  const FootContacts contacts = find_contacts(character.m(), walk);
  Motion high = walk;
  for (int f = 0; f < high.frames; ++f) displace_root(character.m(), {0, 0, 0.05, 0}, {high.frame(f), at(high.nq)});
  FootLockReport report;
  const Motion locked = lock_feet(character.m(), high, contacts, {}, &report).value();
  EXPECT_GT(report.max_drop, 0.03);
  EXPECT_LT(report.after.worst_cm, 0.5);
  std::vector<Pose> X(at(character.m().link_count()));
  for (int f = 0; f < locked.frames; ++f) {
    calc_poses(character.m(), {locked.frame(f), at(locked.nq)}, X);
    for (const FootLimb& foot : contacts.feet) EXPECT_LE(norm(X[at(foot.link)].p - X[at(foot.chain.front())].p), foot.length * 1.0001) << f;
  }
}

TEST(FootLock, LockingTwiceChangesLittle) {
  const Character character = human_walk();
  const FootContacts contacts = find_contacts(character.m(), character.motion);
  const Motion once = lock_feet(character.m(), character.motion, contacts).value();
  const Motion twice = lock_feet(character.m(), once, contacts).value();
  EXPECT_LT(max_difference(character.m(), once, twice), 0.02);
}

TEST(FootLock, RefusesMechanismsWithoutFeet) {
  const MechanismPtr ball = samples::make_ball();
  Motion still;
  still.rate = 10;
  still.frames = 3;
  still.nq = ball->nq();
  for (int f = 0; f < 3; ++f) {
    const std::vector<double> q = ball->neutral();
    still.q.insert(still.q.end(), q.begin(), q.end());
  }
  const auto locked = lock_feet(*ball, still, find_contacts(*ball, still));
  ASSERT_FALSE(locked);
  EXPECT_NE(locked.error().text().find("no feet"), std::string::npos);
}

}  // namespace
}  // namespace ugoki::motion_edit
