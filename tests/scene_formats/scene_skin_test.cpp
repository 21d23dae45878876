// Skins of FBX and COLLADA files: the vertices of a made file must move as its joints do.

#include "ugoki/scene_formats/scene_skin.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "made_scene.h"

namespace ugoki::scene_formats {
namespace {

struct Case {
  const char* format;
  const char* name;
};
constexpr Case cases[] = {{"collada", "made.dae"}, {"fbxa", "made.fbx"}};

std::span<const std::byte> bytes_of(const std::string& text) { return std::as_bytes(std::span(text.data(), text.size())); }

/// Head of a PNG file of 64 x 32 pixels; only its size is read.
std::vector<std::byte> picture() {
  std::vector<std::byte> out;
  for (const int b :
       {0x89, 0x50, 0x4e, 0x47, 13, 10, 26, 10, 0, 0, 0, 13, 0x49, 0x48, 0x44, 0x52, 0, 0, 0, 64, 0, 0, 0, 32, 8, 2, 0, 0, 0, 0, 0, 0, 0})
    out.push_back(static_cast<std::byte>(b));
  return out;
}

/// World position of a vertex in a frame of the motion.
Vec3 place_of(const formats::FileSkin& file, const MeasuredMotion& motion, const std::vector<Pose>& X, std::size_t v) {
  const Skin& s = file.skin;
  const Vec3 at{static_cast<double>(s.positions[3 * v]), static_cast<double>(s.positions[3 * v + 1]),
                static_cast<double>(s.positions[3 * v + 2])};
  Vec3 out;
  for (std::size_t k = 4 * v; k < 4 * v + 4; ++k) {
    if (s.weights[k] == 0) continue;
    const formats::FileBone& bone = file.bones[s.bones[k]];
    const auto& joints = motion.skeleton.joints;
    const auto j = std::ranges::find(joints, bone.joint, &SkeletonJoint::name) - joints.begin();
    out += s.weights[k] / 65535.0 * (X[static_cast<std::size_t>(j)] * (bone.A * at + bone.p));
  }
  return out;
}

TEST(SceneSkin, VerticesMoveWithTheJointsOfTheFile) {
  for (const Case& c : cases)
    for (const double unit : {1.0, 100.0}) {
      SCOPED_TRACE(testing::Message() << c.format << ", " << unit << " units a metre");
      const MeasuredMotion made = random_motion(7);
      const std::string file = make_scene_file(made, {.format = c.format, .units_per_metre = unit});
      const SceneOptions options{.metres_per_unit = 1 / unit};
      const auto motions = read_scene(bytes_of(file), c.name, options);
      ASSERT_TRUE(motions) << motions.error().text();
      formats::ReadNotes notes;
      const auto skin = read_scene_skin(bytes_of(file), c.name, options, {}, notes);
      ASSERT_TRUE(skin) << skin.error().text();
      const std::size_t joints = made.skeleton.joints.size();
      ASSERT_EQ(skin->skin.vertex_count(), 3 * joints);
      ASSERT_EQ(skin->skin.triangle_count(), joints);
      EXPECT_EQ(skin->skin.parts.at(0).color, "#336699");
      EXPECT_TRUE(notes.remarks.empty()) << notes.remarks[0];
      // The mesh has three vertices at each joint: at the joint, and 0.1 file units along x and y of the file from it.
      const double step = 0.1 / unit;
      std::vector<std::size_t> number(skin->skin.vertex_count());
      double worst = 0;
      for (int f = 0; f < made.frames; ++f) {
        std::vector<Pose> wanted, X;
        made.calc_joint_poses(f, wanted);
        motions->front().calc_joint_poses(f, X);
        std::vector<Vec3> points;
        for (std::size_t j = 0; j < joints; ++j)
          for (const Vec3& d : {Vec3{}, Vec3{0, step, 0}, Vec3{0, 0, step}}) points.push_back(wanted[j] * d);
        for (std::size_t v = 0; v < number.size(); ++v) {
          const Vec3 p = place_of(*skin, motions->front(), X, v);
          if (f == 0)
            number[v] =
                static_cast<std::size_t>(std::ranges::min_element(points, {}, [&](const Vec3& q) { return norm(q - p); }) - points.begin());
          worst = std::max(worst, norm(points[number[v]] - p));
        }
      }
      std::ranges::sort(number);
      EXPECT_EQ(std::ranges::unique(number).begin(), number.end()) << "each point of the mesh is one vertex";
      EXPECT_LT(worst, 2e-5) << "m";
    }
}

TEST(SceneSkin, ShowsPicturesBesideTheFile) {
  for (const Case& c : cases) {
    SCOPED_TRACE(c.format);
    const std::string file = make_scene_file(random_motion(3, 2), {.format = c.format, .texture = "cloth.png"});
    formats::ReadNotes notes;
    const auto with = read_scene_skin(
        bytes_of(file), c.name, {},
        [](std::string_view name) -> Result<std::vector<std::byte>> {
          if (name == "cloth.png") return picture();
          return fail(ErrorCode::io, std::string(name), "missing", "");
        },
        notes);
    ASSERT_TRUE(with) << with.error().text();
    ASSERT_EQ(with->skin.textures.size(), 1U);
    EXPECT_EQ(with->skin.textures[0].type, "image/png");
    EXPECT_EQ(with->skin.parts.at(0).texture, 0);
    EXPECT_EQ(with->skin.parts[0].color, "#ffffff") << "the picture replaces the colour";
    EXPECT_EQ(with->skin.uvs.at(0), 0.25f);
    EXPECT_EQ(with->skin.uvs.at(1), 0.25f) << "v is counted from the top";
    const auto without = read_scene_skin(bytes_of(file), c.name, {}, {}, notes);
    ASSERT_TRUE(without) << without.error().text();
    EXPECT_EQ(without->skin.parts.at(0).texture, -1);
    ASSERT_FALSE(notes.remarks.empty());
    EXPECT_NE(notes.remarks.back().find("cloth.png"), std::string::npos) << notes.remarks.back();
  }
}

TEST(SceneSkin, FilesWithoutMeshesAndDamagedFilesHaveNone) {
  formats::ReadNotes notes;
  for (const Case& c : cases) {
    SCOPED_TRACE(c.format);
    const std::string bare = make_scene_file(random_motion(3, 2), {.format = c.format, .skin = false});
    const auto none = read_scene_skin(bytes_of(bare), c.name, {}, {}, notes);
    ASSERT_TRUE(none) << none.error().text();
    EXPECT_TRUE(none->skin.indices.empty());
    const std::string file = make_scene_file(random_motion(3, 2), {.format = c.format});
    const auto cut = read_scene_skin(bytes_of(file).first(file.size() / 2), c.name, {}, {}, notes);
    EXPECT_FALSE(cut);
  }
}

}  // namespace
}  // namespace ugoki::scene_formats
