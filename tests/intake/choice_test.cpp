// Files with several characters or motions, and mapping files.
#include "ugoki/intake/choice.h"

#include <gtest/gtest.h>

#include "../body/measured_files.h"
#include "ugoki/body/recognise.h"
#include "ugoki/formats/bvh.h"
#include "ugoki/intake/intake.h"
#include "ugoki/intake/mapping_file.h"

namespace ugoki::intake {
namespace {

/// Two persons in one motion, 2 m apart; the second one's joints end with "_b".
MeasuredMotion two_persons() {
  const MeasuredMotion one = body::testing::made_character(60);
  MeasuredMotion out = one;
  const std::size_t n = one.skeleton.joints.size();
  for (SkeletonJoint j : one.skeleton.joints) {
    if (j.parent >= 0) j.parent += static_cast<int>(n);
    j.name += "_b";
    out.skeleton.joints.push_back(std::move(j));
  }
  out.translations.clear();
  out.rotations.clear();
  for (std::size_t f = 0; f < static_cast<std::size_t>(one.frames); ++f)
    for (int k = 0; k < 2; ++k)
      for (std::size_t i = 0; i < n; ++i) {
        Vec3 t = one.translations[f * n + i];
        if (k == 1 && one.skeleton.joints[i].parent < 0) t += Vec3{0, 2, 0};
        out.translations.push_back(t);
        out.rotations.push_back(one.rotations[f * n + i]);
      }
  return out;
}

TEST(Choice, CharactersAreListedAndChosen) {
  const std::string bvh = formats::write_bvh(two_persons());
  const auto all = take_in(bvh, "two.bvh");
  ASSERT_TRUE(all) << all.error().text();
  ASSERT_EQ(all->characters.size(), 2u);
  EXPECT_TRUE(all->body->human);
  for (const std::string& wanted : {std::string("2"), all->characters[1]}) {
    IntakeOptions options;
    options.character = wanted;
    const auto second = take_in(bvh, "two.bvh", nullptr, options);
    ASSERT_TRUE(second) << second.error().text();
    EXPECT_TRUE(second->body->human);
    EXPECT_EQ(second->measured->skeleton.joints[0].name, all->characters[1]);
    EXPECT_EQ(second->measured->joint_count(), body::testing::made_character(2).joint_count());
  }
  IntakeOptions options;
  options.character = "3";
  const auto none = take_in(bvh, "two.bvh", nullptr, options);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().text().find("1 to 2"), std::string::npos) << none.error().text();
}

TEST(Choice, TakesAreChosenByNumberOrName) {
  for (const char* wanted : {"2", "run"}) {
    std::vector<MeasuredMotion> motions(3, body::testing::made_character(5));
    motions[0].name = "walk";
    motions[1].name = "run";
    motions[2].name = "jump";
    ASSERT_TRUE(choose_take(motions, wanted, "a.glb"));
    ASSERT_EQ(motions.size(), 1u);
    EXPECT_EQ(motions[0].name, "run");
  }
  std::vector<MeasuredMotion> motions(1, body::testing::made_character(5));
  EXPECT_FALSE(choose_take(motions, "swim", "a.glb"));
}

TEST(MappingFile, AWrittenMappingIsReadAndCorrectsTheBody) {
  const MeasuredMotion motion = body::testing::made_character(60);
  const std::string bvh = formats::write_bvh(motion);
  const auto plain = take_in(bvh, "walk.bvh");
  ASSERT_TRUE(plain) << plain.error().text();
  const std::string text = write_mapping(plain->body->anatomy);
  auto mapping = read_mapping(text, "walk.json");
  ASSERT_TRUE(mapping) << mapping.error().text();
  ASSERT_EQ(mapping->limbs.size(), plain->body->anatomy.limbs.size());
  EXPECT_EQ(mapping->plan, "human");
  IntakeOptions options;
  options.mapping = *mapping;
  const auto same = take_in(bvh, "walk.bvh", nullptr, options);
  ASSERT_TRUE(same) << same.error().text();
  EXPECT_EQ(same->body->height, plain->body->height);
  EXPECT_EQ(same->body->anatomy.confidence, 1);
  // The left hand begins at the forearm: the arm ends there.
  for (body::LimbMapping& l : options.mapping->limbs)
    for (body::SectionJoint& s : l.sections)
      if (l.name == "left arm" && s.section == "upper arm") s.joint = "Head";
  const auto refused = take_in(bvh, "walk.bvh", nullptr, options);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text().find("mapping"), std::string::npos) << refused.error().text();
}

TEST(MappingFile, DamagedFilesAreRefusedAtTheirField) {
  EXPECT_FALSE(read_mapping("", "m.json"));
  EXPECT_FALSE(read_mapping("[]", "m.json"));
  EXPECT_FALSE(read_mapping(R"({"format": "something else"})", "m.json"));
  EXPECT_FALSE(read_mapping(R"({"format": "ugoki anatomy mapping", "version": 2})", "m.json"));
  const auto wrong = read_mapping(R"({"format": "ugoki anatomy mapping", "limbs": [{"limb": 3, "wings": 2}]})", "m.json");
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().problems.size(), 2u) << wrong.error().text();
  EXPECT_TRUE(wrong.error().problems[0].location.starts_with("m.json:limbs/0")) << wrong.error().text();
}

}  // namespace
}  // namespace ugoki::intake
