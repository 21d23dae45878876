// Cameras, shots and looks of the scenario document: JSON form, checks, commands, and the view between keys.

#include "ugoki/content/film.h"

#include <gtest/gtest.h>

#include <array>

#include "fixture.h"
#include "ugoki/content/commands.h"
#include "ugoki/content/executable.h"
#include "ugoki/content/mechanism_display.h"

namespace ugoki::content {
namespace {

using testing::make_resources;
using testing::make_scenario;

class FilmTest : public ::testing::Test {
 protected:
  std::string good(const std::string& command) {
    auto effect = apply_command(document, command, catalogue, next_id);
    EXPECT_TRUE(effect) << command << "\n" << (effect ? "" : effect.error().text());
    if (!effect) return {};
    document = std::move(effect->scenario);
    return effect->label;
  }
  void bad(const std::string& command, ErrorCode code, const std::string& location) {
    const auto effect = apply_command(document, command, catalogue, next_id);
    ASSERT_FALSE(effect) << command;
    EXPECT_EQ(effect.error().problems.front().code, code) << effect.error().text();
    EXPECT_EQ(effect.error().problems.front().location, location) << effect.error().text();
    EXPECT_FALSE(effect.error().problems.front().remedy.empty());
  }
  void add_film() {
    good(R"({"type": "camera.add", "camera": {"id": "wide", "name": "Wide"}})");
    good(R"({"type": "camera.add", "camera": {"id": "near", "follow": "human", "target": [0, 0, 1.2], "distance": 2,
        "keys": [{"time": 4, "distance": 3}, {"time": 1}]}})");
    good(R"({"type": "shot.add", "shot": {"id": "h1", "camera": "wide", "start": 0, "length": 3}})");
    good(R"({"type": "shot.add", "shot": {"id": "h2", "camera": "near", "start": 2, "length": 4}})");
  }

  Resources resources = make_resources();
  Catalogue catalogue = catalogue_of(resources);
  Scenario document = make_scenario();
  std::uint64_t next_id = 1;
};

TEST_F(FilmTest, ADocumentWithoutCamerasHasItsFormerText) {
  const std::string text = write_scenario(document);
  for (const char* key : {"cameras", "shots", "ambient", "sun", "sky", "pattern", "roughness", "metalness", "link_colors"})
    EXPECT_EQ(text.find('"' + std::string(key) + '"'), std::string::npos) << key;
}

TEST_F(FilmTest, CamerasShotsAndLooksSurviveWritingAndReading) {
  add_film();
  good(R"({"type": "scenario.set", "look": {"ambient": 0.5, "pattern": "boards", "sun": {"elevation": 0.4, "color": "#ffb070"},
      "sky": {"zenith": "#203050", "horizon": "#c08060"}}})");
  good(R"({"type": "character.set", "id": "human", "roughness": 0.2, "metalness": 1, "link_colors": {"leg": "#102030"}})");
  const std::string text = write_scenario(document);
  const auto read = read_scenario(text, "scenario");
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(*read, document);
  EXPECT_EQ(write_scenario(*read), text);
  EXPECT_EQ(document.look.sun.azimuth, SunLight().azimuth) << "fields that the command does not give are kept";
}

TEST_F(FilmTest, CommandsEditCamerasAndShots) {
  add_film();
  ASSERT_EQ(document.cameras.size(), 2u);
  EXPECT_EQ(document.cameras[1].name, "Camera 2");
  ASSERT_EQ(document.cameras[1].keys.size(), 2u);
  EXPECT_EQ(document.cameras[1].keys[0].time, 1) << "sorted by time";
  EXPECT_EQ(document.cameras[1].keys[0].view.distance, 2) << "a key has the camera's values for absent fields";
  EXPECT_EQ(good(R"({"type": "camera.set", "id": "near", "camera": {"name": "Close"}})"), "Rename camera");
  EXPECT_EQ(good(R"({"type": "camera.set", "id": "near", "camera": {"azimuth": 1}})"), "Move camera");
  EXPECT_EQ(good(R"({"type": "camera.set", "id": "near", "camera": {"keys": []}})"), "Remove camera key");
  EXPECT_EQ(good(R"({"type": "camera.set", "id": "near", "camera": {"keys": [{"time": 1}]}})"), "Key camera");
  EXPECT_EQ(good(R"({"type": "shot.set", "id": "h2", "shot": {"start": 2.5}})"), "Move shot");
  EXPECT_EQ(good(R"({"type": "shot.set", "id": "h2", "shot": {"length": 1}})"), "Trim shot");
  EXPECT_EQ(good(R"({"type": "shot.set", "id": "h2", "shot": {"camera": "wide"}})"), "Change camera of shot");
  EXPECT_EQ(good(R"({"type": "shot.remove", "id": "h2"})"), "Remove shot");
  EXPECT_EQ(good(R"({"type": "camera.remove", "id": "wide"})"), "Remove camera");
  EXPECT_TRUE(document.shots.empty()) << "the shots of the camera are removed as well";
  EXPECT_EQ(good(R"({"type": "character.remove", "id": "human"})"), "Remove character");
  EXPECT_TRUE(document.cameras[0].follow.empty());
}

