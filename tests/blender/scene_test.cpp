// Blender makes a skinned, animated character and writes it as binary FBX and COLLADA. Our reader must find every joint at its position.
#include <gtest/gtest.h>

#include <cstdio>
#include <sstream>

#include "run_blender.h"
#include "ugoki/scene_formats/scene_file.h"

namespace ugoki {
namespace {

/// Output of make_character.py: heads of bones in Blender's world axes, m.
struct Expected {
  double rate = 0;
  std::vector<std::string> names;
  std::vector<std::vector<Vec3>> frames;  ///< [frames][names]
};

Expected read_expected(const std::string& text) {
  Expected out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "rate") {
      words >> out.rate;
    } else if (word == "frame") {
      out.frames.emplace_back();
    } else {
      Vec3 p{std::strtod(word.c_str(), nullptr)};
      words >> p.y >> p.z >> std::ws;
      std::getline(words, word);
      out.frames.back().push_back(p);
      if (out.frames.size() == 1) out.names.push_back(word);
    }
  }
  return out;
}

/// Name of a joint in COLLADA, which uses identifiers: "bone.1" of "character" becomes "character_bone_1".
std::string name_in(const std::string& ending, std::string bone) {
  if (ending != ".dae") return bone;
  for (char& c : bone)
    if (c == '.' || c == ' ') c = '_';
  return "character_" + bone;
}

int joint_named(const Skeleton& s, const std::string& name) {
  for (std::size_t i = 0; i < s.joints.size(); ++i)
    if (s.joints[i].name == name) return static_cast<int>(i);
  return -1;
}

void expect_reader_agrees(const std::string& ending, int seed) {
  SCOPED_TRACE(ending + " " + std::to_string(seed));
  const TemporaryFolder folder;
  ASSERT_FALSE(folder.path.empty());
  const std::string file = folder.path + "/character" + ending;
  const BlenderOutput blender =
      run_blender("make_character.py", file + " " + folder.path + "/expected.txt " + std::to_string(seed), folder);
  ASSERT_EQ(blender.status, 0) << blender.text;
  const Expected expected = read_expected(text_of_file(folder.path + "/expected.txt"));
  ASSERT_EQ(expected.frames.size(), 40u);
  ASSERT_EQ(expected.names.size(), 12u);
  const std::string bytes = text_of_file(file);
  if (ending == ".fbx") ASSERT_TRUE(bytes.starts_with("Kaydara FBX Binary"));

  formats::ReadNotes notes;
  const auto read = scene_formats::read_scene(std::as_bytes(std::span(bytes)), "character" + ending, {}, &notes);
  ASSERT_TRUE(read.has_value()) << read.error().text();
  ASSERT_EQ(read->size(), 1u);
  const MeasuredMotion& m = read->front();
  EXPECT_NEAR(m.rate, expected.rate, 1e-4);
  ASSERT_EQ(m.frames, 40);
  EXPECT_EQ(notes.z_up, ending == ".dae");
  double worst = 0;
  std::vector<Pose> X(static_cast<std::size_t>(m.joint_count()));
  for (int f = 0; f < m.frames; ++f) {
    m.calc_joint_poses(f, X);
    for (std::size_t i = 0; i < expected.names.size(); ++i) {
      const int joint = joint_named(m.skeleton, name_in(ending, expected.names[i]));
      ASSERT_GE(joint, 0) << expected.names[i];
      const Vec3& p = expected.frames[static_cast<std::size_t>(f)][i];
      // COLLADA from Blender keeps Blender's axes (Z up). FBX from Blender has Y up; its Z axis is Blender's -Y axis, our forward axis.
      const Vec3 ours = ending == ".dae" ? p : Vec3{-p.y, p.x, p.z};
      worst = std::max(worst, norm(X[static_cast<std::size_t>(joint)].p - ours));
    }
  }
  EXPECT_LT(worst, 1e-4);
  std::printf("%s, character %d: %d joints, %d frames, maximum error %.3g m\n", ending.c_str(), seed, m.joint_count(), m.frames, worst);
}

TEST(Slow_BlenderScenes, OurReaderFindsTheJointsOfItsFbx) {
  if (!blender_is_installed()) GTEST_SKIP() << "Blender is not installed";
  for (const int seed : {1, 2, 3}) expect_reader_agrees(".fbx", seed);
}

TEST(Slow_BlenderScenes, OurReaderFindsTheJointsOfItsCollada) {
  if (!blender_is_installed()) GTEST_SKIP() << "Blender is not installed";
  for (const int seed : {1, 2, 3}) expect_reader_agrees(".dae", seed);
}

}  // namespace
}  // namespace ugoki
