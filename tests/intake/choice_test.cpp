// Files with several characters or motions, and mapping files.
#include "ugoki/intake/choice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>

#include "../body/measured_files.h"
#include "ugoki/body/recognise.h"
#include "ugoki/formats/bvh.h"
#include "ugoki/formats/gltf.h"
#include "ugoki/intake/intake.h"
#include "ugoki/intake/mapping_file.h"
#include "ugoki/spatial/elementary.h"

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
    const auto found = find_take(motions, wanted, "a.glb");
    ASSERT_TRUE(found) << found.error().text();
    EXPECT_EQ(*found, 1u);
  }
  std::vector<MeasuredMotion> motions(1, body::testing::made_character(5));
  EXPECT_FALSE(find_take(motions, "swim", "a.glb"));
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

/// Parts of a GLB file.
struct Glb {
  nlohmann::json json;
  std::vector<std::byte> data;
};
Glb split(const std::vector<std::byte>& bytes) {
  std::uint32_t length = 0, size = 0;
  std::memcpy(&length, bytes.data() + 12, 4);
  std::memcpy(&size, bytes.data() + 20 + length, 4);
  const auto* text = reinterpret_cast<const char*>(bytes.data()) + 20;
  const auto data = bytes.begin() + 28 + length;
  return {nlohmann::json::parse(text, text + length), {data, data + size}};
}
/// A GLB file with all animations of files with the same skeleton.
std::string with_all_takes(const std::vector<std::vector<std::byte>>& files) {
  Glb all = split(files[0]);
  for (std::size_t k = 1; k < files.size(); ++k) {
    Glb next = split(files[k]);
    const std::size_t views = all.json["bufferViews"].size(), accessors = all.json["accessors"].size(), start = all.data.size();
    for (auto& view : next.json["bufferViews"]) {
      view["byteOffset"] = view.value("byteOffset", std::size_t{0}) + start;
      all.json["bufferViews"].push_back(view);
    }
    for (auto& accessor : next.json["accessors"]) {
      accessor["bufferView"] = accessor["bufferView"].get<std::size_t>() + views;
      all.json["accessors"].push_back(accessor);
    }
    for (auto& animation : next.json["animations"]) {
      for (auto& sampler : animation["samplers"])
        for (const char* end : {"input", "output"}) sampler[end] = sampler[end].get<std::size_t>() + accessors;
      all.json["animations"].push_back(animation);
    }
    all.data.insert(all.data.end(), next.data.begin(), next.data.end());
    all.data.resize((all.data.size() + 3) / 4 * 4);
  }
  all.json["buffers"][0]["byteLength"] = all.data.size();
  std::string text = all.json.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::string glb;
  const auto word = [&](std::size_t value) {
    const auto v = static_cast<std::uint32_t>(value);
    char b[4];
    std::memcpy(b, &v, 4);
    glb.append(b, 4);
  };
  word(0x46546C67), word(2), word(28 + text.size() + all.data.size());
  word(text.size()), word(0x4E4F534A);
  glb += text;
  word(all.data.size()), word(0x004E4942);
  glb.append(reinterpret_cast<const char*>(all.data.data()), all.data.size());
  return glb;
}

/// A standing dog that sways for `frames` frames. @param fly m, way that the shanks move away from their thighs in a frame
MeasuredMotion swaying_dog(int frames, double fly) {
  MeasuredMotion m;
  m.name = "dog";
  m.rate = 30;
  m.frames = frames;
  const auto add = [&](const std::string& name, int parent, Vec3 offset, Vec3 end = {}) {
    SkeletonJoint joint;
    joint.name = name;
    joint.parent = parent;
    joint.offset = offset;
    joint.dofs = {{{0, 0, 1}}, {{0, 1, 0}}, {{1, 0, 0}}};
    joint.translates = true;
    if (norm(end) > 0) joint.end_sites = {end};
    m.skeleton.joints.push_back(std::move(joint));
    return static_cast<int>(m.skeleton.joints.size()) - 1;
  };
  const int hips = add("Hips", -1, {0, 0, 0.46}), spine = add("Spine", hips, {0.2, 0, 0}), chest = add("Chest", spine, {0.2, 0, 0});
  const int neck = add("Neck", chest, {0.12, 0, 0.1}), tail = add("Tail", hips, {-0.1, 0, 0});
  add("Head", neck, {0.1, 0, 0.1});
  add("TailTip", tail, {-0.2, 0, 0});
  for (const auto& [from, name] : {std::pair(hips, std::string("Back")), {chest, "Front"}})
    for (const auto& [side, y] : {std::pair(std::string(".L"), 0.07), {".R", -0.07}})
      add(name + "Paw" + side, add(name + "LowerLeg" + side, add(name + "UpperLeg" + side, from, {0, y, 0}), {0, 0, -0.23}), {0, 0, -0.2});
  for (int f = 0; f < m.frames; ++f)
    for (const SkeletonJoint& j : m.skeleton.joints) {
      const bool shank = j.name.find("LowerLeg") != std::string::npos;
      m.translations.push_back(j.offset + Vec3{0, 0, shank ? fly * f : 0.0});
      m.rotations.push_back(axis_angle({0, 1, 0}, j.name.find("Leg") != std::string::npos ? 0.05 * ugoki::sin(0.3 * f) : 0.0));
    }
  return m;
}