TEST_F(FilmTest, RefusesInvalidValues) {
  add_film();
  bad(R"({"type": "camera.add", "camera": {"id": "k1"}})", ErrorCode::duplicate, "scenario/cameras/2/id");
  bad(R"({"type": "camera.set", "id": "near", "camera": {"follow": "nobody"}})", ErrorCode::unknown, "scenario/cameras/1/follow");
  bad(R"({"type": "camera.set", "id": "near", "camera": {"field_of_view": 0}})", ErrorCode::range, "scenario/cameras/1/field_of_view");
  bad(R"({"type": "camera.set", "id": "near", "camera": {"keys": [{"time": 1}, {"time": 1}]}})", ErrorCode::structure,
      "scenario/cameras/1/keys/1/time");
  bad(R"({"type": "camera.set", "id": "near", "camera": {"zoom": 2}})", ErrorCode::unknown, "command/camera/zoom");
  bad(R"({"type": "shot.add", "shot": {"camera": "none", "start": 8}})", ErrorCode::unknown, "scenario/shots/2/camera");
  bad(R"({"type": "shot.set", "id": "h2", "shot": {"start": 0}})", ErrorCode::structure, "scenario/shots/1/start");
  bad(R"({"type": "shot.set", "id": "h2", "shot": {"length": 0}})", ErrorCode::range, "scenario/shots/1/length");
  bad(R"({"type": "shot.remove", "id": "none"})", ErrorCode::unknown, "command/id");
  bad(R"({"type": "scenario.set", "look": {"pattern": "carpet"}})", ErrorCode::unknown, "scenario/look/pattern");
  bad(R"({"type": "scenario.set", "look": {"sky": {"zenith": "#102030"}}})", ErrorCode::structure, "command/look/sky/horizon");
  bad(R"({"type": "scenario.set", "look": {"sun": {"color": "red"}}})", ErrorCode::syntax, "scenario/look/sun/color");
  bad(R"({"type": "character.set", "id": "human", "roughness": 1.5})", ErrorCode::range, "scenario/characters/0/roughness");
  bad(R"({"type": "character.set", "id": "human", "link_colors": {"tail": "#102030"}})", ErrorCode::unknown,
      "scenario/characters/0/link_colors/tail");
}

TEST_F(FilmTest, TheShotThatStartsLastIsShown) {
  add_film();
  const auto camera_at = [&](double time) {
    const FilmShot* shot = shot_at(document.shots, time);
    return shot ? shot->camera : "";
  };
  EXPECT_EQ(camera_at(0), "wide");
  EXPECT_EQ(camera_at(1.999), "wide");
  EXPECT_EQ(camera_at(2), "near");
  EXPECT_EQ(camera_at(5.999), "near");
  EXPECT_EQ(camera_at(6), "") << "the end of a shot is outside";
}

/// A camera with keys at 1, 2, 4 and 5 s.
FilmCamera keyed_camera() {
  FilmCamera camera;
  for (const auto& [time, azimuth, distance] : {std::array{1.0, 0.0, 5.0}, {2.0, 1.0, 3.0}, {4.0, 2.5, 2.5}, {5.0, 2.0, 1.0}}) {
    FilmKey key;
    key.time = time;
    key.view.azimuth = azimuth;
    key.view.distance = distance;
    camera.keys.push_back(key);
  }
  return camera;
}

TEST(Film, ViewsBetweenKeysFollowTheMonotoneCubic) {
  const FilmCamera camera = keyed_camera();
  // computed in power form with Brodlie's formula for the slopes; web/test/film.test.ts has the same values
  const double times[] = {0.5, 1.25, 2, 2.5, 3.5, 4.5, 6};
  const double azimuths[] = {0, 0.115423387097, 1.0, 1.479334677419, 2.347278225806, 2.25, 2.0};
  const double distances[] = {5, 4.710304054054, 3.0, 2.828692917055, 2.66344361603, 1.691810344828, 1.0};
  for (std::size_t i = 0; i < 7; ++i) {
    const FilmView view = view_of(camera, times[i]);
    EXPECT_NEAR(view.azimuth, azimuths[i], 1e-11) << times[i];
    EXPECT_NEAR(view.distance, distances[i], 1e-11) << times[i];
    EXPECT_EQ(view.field_of_view, FilmView().field_of_view);
  }
}

TEST(Film, ViewsNeverExceedTheirKeys) {
  const FilmCamera camera = keyed_camera();
  double before = 6;
  for (int i = 0; i <= 600; ++i) {
    const FilmView view = view_of(camera, i / 100.0);
    EXPECT_LE(view.distance, before + 1e-12) << "the distance falls from key to key";
    EXPECT_TRUE(view.azimuth >= 0 && view.azimuth <= 2.5) << view.azimuth;
    before = view.distance;
  }
}

TEST_F(FilmTest, ExecutableDataContainCamerasAndShots) {
  add_film();
  good(R"({"type": "character.set", "id": "ball", "metalness": 0.5})");
  const auto bytes = generate(document, resources);
  ASSERT_TRUE(bytes) << bytes.error().text();
  const auto content = read_executable(*bytes, "park.ugx");
  ASSERT_TRUE(content) << content.error().text();
  EXPECT_EQ(content->cameras, document.cameras);
  EXPECT_EQ(content->shots, document.shots);
  const std::string scene = scene_json(*content);
  EXPECT_NE(scene.find(R"("shots":[{"id":"h1")"), std::string::npos) << scene.substr(0, 400);
  EXPECT_NE(scene.find(R"("metalness":0.5)"), std::string::npos);
}

TEST_F(FilmTest, ACameraThatFollowsAMutedCharacterFollowsNone) {
  add_film();
  good(R"({"type": "character.set", "id": "human", "muted": true})");
  EXPECT_TRUE(played_part(document).cameras[1].follow.empty());
}

}  // namespace
}  // namespace ugoki::content
