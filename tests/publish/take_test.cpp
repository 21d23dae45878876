// Takes, and their files read by independent readers.

#include "ugoki/publish/take.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "../content/fixture.h"
#include "ugoki/formats/gltf.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/publish/shape_surface.h"
#include "ugoki/scene_formats/mesh_scene.h"
#include "ugoki/scene_formats/usd.h"

namespace ugoki::publish {
namespace {

using content::Player;

Player open() {
  const auto bytes = content::generate(content::testing::make_scenario(), content::testing::make_resources());
  EXPECT_TRUE(bytes);
  auto player = Player::open(*bytes, "park.ugx");
  EXPECT_TRUE(player) << player.error().text();
  return std::move(*player);
}

Take take_of(double duration, double rate) {
  Player player = open();
  Result<Take> take = record_take(player, duration, rate);
  EXPECT_TRUE(take);
  return std::move(*take);
}

TEST(Take, HasThePosesOfTheRun) {
  const Take take = take_of(0.5, 50);
  EXPECT_EQ(take.frames, 26);
  ASSERT_EQ(take.characters.size(), 2u);
  Player player = open();
  for (int f = 0; f < take.frames; ++f) {
    while (player.step_count() < static_cast<std::uint64_t>(10 * f)) ASSERT_TRUE(player.step());
    for (std::size_t c = 0; c < 2; ++c) {
      const TakeCharacter& character = take.characters[c];
      std::vector<Pose> X(character.links());
      calc_poses(*character.mechanism, player.q(static_cast<int>(c)), X);
      for (std::size_t l = 0; l < X.size(); ++l) {
        EXPECT_LT(norm(X[l].p - character.pose(f, l).p), 1e-12);
        const Quat q = to_quat(X[l].R), r = character.pose(f, l).r;
        EXPECT_NEAR(std::fabs(q.w * r.w + dot(q.vec(), r.vec())), 1, 1e-12);
      }
    }
  }
}

TEST(Take, CanBeCancelled) {
  Player player = open();
  const auto take = record_take(player, 5, 50, [](double done) { return done < 0.1; });
  ASSERT_FALSE(take);
  EXPECT_NE(take.error().text().find("cancelled"), std::string::npos);
}

TEST(TakeGlb, IsReadWithTheSameWorldPositions) {
  const Take take = take_of(1, 60);
  const auto motions = formats::read_gltf(write_take_glb(take), "park.glb", {.rate = 60});
  ASSERT_TRUE(motions) << motions.error().text();
  ASSERT_EQ(motions->size(), 1u);
  const MeasuredMotion& m = motions->front();
  ASSERT_EQ(m.frames, take.frames);
  int found = 0;
  for (std::size_t j = 0; j < m.skeleton.joints.size(); ++j) {
    for (const TakeCharacter& c : take.characters)
      for (std::size_t l = 0; l < c.links(); ++l) {
        if (c.mechanism->link(static_cast<int>(l)).name != m.skeleton.joints[j].name) continue;
        ++found;
        for (int f = 0; f < m.frames; ++f) {
          Vec3 p;
          Quat r;
          // The world position of joint j follows from the chain of its parents.
          std::vector<std::size_t> chain;
          for (int k = static_cast<int>(j); k >= 0; k = m.skeleton.joints[static_cast<std::size_t>(k)].parent)
            chain.push_back(static_cast<std::size_t>(k));
          for (auto k = chain.rbegin(); k != chain.rend(); ++k) {
            const std::size_t at = static_cast<std::size_t>(f) * m.skeleton.joints.size() + *k;
            p += rotate(r, m.translations[at]);
            r = r * m.rotations[at];
          }
          EXPECT_LT(norm(p - c.pose(f, l).p), 1e-5) << m.skeleton.joints[j].name << " frame " << f;
        }
      }
  }
  EXPECT_EQ(found, 3) << "pelvis, leg and ball";
}

TEST(TakeGlb, ShapesHaveTheirColours) {
  Take take = take_of(0.1, 60);
  take.characters[0].color = "#804020";
  take.characters[0].shape_colors = {"", "#102030"};
  take.characters[1].color = "#ff8000";
  const Result<scene_formats::MeshScene> scene = scene_formats::read_mesh_scene(write_take_glb(take), "park.glb");
  ASSERT_TRUE(scene) << scene.error().text();
  EXPECT_TRUE(scene->skinned);
  std::map<std::string, std::size_t> triangles;
  for (const scene_formats::MeshPart& part : scene->parts) triangles[part.color] += part.triangles.size();
  std::map<std::string, std::size_t> wanted;
  for (const TakeCharacter& c : take.characters) {
    std::size_t shape = 0;
    for (std::size_t l = 0; l < c.links(); ++l)
      for (const Shape& s : c.mechanism->link(static_cast<int>(l)).shapes) {
        if (!s.visible) continue;
        Surface surface;
        add_surface(s, surface);
        wanted[shape == 1 && !c.shape_colors.empty() ? "#102030" : c.color] += surface.triangles.size();
        ++shape;
      }
  }
  EXPECT_EQ(triangles, wanted);
}

TEST(TakeCsv, HasARowForEachFrameAndNumbersOfTheRun) {
  const Take take = take_of(0.2, 50);
  std::istringstream lines(write_take_csv(take));
  std::string line;
  std::getline(lines, line);
  EXPECT_TRUE(line.starts_with("time,human/centre of mass x,")) << line;
  const std::size_t columns = 1 + 2 * 3 + 3 * 7;
  EXPECT_EQ(std::ranges::count(line, ','), static_cast<long>(columns - 1));
  for (int f = 0; f < take.frames; ++f) {
    ASSERT_TRUE(std::getline(lines, line));
    std::vector<double> row;
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) row.push_back(std::stod(cell));
    ASSERT_EQ(row.size(), columns);
    EXPECT_NEAR(row[0], f / 50.0, 1e-8);
    EXPECT_NEAR(row[4], take.characters[0].pose(f, 0).p.x, 1e-7);
    EXPECT_NEAR(row[1 + 3 + 14 + 3 + 2], take.characters[1].pose(f, 0).p.z, 1e-7);
  }
  EXPECT_FALSE(std::getline(lines, line));
}

TEST(TakeUsda, HasSkeletonAnimationMeshAndCamera) {
  const Take take = take_of(0.1, 50);
  const std::string text = write_take_usda(take);
  EXPECT_TRUE(text.starts_with("#usda 1.0\n"));
  for (const char* wanted : {"upAxis = \"Z\"", "metersPerUnit = 1", "timeCodesPerSecond = 50", "endTimeCode = 5", "def SkelRoot \"Human\"",
                             "\"pelvis\", \"pelvis/leg\"", "def SkelAnimation", "def Mesh \"Surface\"", "def Camera \"Camera\""})
    EXPECT_NE(text.find(wanted), std::string::npos) << wanted;
  EXPECT_EQ(std::ranges::count(text, '{'), std::ranges::count(text, '}'));
  EXPECT_EQ(std::ranges::count(text, '('), std::ranges::count(text, ')'));
}

TEST(TakeView, LooksAtTheFollowedCharacterFromItsDistance) {
  const Take take = take_of(1, 60);
  for (const int f : {0, 30, 60}) {
    const TakeView v = view_at(take, f);
    const Vec3 to = take.characters[0].centres[static_cast<std::size_t>(f)] - v.position;
    EXPECT_NEAR(norm(to), take.camera.distance, 0.3);
    EXPECT_GT(dot(normalized(to), -v.back), 0.99);
    EXPECT_NEAR(dot(v.right, v.up), 0, 1e-12);
    EXPECT_GT(v.up.z, 0);
    EXPECT_LT(norm(cross(v.right, v.up) - v.back), 1e-12) << "right-handed";
  }
}

TEST(Take, UsdIsReadBackWithTheSamePositions) {
  const Take take = take_of(0.5, 50);
  const auto motion = scene_formats::read_usd(write_take_usda(take), "take.usda");
  ASSERT_TRUE(motion.has_value()) << motion.error().text();
  EXPECT_EQ(motion->frames, take.frames);
  EXPECT_EQ(motion->rate, take.rate);
  std::size_t links = 0;
  for (const TakeCharacter& c : take.characters) links += c.links();
  ASSERT_EQ(motion->skeleton.joints.size(), links);
  double worst = 0;
  for (int f = 0; f < take.frames; ++f) {
    std::vector<Pose> X;
    motion->calc_joint_poses(f, X);
    std::size_t joint = 0;
    for (const TakeCharacter& c : take.characters) {
      std::vector<Vec3> known;
      for (std::size_t l = 0; l < c.links(); ++l) known.push_back(c.pose(f, l).p);
      // the reader may sort the joints, so each link is looked for among the joints of its character
      for (const Vec3& p : known) {
        double best = 1e9;
        for (std::size_t k = 0; k < c.links(); ++k) best = std::min(best, norm(X[joint + k].p - p));
        worst = std::max(worst, best);
      }
      joint += c.links();
    }
  }
  EXPECT_LT(worst, 1e-6);
}

}  // namespace
}  // namespace ugoki::publish
