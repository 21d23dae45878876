#include "ugoki/content/scenario.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "fixture.h"

namespace ugoki::content {
namespace {

using testing::make_resources;
using testing::make_scenario;

/// True if the error has a problem with this location and a message.
bool has_location(const Error& error, const std::string& location) {
  for (const Problem& p : error.problems)
    if (p.location == location && !p.message.empty()) return true;
  return false;
}

TEST(Scenario, WritesAndReadsBack) {
  const Scenario s = make_scenario();
  const std::string text = write_scenario(s);
  const auto back = read_scenario(text, "park.json");
  ASSERT_TRUE(back) << back.error().text();
  EXPECT_EQ(*back, s);
  EXPECT_EQ(write_scenario(*back), text);
}

TEST(Scenario, WritesMarkersRangeAndSwitchesOnlyIfTheyAreSet) {
  Scenario s = make_scenario();
  for (const char* name : {"markers", "range", "muted", "solo", "locked"})
    EXPECT_EQ(write_scenario(s).find(name), std::string::npos) << name;
  s.markers = {{"m1", 1.5, "Jump"}};
  s.range = {1, 2.5};
  s.characters[0].muted = s.characters[0].locked = s.characters[1].solo = true;
  const auto back = read_scenario(write_scenario(s), "park.json");
  ASSERT_TRUE(back) << back.error().text();
  EXPECT_EQ(*back, s);
}

TEST(Scenario, ReadsTheFormerNameOfRelease) {
  std::string text = write_scenario(make_scenario());
  const std::string present = text;
  for (std::size_t at = text.find("\"release\""); at != std::string::npos; at = text.find("\"release\"", at))
    text.replace(at, 9, "\"let_go\"");
  ASSERT_NE(text, present);
  const auto s = read_scenario(text, "old.json");
  ASSERT_TRUE(s) << s.error().text();
  EXPECT_EQ(write_scenario(*s), present);
}

TEST(Scenario, ReadsTheExampleOfItsDocumentation) {
  std::ifstream file(std::string(UGOKI_SOURCE_DIR) + "/docs/scenario.md");
  std::stringstream all;
  all << file.rdbuf();
  const std::string page = all.str();
  const auto begin = page.find("```json"), end = page.find("```", begin + 7);
  ASSERT_NE(begin, std::string::npos);
  const auto s = read_scenario(std::string_view(page).substr(begin + 7, end - begin - 7), "scenario");
  EXPECT_TRUE(s) << s.error().text();
}

TEST(Scenario, AbsentFieldsHaveDefaults) {
  const auto s = read_scenario(R"({"version": 1})", "x");
  ASSERT_TRUE(s) << s.error().text();
  EXPECT_EQ(*s, Scenario());
}

TEST(Scenario, ReportsAllProblemsWithTheirPaths) {
  const auto s = read_scenario(
      R"({"version": 1, "duration": "long", "frame_rat": 60, "gravity": [0, 0], "characters": [{"id": "a", "track": [{"speed": "x"}]}, 7], "events": {}})",
      "f");
  ASSERT_FALSE(s);
  for (const char* location : {"f/duration", "f/frame_rat", "f/gravity", "f/characters/0/track/0/speed", "f/characters/0/track/0/length",
                               "f/characters/1", "f/events"})
    EXPECT_TRUE(has_location(s.error(), location)) << location << " in\n" << s.error().text();
  for (const Problem& p : s.error().problems) EXPECT_FALSE(p.remedy.empty()) << p.text();
}

TEST(Scenario, SyntaxErrorsNameLineAndColumn) {
  const auto s = read_scenario("{\n\"version\": 1,\n\"name\" \"x\"\n}", "park.json");
  ASSERT_FALSE(s);
  EXPECT_EQ(s.error().problems.front().location, "park.json:3:8");
}

TEST(Scenario, RefusesNewerDocuments) {
  const auto s = read_scenario(R"({"version": 3, "future": true})", "f");
  ASSERT_FALSE(s);
  EXPECT_EQ(s.error().problems.front().code, ErrorCode::unsupported);
}

TEST(Scenario, ReportsEveryInvalidValueWithItsLocation) {
  const auto resources = make_resources();
  const Catalogue catalogue = catalogue_of(resources);
  ASSERT_TRUE(check_scenario(make_scenario(), &catalogue).empty()) << check_scenario(make_scenario(), &catalogue).text();
  struct Case {
    const char* location;
    void (*spoil)(Scenario&);
  };
  const Case cases[] = {
      {"scenario/range", [](Scenario& s) { s.range = {3, 2}; }},
      {"scenario/range/to", [](Scenario& s) { s.range = {3, 1e9}; }},
      {"scenario/markers/0/time", [](Scenario& s) { s.markers = {{"m1", -1, "Jump"}}; }},
      {"scenario/markers/0/name", [](Scenario& s) { s.markers = {{"m1", 1, ""}}; }},
      {"scenario/markers/0/id", [](Scenario& s) { s.markers = {{"e1", 1, "Jump"}}; }},
      {"scenario/name", [](Scenario& s) { s.name.clear(); }},
      {"scenario/duration", [](Scenario& s) { s.duration = 0; }},
      {"scenario/duration", [](Scenario& s) { s.duration = 1e9; }},
      {"scenario/frame_rate", [](Scenario& s) { s.frame_rate = 61; }},
      {"scenario/step", [](Scenario& s) { s.step = 0.01; }},
      {"scenario/gravity", [](Scenario& s) { s.gravity.x = 1e6; }},
      {"scenario/ground/friction", [](Scenario& s) { s.ground.friction = -1; }},
      {"scenario/ground/restitution", [](Scenario& s) { s.ground.restitution = 2; }},
      {"scenario/look/floor", [](Scenario& s) { s.look.floor = "red"; }},
      {"scenario/look/light", [](Scenario& s) { s.look.light = 3; }},
      {"scenario/camera/follow", [](Scenario& s) { s.camera.follow = "nobody"; }},
      {"scenario/camera/distance", [](Scenario& s) { s.camera.distance = 0; }},
      {"scenario/characters/0/id", [](Scenario& s) { s.characters[0].id = "a b"; }},
      {"scenario/characters/1/id", [](Scenario& s) { s.characters[1].id = "k1"; }},
      {"scenario/characters/0/color", [](Scenario& s) { s.characters[0].color = "#12345g"; }},
      {"scenario/characters/0/mechanism", [](Scenario& s) { s.characters[0].mechanism = "m-none"; }},
      {"scenario/characters/0/mechanism", [](Scenario& s) { s.characters[0].mechanism = "../../etc/passwd"; }},
      {"scenario/characters/0/place", [](Scenario& s) { s.characters[0].place.x = 1e7; }},
      {"scenario/characters/0/control/tracking", [](Scenario& s) { s.characters[0].control.tracking = 3; }},
      {"scenario/characters/0/control/assist_limit", [](Scenario& s) { s.characters[0].control.assist_limit = -1; }},
      {"scenario/characters/0/track/0/motion", [](Scenario& s) { s.characters[0].track[0].motion = "n-none"; }},
      {"scenario/characters/1/track/0/motion",
       [](Scenario& s) { s.characters[1].track.push_back({"k9", "n-walk", 0, 1, 0, 1, 0, false}); }},
      {"scenario/characters/0/track/0/length", [](Scenario& s) { s.characters[0].track[0].length = 0; }},
      {"scenario/characters/0/track/0/length", [](Scenario& s) { s.characters[0].track[0].length = 2.5; }},
      {"scenario/characters/0/track/0/speed", [](Scenario& s) { s.characters[0].track[0].speed = 0; }},
      {"scenario/characters/0/track/0/start", [](Scenario& s) { s.characters[0].track[0].start = -1; }},
      {"scenario/characters/0/track/0/loop", [](Scenario& s) { s.characters[0].track[0].loop = true; }},
      {"scenario/characters/0/track/1/offset", [](Scenario& s) { s.characters[0].track[1].offset = 1.5; }},
      {"scenario/characters/0/track/1/start", [](Scenario& s) { s.characters[0].track[1].start = 0; }},
      {"scenario/events/0/time", [](Scenario& s) { s.events[0].time = -1; }},
      {"scenario/events/0/link", [](Scenario& s) { s.events[0].link = "wing"; }},
      {"scenario/events/0/force", [](Scenario& s) { s.events[0].force.y = 1e9; }},
      {"scenario/events/0/duration", [](Scenario& s) { s.events[0].duration = 0; }},
      {"scenario/events/1/character", [](Scenario& s) { s.events[1].character = "human"; }},
      {"scenario/events/1/velocity", [](Scenario& s) { s.events[1].velocity.x = 1e6; }},
  };
  for (const Case& c : cases) {
    Scenario s = make_scenario();
    c.spoil(s);
    const Error error = check_scenario(s, &catalogue);
    EXPECT_TRUE(has_location(error, c.location)) << c.location << " not in\n" << error.text();
    for (const Problem& p : error.problems) EXPECT_FALSE(p.remedy.empty()) << p.text();
  }
}

TEST(Scenario, RefusesHostileText) {
  const std::string deep = std::string(100'000, '[') + std::string(100'000, ']');
  const std::string half = write_scenario(make_scenario());
  std::vector<std::string> texts = {"",
                                    " ",
                                    "\xff\xfe",
                                    "[]",
                                    "null",
                                    "true",
                                    "1e999",
                                    R"({"version": 1e999})",
                                    R"({"version": 1, "name": "\ud800"})",
                                    deep,
                                    R"({"version": 1, "circuit": )" + deep + "}",
                                    R"({"version": -1})",
                                    R"({"version": 1.5})",
                                    R"({"version": 1, "circuit": 3})",
                                    R"({"version": 1, "step": 1e308})",
                                    std::string("{\"version\": 1, \"name\": \"a\0b\"}", 29)};
  for (std::size_t i = 0; i < half.size(); i += 7) texts.push_back(half.substr(0, i));
  for (const std::string& text : texts) {
    const auto s = read_scenario(text, "hostile");
    ASSERT_FALSE(s) << text.substr(0, 100);
    EXPECT_FALSE(s.error().problems.empty());
    EXPECT_TRUE(s.error().problems.front().location.starts_with("hostile")) << s.error().text();
  }
}

TEST(Scenario, NegativeZeroIsReadAsZero) {
  const auto a = read_scenario(R"({"version": 1, "gravity": [-0.0, 0, -9.81], "ground": {"height": -0.0}})", "a");
  const auto b = read_scenario(R"({"version": 1, "gravity": [0, 0, -9.81], "ground": {"height": 0}})", "b");
  ASSERT_TRUE(a && b);
  EXPECT_EQ(write_scenario(*a), write_scenario(*b));
}

}  // namespace
}  // namespace ugoki::content
