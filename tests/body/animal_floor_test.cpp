// Tests of the floor under four-legged animals that stand for a part of the motion only.
#include <gtest/gtest.h>

#include <algorithm>

#include "ugoki/body/body.h"
#include "ugoki/body/creature.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/contact_labels.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::body {
namespace {

constexpr int standing_frames = 60, lying_frames = 60;

/// A dog with legs of 0.46 m that stands and then lies with folded legs. While it lies, its trunk is `sunk` m below the level of the paws,
/// as in recordings whose joints are too low.
MeasuredMotion lying_dog(double sunk) {
  MeasuredMotion m;
  m.name = "dog";
  m.rate = 30;
  m.frames = standing_frames + lying_frames;
  const auto add = [&](const char* name, int parent, Vec3 offset, Vec3 end = {}) {
    SkeletonJoint joint;
    joint.name = name;
    joint.parent = parent;
    joint.offset = offset;
    joint.dofs = {{{0, 0, 1}}, {{0, 1, 0}}, {{1, 0, 0}}};
    joint.translates = parent < 0;
    if (norm(end) > 0) joint.end_sites = {end};
    m.skeleton.joints.push_back(std::move(joint));
    return static_cast<int>(m.skeleton.joints.size()) - 1;
  };
  const int hips = add("Hips", -1, {0, 0, 0.46}), spine = add("Spine", hips, {0.2, 0, 0}), chest = add("Chest", spine, {0.2, 0, 0});
  const int neck = add("Neck", chest, {0.12, 0, 0.1});
  add("Head", neck, {0.1, 0, 0.1}, {0.15, 0, 0});
  add("Tail", hips, {-0.1, 0, 0}, {-0.2, 0, 0});
  std::vector<int> upper, lower;
  for (const auto& [from, name] : {std::pair(hips, "Back"), {chest, "Front"}})
    for (const auto& [side, y] : {std::pair(".L", 0.07), {".R", -0.07}}) {
      upper.push_back(add((std::string(name) + "UpperLeg" + side).c_str(), from, {0, y, 0}));
      lower.push_back(add((std::string(name) + "LowerLeg" + side).c_str(), upper.back(), {0, 0, -0.23}));
      add((std::string(name) + "Paw" + side).c_str(), lower.back(), {0, 0, -0.2}, {0.06, 0, -0.03});
    }
  for (int f = 0; f < m.frames; ++f) {
    const bool lies = f >= standing_frames;
    for (std::size_t i = 0; i < m.skeleton.joints.size(); ++i) {
      const int joint = static_cast<int>(i);
      m.translations.push_back(joint == hips && lies ? Vec3{0, 0, -sunk} : m.skeleton.joints[i].offset);
      Quat turn;
      const double sway = 0.03 * ugoki::sin(0.3 * f);
      if (std::ranges::count(upper, joint) > 0) turn = axis_angle({0, 1, 0}, lies ? -0.5 * pi : sway);
      if (std::ranges::count(lower, joint) > 0) turn = axis_angle({0, 1, 0}, lies ? 0.98 * pi : -2 * sway);
      m.rotations.push_back(turn);
    }
  }
  return m;
}

/// Heights [m] of the lowest point in all frames of the motion on the floor.
std::vector<double> lowest_points(const Body& body, const Motion& motion) {
  std::vector<double> lows;
  std::vector<Pose> X(static_cast<std::size_t>(body.mechanism->link_count()));
  for (int f = 0; f < motion.frames; ++f) {
    calc_poses(*body.mechanism, {motion.frame(f), static_cast<std::size_t>(motion.nq)}, X);
    double low = 1e300;
    for (std::size_t i = 0; i < X.size(); ++i)
      for (const SupportPoint& p : support_points(body.mechanism->link(static_cast<int>(i))))
        low = std::min(low, (X[i] * p.p).z - p.radius);
    lows.push_back(low);
  }
  return lows;
}

TEST(AnimalFloor, IsTheLevelOfThePawsOfTheStandingAnimal) {
  for (const double sunk : {-0.1, 0.03}) {
    const MeasuredMotion dog = lying_dog(sunk);
    const auto body = make_body(dog);
    ASSERT_TRUE(body) << body.error().text();
    ASSERT_EQ(body->anatomy.plan, "four legs");
    const std::vector<double> lows = lowest_points(*body, to_motion(*body, dog));
    double highest = -1;
    for (int f = 0; f < standing_frames; ++f) highest = std::max(highest, lows[static_cast<std::size_t>(f)]);
    EXPECT_LT(highest, 0.02) << "a paw must touch the floor in every frame; sunk by " << sunk;
    EXPECT_GT(*std::ranges::min_element(lows.begin(), lows.begin() + standing_frames), -0.02);
  }
}

// The rest pose of a skin can have the ends of bones elsewhere than the motion, which holds them at one place of their parents.
TEST(AnimalBody, HasTheBonesOfTheMotionWhereTheRestPoseContradictsIt) {
  MeasuredMotion dog = lying_dog(-0.1);
  const std::size_t before = dog.skeleton.joints.size();
  std::vector<std::size_t> paws;
  for (std::size_t i = 0; i < before; ++i)
    if (dog.skeleton.joints[i].name.find("Paw") != std::string::npos || dog.skeleton.joints[i].name == "Head") paws.push_back(i);
  for (const std::size_t paw : paws) {  // a joint at the end of each paw
    SkeletonJoint end;
    end.name = dog.skeleton.joints[paw].name + "End";
    end.parent = static_cast<int>(paw);
    end.offset = dog.skeleton.joints[paw].end_sites[0];
    end.translates = true;
    dog.skeleton.joints[paw].end_sites.clear();
    dog.skeleton.joints.push_back(end);
  }
  const std::size_t n = dog.skeleton.joints.size();
  std::vector<Vec3> translations;
  std::vector<Quat> rotations(n * static_cast<std::size_t>(dog.frames));
  for (std::size_t f = 0; f < static_cast<std::size_t>(dog.frames); ++f)
    for (std::size_t i = 0; i < n; ++i) {
      translations.push_back(i < before ? dog.translations[f * before + i] : dog.skeleton.joints[i].offset);
      if (i < before) rotations[f * n + i] = dog.rotations[f * before + i];
    }
  dog.translations = translations;
  dog.rotations = rotations;
  const auto body = make_body(dog);
  ASSERT_TRUE(body) << body.error().text();
  ASSERT_EQ(body->anatomy.plan, "four legs");
  for (std::size_t i = before; i < n; ++i) dog.skeleton.joints[i].offset = dog.skeleton.joints[i].offset * 12.0 + Vec3{0, 0.3, 0};
  const auto same = make_body(dog);
  ASSERT_TRUE(same) << same.error().text();
  for (int i = 0; i < body->mechanism->link_count(); ++i) {
    const Link &a = body->mechanism->link(i), &b = same->mechanism->link(i);
    EXPECT_NEAR(a.inertia.mass, b.inertia.mass, 1e-9) << a.name;
    ASSERT_EQ(a.shapes.size(), b.shapes.size()) << a.name;
    for (std::size_t k = 0; k < a.shapes.size(); ++k) EXPECT_NEAR(a.shapes[k].half_length, b.shapes[k].half_length, 1e-9) << a.name;
  }
}

/// Only the frames in which the dog stands.
MeasuredMotion standing_dog() {
  MeasuredMotion dog = lying_dog(-0.1);
  dog.frames = standing_frames;
  dog.translations.resize(static_cast<std::size_t>(dog.frames) * dog.skeleton.joints.size());
  dog.rotations.resize(dog.translations.size());
  return dog;
}

/// Expects that an animal has four links of a kind, which stand on the floor in the first frame.
void expect_on_floor(const MeasuredMotion& dog, bool (*chosen)(const Link&)) {
  const auto body = make_body(dog);
  ASSERT_TRUE(body) << body.error().text();
  ASSERT_EQ(body->anatomy.plan, "four legs");
  const Motion motion = to_motion(*body, dog);
  std::vector<Pose> X(static_cast<std::size_t>(body->mechanism->link_count()));
  calc_poses(*body->mechanism, {motion.frame(0), static_cast<std::size_t>(motion.nq)}, X);
  int count = 0;
  for (std::size_t i = 0; i < X.size(); ++i) {
    const Link& link = body->mechanism->link(static_cast<int>(i));
    if (!chosen(link)) continue;
    double low = 1e300;
    for (const SupportPoint& p : support_points(link)) low = std::min(low, (X[i] * p.p).z - p.radius);
    EXPECT_NEAR(low, 0, 0.02) << link.name;
    ++count;
  }
  EXPECT_EQ(count, 4);
}

bool is_paw(const Link& link) {
  return link.label.starts_with("paw") || link.label.starts_with("hock") || link.label.starts_with("carpus");
}

TEST(AnimalFloor, ATailBelowThePawsDoesNotLiftTheAnimal) {
  MeasuredMotion dog = standing_dog();
  for (SkeletonJoint& j : dog.skeleton.joints)
    if (j.name == "Tail") j.end_sites = {{-0.1, 0, -0.52}};  // 6 cm below the paws
  expect_on_floor(dog, is_paw);
}

// The fore limbs have no joint below the carpus, 11 cm above the floor.
TEST(AnimalFloor, PawsWithoutAJointBelowTheAnkleReachTheFloor) {
  MeasuredMotion dog = standing_dog();
  const std::size_t n = dog.skeleton.joints.size();
  for (std::size_t i = 0; i < n; ++i) {
    const std::string& name = dog.skeleton.joints[i].name;
    if (!name.starts_with("FrontPaw") && !name.starts_with("FrontLower")) continue;
    dog.skeleton.joints[i].offset.z += 0.055;
    for (std::size_t f = 0; f < static_cast<std::size_t>(dog.frames); ++f) dog.translations[f * n + i].z += 0.055;
  }
  expect_on_floor(dog, is_paw);
}

// The paws are ends without a bone, as in rigs whose paws are targets of inverse kinematics. Those of the fore limbs are 9 cm too high.
TEST(AnimalFloor, LimbsWhosePawsHaveNoBoneReachTheFloor) {
  MeasuredMotion dog = standing_dog();
  const std::size_t n = dog.skeleton.joints.size();
  for (std::size_t i = 0; i < n; ++i) {
    const std::string& name = dog.skeleton.joints[i].name;
    if (name.find("Paw") != std::string::npos) dog.skeleton.joints[i].end_sites.clear();
    if (!name.starts_with("FrontPaw")) continue;
    dog.skeleton.joints[i].offset.z += 0.09;
    for (std::size_t f = 0; f < static_cast<std::size_t>(dog.frames); ++f) dog.translations[f * n + i].z += 0.09;
  }
  expect_on_floor(dog, [](const Link& link) { return link.name.ends_with("LowerLeg.L") || link.name.ends_with("LowerLeg.R"); });
}

// In another motion of the file the legs of the cartoon dog are drawn up by 10 cm, which the body's legs cannot do.
TEST(AnimalFloor, IsTheLevelOfTheBodysPawsIfLimbsShift) {
  const MeasuredMotion dog = standing_dog();
  const auto body = make_body(dog);
  ASSERT_TRUE(body) << body.error().text();
  MeasuredMotion drawn = dog;
  const std::size_t n = dog.skeleton.joints.size();
  for (std::size_t i = 0; i < n; ++i) {
    if (dog.skeleton.joints[i].name.find("UpperLeg") == std::string::npos) continue;
    drawn.skeleton.joints[i].translates = true;
    for (std::size_t f = 0; f < static_cast<std::size_t>(dog.frames); ++f) drawn.translations[f * n + i].z += 0.1;
  }
  const std::vector<double> usual = lowest_points(*body, to_motion(*body, dog)), lows = lowest_points(*body, to_motion(*body, drawn));
  for (std::size_t f = 0; f < lows.size(); ++f) EXPECT_NEAR(lows[f], usual[f], 1e-6) << f;
}

TEST(AnimalFloor, AnAnimalThatHardlyStandsCountsInAllFrames) {
  std::vector<double> heights(100, 0.1);
  std::fill_n(heights.begin(), 20, 0.5);
  EXPECT_EQ(std::ranges::count(usually_stands(heights), 1), 20);
  std::fill_n(heights.begin() + 5, 15, 0.1);  // the usual height is then that of lying
  EXPECT_EQ(std::ranges::count(usually_stands(heights), 1), 100);
  EXPECT_EQ(usually_stands(std::vector<double>(7, 0.3)), std::vector<char>(7, 1));
}

}  // namespace
}  // namespace ugoki::body
