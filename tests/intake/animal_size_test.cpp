// Size of four-legged animals: unit, species, gravity and gait.
#include "ugoki/intake/animal_size.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>

#include "ugoki/intake/intake.h"
#include "ugoki/intake/species.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::intake {
namespace {

/// A motion of 2 s at 60 frames/s in which the hips and shoulders of an animal, joints 0 to 3, move up and down by `height` in 0.5 s.
MeasuredMotion bouncing(double height) {
  MeasuredMotion m;
  m.rate = 60;
  m.frames = 121;
  for (int i = 0; i < 4; ++i) {
    SkeletonJoint joint;
    joint.name = "j" + std::to_string(i);
    joint.translates = true;
    m.skeleton.joints.push_back(std::move(joint));
  }
  for (int f = 0; f < m.frames; ++f)
    for (int i = 0; i < 4; ++i) {
      m.translations.push_back({0.5 * (i / 2), 0.1 * (i % 2), 0.5 * height * ugoki::sin(4 * pi * f / m.rate)});
      m.rotations.emplace_back();
    }
  return m;
}

body::Character four_legs(double trunk) {
  body::Character c;
  c.plan = body::BodyPlan::four_legs;
  c.trunk_length = trunk;
  c.legs = {body::Limb{.proximal = 0}, body::Limb{.proximal = 1}};
  c.arms = {body::Limb{.proximal = 2}, body::Limb{.proximal = 3}};
  return c;
}

AnimalSize size(double trunk, double metres, bool trusted, double bounce, std::string_view species = {}) {
  const MeasuredMotion m = bouncing(bounce);
  const auto out = size_of_animal(four_legs(trunk), std::span(&m, 1), metres, trusted,
                                  species.empty() ? std::optional<SpeciesMass>() : species_mass(species));
  EXPECT_TRUE(out);
  return out.value_or(AnimalSize{});
}

double mass_of(double trunk) { return mass_of_trunk * trunk * trunk * trunk; }

TEST(AnimalSize, WithoutAStatedUnitAUsualOneIsChosen) {
  // 45 units read as inches, which a person of usual height would have: centimetres. Metres and plausible centimetres stay.
  EXPECT_DOUBLE_EQ(size(45 * 0.0254, 0.0254, false, 0).unit, 0.01);
  EXPECT_DOUBLE_EQ(size(0.45 * 0.01, 0.01, false, 0).unit, 1);
  EXPECT_FALSE(size(0.45, 0.01, false, 0).changed);
  // 45 units of a mouse are millimetres, of a fox centimetres, and 0.9 units of a horse metres.
  EXPECT_DOUBLE_EQ(size(0.45, 0.01, false, 0, "mouse").unit, 0.001);
  EXPECT_DOUBLE_EQ(size(45, 1, false, 0, "fox").unit, 0.01);
  EXPECT_DOUBLE_EQ(size(0.009, 0.01, false, 0, "horse").unit, 1);
}

TEST(AnimalSize, APlausibleStatedUnitIsKept) {
  EXPECT_FALSE(size(1.2, 1, true, 0.05).changed);
  EXPECT_TRUE(size(1.2, 1, true, 0.05).reason.empty());
  EXPECT_FALSE(size(0.6, 1, true, 0, "deer").changed);
  // A wolf of 85 kg is usual enough. A wolf of 130 kg is unusual, but more likely than a wrong unit. The report states it.
  EXPECT_TRUE(size(0.713, 1, true, 0, "wolf").reason.empty());
  EXPECT_FALSE(size(0.82, 1, true, 0, "wolf").changed);
  EXPECT_NE(size(0.82, 1, true, 0, "wolf").reason.find("wolf weighs 15 kg to 80 kg"), std::string::npos);
}

TEST(AnimalSize, AnImpossibleMassOfTheSpeciesChangesTheUnit) {
  // Stated centimetres that are millimetres, and a model in no usual unit.
  const AnimalSize rat = size(1.1, 0.01, true, 0, "rat");
  EXPECT_DOUBLE_EQ(rat.unit, 0.001);
  for (const auto& [name, trunk] : {std::pair{"wolf", 1.6}, {"deer", 0.17}, {"cow", 0.3}, {"cat", 3.0}}) {
    const AnimalSize s = size(trunk, 1, true, 0, name);
    const auto range = species_mass(name);
    EXPECT_TRUE(s.changed) << name;
    EXPECT_GE(mass_of(trunk * s.unit), range->lightest) << name;
    EXPECT_LE(mass_of(trunk * s.unit), range->heaviest) << name;
    EXPECT_NE(s.reason.find(name), std::string::npos) << s.reason;
  }
  // No animal but an elephant has a trunk of 2.5 m.
  EXPECT_TRUE(size(2.5, 1, true, 0).changed);
  EXPECT_FALSE(size(2.5, 1, true, 0, "elephant").changed);
}

TEST(AnimalSize, TheTrunkFallsNoFasterThanGravityAllows) {
  // Amplitude A and angular frequency w give accelerations of up to A w^2, here 0.25 (4 pi)^2 = 39.5 m/s^2. The difference over 0.08 s is 8
  // % smaller than the second derivative.
  const MeasuredMotion m = bouncing(0.5);
  EXPECT_NEAR(fall_of_trunk(four_legs(1.2), std::span(&m, 1)), 39.5, 0.09 * 39.5);
  const AnimalSize s = size(1.2, 1, true, 0.5);
  EXPECT_TRUE(s.changed);
  EXPECT_LT(39.5 * s.unit, 1.7 * 9.81);
  EXPECT_GT(39.5 * s.unit, 0.9 * 9.81);
  // An exaggerated gallop does not make a stag of 2 kg: the species limits the size.
  const double trunk = 1.2;
  const AnimalSize stag = size(trunk, 1, true, 2, "stag");
  EXPECT_GT(mass_of(trunk * stag.unit), 0.6 * species_mass("stag")->lightest);
  EXPECT_NE(stag.reason.find("exaggerated"), std::string::npos) << stag.reason;
}

// The clips of toy animals have one cycle of 11 frames at 24 Hz.
TEST(AnimalSize, ShortClipsShowTheFallOfTheTrunk) {
  MeasuredMotion hop = bouncing(0.5);
  hop.rate = 24;
  hop.frames = 11;
  for (int f = 0; f < hop.frames; ++f)
    for (int i = 0; i < 4; ++i) hop.translations[static_cast<std::size_t>(4 * f + i)].z = 0.25 * ugoki::sin(4 * pi * f / hop.rate);
  const std::vector<MeasuredMotion> clips(6, hop);
  EXPECT_NEAR(fall_of_trunk(four_legs(1.2), clips), 39.5, 0.1 * 39.5);
  const auto size = size_of_animal(four_legs(1.2), clips, 1, true, std::nullopt);
  ASSERT_TRUE(size);
  EXPECT_TRUE(size->changed);
  EXPECT_LT(39.5 * size->unit, 1.7 * 9.81);
}

/// An animal that walks in place with hips 1 m high: sinusoidal swing of the feet, stance speed `speed`.
MeasuredMotion walking(double period, double stride) {
  MeasuredMotion m = bouncing(0);
  m.frames = 181;
  m.translations.clear();
  m.rotations.assign(static_cast<std::size_t>(8 * m.frames), Quat{});
  for (int i = 0; i < 4; ++i) {
    SkeletonJoint joint;
    joint.name = "foot" + std::to_string(i);
    joint.translates = true;
    m.skeleton.joints.push_back(std::move(joint));
  }
  for (int f = 0; f < m.frames; ++f) {
    const auto hip = [](int i) { return Vec3{0.8 * (i / 2), 0.2 * (i % 2), 1}; };
    for (int i = 0; i < 4; ++i) m.translations.push_back(hip(i));
    for (int i = 0; i < 4; ++i) {
      // In stance (60 % of the period) the foot moves back by 60 % of the stride, in swing it returns.
      double phase = f / m.rate / period + 0.25 * i;
      phase -= std::floor(phase);
      const double reach = 0.6 * stride, swing = (phase - 0.6) / 0.4;
      const double x = phase < 0.6 ? reach * (0.5 - phase / 0.6) : reach * (swing - 0.5);
      m.translations.push_back(Vec3{hip(i).x + x, hip(i).y, phase < 0.6 ? 0 : 0.1 * ugoki::sin(pi * swing)});
    }
  }
  return m;
}

TEST(AnimalSize, TheGaitImpliesTheHeightOfTheHips) {
  body::Character c = four_legs(0.8);
  c.legs = {body::Limb{.proximal = 0, .tip = 4}, body::Limb{.proximal = 1, .tip = 5}};
  c.arms = {body::Limb{.proximal = 2, .tip = 6}, body::Limb{.proximal = 3, .tip = 7}};
  // With stride 2.4 Fr^0.34 h, the Froude number 0.25 belongs to a stride of 1.498 h; v = sqrt(Fr g h) gives the period stride / v.
  const double stride = 2.4 * std::pow(0.25, 0.34), period = stride / std::sqrt(0.25 * 9.81);
  const MeasuredMotion walk = walking(period, stride);
  const auto h = hip_height_by_gait(c, std::span(&walk, 1));
  ASSERT_TRUE(h);
  EXPECT_NEAR(*h, 1, 0.1);
  // The same steps in half the time are those of an animal a quarter as large. A gait in a wrong unit gives the same size.
  const MeasuredMotion fast = walking(period / 2, stride);
  EXPECT_NEAR(hip_height_by_gait(c, std::span(&fast, 1)).value_or(0), 0.25, 0.04);
  MeasuredMotion scaled = walk;
  scale(scaled, 0.0254);
  EXPECT_NEAR(hip_height_by_gait(c, std::span(&scaled, 1)).value_or(0), *h, 1e-6);
  const MeasuredMotion still = walking(1e9, 0);
  EXPECT_FALSE(hip_height_by_gait(c, std::span(&still, 1)));
  // Without a stated unit and species, the gait decides between centimetres and inches: the animal of 1 m is read as 0.39 m.
  c.trunk_length = 0.8 / 2.54;
  MeasuredMotion small = walk;
  scale(small, 1 / 2.54);
  EXPECT_DOUBLE_EQ(size_of_animal(c, std::span(&small, 1), 0.01, false, std::nullopt)->unit, 0.0254);
}

TEST(Species, NamesOfFilesAndJointsStateTheSpecies) {
  const auto in = [](std::string_view file, std::vector<std::string> names = {}) {
    const auto s = species_in_names(file, names);
    return s ? s->names : std::string();
  };
  EXPECT_EQ(in("Deer.gltf"), "deer");
  EXPECT_EQ(in("DEERwalk1.fbx"), "deer");
  EXPECT_EQ(in("dogsmall.glb"), "dog");
  EXPECT_EQ(in("SheepOnPlane.fbx"), "sheep");
  EXPECT_EQ(in("Dog@Drag.fbx"), "dog");
  EXPECT_EQ(in("fox-cat.glb"), "fox, cat");
  EXPECT_EQ(in("walk.fbx", {"Wolf_Armature", "AnimalArmature|Run"}), "wolf");
  EXPECT_EQ(in("fox.glb", {"Wolf"}), "fox");
  EXPECT_EQ(in("run.fbx", {"Armature", "Calf_L", "hips", "spine"}), "");
  EXPECT_EQ(in("calf.fbx"), "calf");
  EXPECT_EQ(in("gallop.bvh"), "");
  EXPECT_EQ(in("bigcat_run.fbx"), "cat");
  // Short names are parts of other words.
  for (const char* other : {"half-rate.bvh", "cowboy.fbx", "ramp_walk.bvh", "skateboard.fbx", "puppet.glb", "share.bvh", "stage.glb"})
    EXPECT_EQ(in(other), "") << other;
  EXPECT_FALSE(species_mass("unknown"));
  // A name in several species covers all of them.
  const auto both = species_in_names("fox-cat.glb", {});
  ASSERT_TRUE(both);
  EXPECT_DOUBLE_EQ(both->lightest, 1);
  EXPECT_DOUBLE_EQ(both->heaviest, 14);
}

/// An animal with a trunk of 0.7 m whose joints swing.
MeasuredMotion walking_animal() {
  MeasuredMotion m;
  m.rate = 30;
  m.frames = 40;
  const auto add = [&](const std::string& name, int parent, const Vec3& offset, const Vec3& end) {
    SkeletonJoint j;
    j.name = name;
    j.parent = parent;
    j.offset = offset;
    j.translates = parent < 0;
    if (norm(end) > 0) j.end_sites.push_back(end);
    m.skeleton.joints.push_back(std::move(j));
    return m.joint_count() - 1;
  };
  const int hips = add("Hips", -1, {0, 0, 0.8}, {}), chest = add("Chest", hips, {0.7, 0, 0}, {});
  add("Head", add("Neck", chest, {0.2, 0, 0.2}, {}), {0.3, 0, 0.3}, {0.4, 0, -0.2});
  add("Tail", hips, {-0.2, 0, 0.1}, {-0.3, 0, -0.4});
  for (const bool fore : {true, false})
    for (const auto& [side, y] : {std::pair(std::string(".L"), 0.2), {".R", -0.2}}) {
      const int upper = add((fore ? "FrontUpperLeg" : "BackUpperLeg") + side, fore ? chest : hips, {0, y, -0.1}, {});
      const int lower = add((fore ? "FrontLowerLeg" : "BackLowerLeg") + side, upper, {0, 0, -0.35}, {});
      add((fore ? "FrontPaw" : "BackPaw") + side, lower, {0, 0, -0.3}, {0.05, 0, -0.05});
    }
  for (int f = 0; f < m.frames; ++f)
    for (int i = 0; i < m.joint_count(); ++i) {
      m.translations.push_back(m.skeleton.joints[static_cast<std::size_t>(i)].offset);
      m.rotations.push_back(i == hips ? Quat{} : axis_angle({0, 1, 0}, 0.2 * std::sin(0.3 * f + 0.9 * i)));
    }
  return m;
}

TEST(Species, AnAnimalOfUnusualSizeGetsTheClosestUsualMass) {
  const MeasuredMotion motion = walking_animal();
  auto body = body::make_body(motion);
  ASSERT_TRUE(body) << body.error().text();
  ASSERT_EQ(body->anatomy.plan, "four legs");
  const double by_size = body->mass, height = body->height;
  ASSERT_GT(by_size, 60);
  EXPECT_EQ(limit_mass(*body, *species_mass("deer"), motion, {}), "");
  EXPECT_DOUBLE_EQ(body->mass, by_size);
  const std::string sentence = limit_mass(*body, *species_mass("cat"), motion, {});
  EXPECT_NE(sentence.find("8.00 kg"), std::string::npos) << sentence;
  EXPECT_NEAR(body->mass, 8, 1e-9);
  EXPECT_NEAR(body->mechanism->mass(), 8, 1e-9);
  EXPECT_DOUBLE_EQ(body->height, height) << "only the mass changes";
  EXPECT_NE(limit_mass(*body, *species_mass("horse"), motion, {}), "");
  EXPECT_NEAR(body->mass, 90, 1e-9);
}

TEST(Species, AnUnknownSpeciesOfTheCallerIsRefused) {
  IntakeOptions options;
  options.species = "dragon";
  const auto in = take_in(
      "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd Site\n{\nOFFSET 0 1 0\n}\n}\n"
      "MOTION\nFrames: 1\nFrame Time: 0.01\n0 0 0\n",
      "x.bvh", nullptr, options);
  ASSERT_FALSE(in);
  EXPECT_NE(in.error().text().find("dragon"), std::string::npos);
  EXPECT_NE(in.error().text().find("wolf"), std::string::npos);
}

}  // namespace
}  // namespace ugoki::intake