TEST(Takes, AnAnimalThatOtherTakesHideIsRecognisedInTheLongest) {
  // In a cartoon take the shanks fly away from the body.
  const std::vector<std::byte> cartoon = formats::write_glb(swaying_dog(60, 0.1));
  const auto alone = take_in(with_all_takes({cartoon}), "cartoon.glb");
  ASSERT_TRUE(alone) << alone.error().text();
  ASSERT_NE(alone->body->anatomy.plan, "four legs");
  const auto in = take_in(with_all_takes({formats::write_glb(swaying_dog(90, 0)), cartoon}), "takes.glb");
  ASSERT_TRUE(in) << in.error().text();
  EXPECT_EQ(in->body->anatomy.plan, "four legs");
  EXPECT_TRUE(std::ranges::any_of(in->report, [](const std::string& s) { return s.find("longest motion") != std::string::npos; }));
}

/// The dog without names of parts, upright on its tail if `upright`.
MeasuredMotion nameless_dog(int frames, bool upright) {
  MeasuredMotion m = swaying_dog(frames, 0);
  m.name = "motion";
  const auto n = m.skeleton.joints.size();
  for (std::size_t i = 0; i < n; ++i) m.skeleton.joints[i].name = "Bone" + std::to_string(i);
  for (std::size_t f = 0; upright && f < static_cast<std::size_t>(frames); ++f) m.rotations[f * n] = axis_angle({0, 1, 0}, -0.5 * pi);
  return m;
}

TEST(Takes, AnAnimalThatIsUprightInOtherTakesIsRecognisedInTheLongest) {
  const std::vector<std::byte> level = formats::write_glb(nameless_dog(90, false)), upright = formats::write_glb(nameless_dog(85, true));
  const auto alone = take_in(with_all_takes({upright}), "upright.glb");
  ASSERT_TRUE(alone) << alone.error().text();
  ASSERT_EQ(alone->body->anatomy.plan, "human");
  const auto in = take_in(with_all_takes({level, upright, upright, upright, upright}), "takes.glb");
  ASSERT_TRUE(in) << in.error().text();
  EXPECT_EQ(in->body->anatomy.plan, "four legs");
  // A file of this name contains an animal also if it is upright in the longest take.
  const std::vector<std::byte> longer = formats::write_glb(nameless_dog(95, true));
  for (const auto& [name, plan] : {std::pair{"dog.glb", "four legs"}, {"takes.glb", "human"}}) {
    const auto named = take_in(with_all_takes({level, level, level, level, longer}), name);
    ASSERT_TRUE(named) << named.error().text();
    EXPECT_EQ(named->body->anatomy.plan, plan) << name;
  }
}

TEST(Takes, NamesOfProgramsDoNotNameAMotion) {
  for (const char* name :
       {"", "Take 001", "Anim_0", "mixamo.com", "Armature|mixamo.com|Layer0", "Armature|Action.001", "AnimStack", "Scene"})
    EXPECT_TRUE(is_default_name(name)) << name;
  for (const char* name : {"walk", "Take off", "Armature|Run", "Action hero", "歩く"}) EXPECT_FALSE(is_default_name(name)) << name;
  MeasuredMotion dog = swaying_dog(30, 0);
  for (const auto& [name, wanted] : {std::pair{"Take 001", "rex"}, {"Gallop", "Gallop"}}) {
    dog.name = name;
    const std::vector<std::byte> file = formats::write_glb(dog);
    const auto in = take_in({reinterpret_cast<const char*>(file.data()), file.size()}, "folder/rex.glb");
    ASSERT_TRUE(in) << in.error().text();
    EXPECT_EQ(in->items[2].name, wanted);
  }
}

}  // namespace
}  // namespace ugoki::intake
