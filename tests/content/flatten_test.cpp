// Tests of nested scenarios: their JSON form, the documents that are refused, and that runs of a flattened document and of the same
// document written by hand have equal bits.

#include "ugoki/content/flatten.h"
#include "command_fixture.h"

namespace ugoki::content {
namespace {

/// The state hash after `steps` steps.
std::uint64_t run(const Scenario& document, const Resources& resources, int steps) {
  const auto bytes = generate(document, resources);
  EXPECT_TRUE(bytes) << (bytes ? "" : bytes.error().text());
  if (!bytes) return 0;
  auto player = Player::open(*bytes, "test");
  EXPECT_TRUE(player) << (player ? "" : player.error().text());
  for (int i = 0; i < steps; ++i) EXPECT_TRUE(player->step());
  return player->state_hash();
}

/// A document with an inner scenario "Pair" (the characters and events of make_scenario()), without a placed instance.
Scenario with_pair() {
  const Scenario flat = testing::make_scenario();
  Scenario out;
  out.name = "outer";
  out.duration = 12;
  Scenario pair;
  pair.id = "pair";
  pair.name = "Pair";
  pair.duration = flat.duration;
  pair.characters = flat.characters;
  pair.events = flat.events;
  out.scenarios = {pair};
  return out;
}

ScenarioInstance place(std::string id, std::string scenario, double start, ScenarioPlace at) {
  ScenarioInstance out;
  out.id = std::move(id);
  out.name = "The " + out.id;
  out.scenario = std::move(scenario);
  out.start = start;
  out.place = at;
  return out;
}

class FlattenTest : public testing::CommandFixture {
 protected:
  /// The document is refused with a first problem that contains these words.
  void invalid(const Scenario& s, const std::string& location, const std::string& words) {
    const Error problems = check_scenario(s, &catalogue);
    ASSERT_FALSE(problems.empty());
    EXPECT_EQ(problems.problems.front().location, location) << problems.text();
    EXPECT_NE(problems.text().find(words), std::string::npos) << problems.text();
  }
};

TEST_F(FlattenTest, DocumentsWithoutNestingAreUnchanged) {
  const Scenario plain = testing::make_scenario();
  EXPECT_EQ(flatten(plain), plain);
  EXPECT_NE(write_scenario(plain).find("\"version\": 1,"), std::string::npos);
  EXPECT_EQ(write_scenario(plain).find("scenarios"), std::string::npos);
}

TEST_F(FlattenTest, TheTextFormRestoresTheDocument) {
  Scenario s = with_pair();
  s.instances = {place("pair.1", "pair", 0, {}), place("pair.2", "pair", 1.5, {1, 2, 0, 90})};
  s.instances[1].muted = true;
  s.order = {"pair.2/ball", "pair.1/ball"};
  s.scenarios[0].camera.distance = 3;
  s.scenarios[0].range = {1, 2};
  const std::string text = write_scenario(s);
  EXPECT_NE(text.find("\"version\": 2,"), std::string::npos);
  const auto back = read_scenario(text, "nested.json");
  ASSERT_TRUE(back) << back.error().text();
  EXPECT_EQ(*back, s);
  EXPECT_EQ(write_scenario(*back), text);
}

TEST_F(FlattenTest, InstancesHaveTheirOwnItems) {
  Scenario s = with_pair();
  s.instances = {place("pair.1", "pair", 0, {}), place("pair.2", "pair", 2, {10, 0, 1, 90})};
  const Scenario flat = flatten(s);
  ASSERT_EQ(flat.characters.size(), 4u);
  EXPECT_EQ(flat.characters[0].id, "pair.1/human");
  EXPECT_EQ(flat.characters[2].id, "pair.2/human");
  EXPECT_EQ(flat.characters[2].name, "The pair.2 / Human");
  EXPECT_EQ(flat.characters[0].place, (ScenarioPlace{1, 2, 0, 90}));
  const ScenarioPlace turned = flat.characters[2].place;  // (1, 2) turned by 90 degrees is (-2, 1)
  EXPECT_NEAR(turned.x, 8, 1e-12);
  EXPECT_NEAR(turned.y, 1, 1e-12);
  EXPECT_EQ(turned.z, 1);
  EXPECT_EQ(turned.heading, 180);
  EXPECT_EQ(flat.characters[2].track[0].start, 2);
  ASSERT_EQ(flat.events.size(), 4u);
  EXPECT_EQ(flat.events[3].id, "pair.2/e2");
  EXPECT_EQ(flat.events[3].time, 7);
  EXPECT_EQ(flat.events[3].character, "pair.2/ball");
  EXPECT_NEAR(flat.events[3].velocity.y, -6, 1e-12) << "directions turn with the instance";
  EXPECT_NEAR(flat.events[3].from.y, 3, 1e-12);
  EXPECT_TRUE(flat.instances.empty() && flat.scenarios.empty());
  EXPECT_TRUE(check_scenario(s, &catalogue).empty()) << check_scenario(s, &catalogue).text();
}

// The flattened document as a user would write it, with values computed here.
TEST_F(FlattenTest, ARunHasTheBitsOfTheDocumentThatIsFlattenedByHand) {
  Scenario nested = with_pair();
  nested.instances = {place("a", "pair", 0, {}), place("b", "pair", 0.1, {3, -1, 0, 0})};
  Scenario hand = nested;
  hand.instances.clear();
  hand.scenarios.clear();
  for (const auto& [id, start, x, y] : {std::tuple{"a", 0.0, 0.0, 0.0}, std::tuple{"b", 0.1, 3.0, -1.0}}) {
    Scenario part = testing::make_scenario();
    for (ScenarioCharacter& c : part.characters) {
      c.id = std::string(id) + "-" + c.id;
      c.place.x += x;
      c.place.y += y;
      for (ScenarioClip& clip : c.track) {
        clip.id = std::string(id) + "-" + clip.id;
        clip.start += start;
      }
      hand.characters.push_back(c);
    }
    for (ScenarioEvent& e : part.events) {
      e.id = std::string(id) + "-" + e.id;
      e.character = std::string(id) + "-" + e.character;
      e.time += start;
      e.from = e.from + Vec3{x, y, 0};
      hand.events.push_back(e);
    }
  }
  const std::uint64_t expected = run(hand, resources, 3000);
  EXPECT_EQ(run(nested, resources, 3000), expected);
  nested.instances[1].place.y = -1.001;
  EXPECT_NE(run(nested, resources, 3000), expected) << "the hash sees a place";
}

TEST_F(FlattenTest, LevelsCompose) {
  Scenario s = with_pair();
  Scenario group;
  group.id = "group";
  group.name = "Group";
  group.instances = {place("left", "pair", 1, {1, 0, 0, 90})};
  s.scenarios.push_back(group);
  s.instances = {place("g", "group", 2, {0, 5, 0, 90})};
  const Scenario flat = flatten(s);
  ASSERT_EQ(flat.characters.size(), 2u);
  EXPECT_EQ(flat.characters[0].id, "g/left/human");
  EXPECT_EQ(flat.characters[0].track[0].start, 3);
  EXPECT_NEAR(flat.characters[0].place.x, -1, 1e-12);  // (1, 2) -> (1 - 2, 1) = (-1, 1) -> (-1, 5 - 1)
  EXPECT_NEAR(flat.characters[0].place.y, 4, 1e-12);
  EXPECT_EQ(flat.characters[0].place.heading, 270);
  EXPECT_NE(run(s, resources, 5), 0u);
}

TEST_F(FlattenTest, SoloAndMuteActInsideAnInstance) {
  Scenario s = with_pair();
  s.instances = {place("a", "pair", 0, {}), place("b", "pair", 0, {3, 0, 0, 0})};
  s.scenarios[0].characters[1].solo = true;
  EXPECT_EQ(played_part(s).characters.size(), 2u) << "the balls";
  s.instances[0].muted = true;
  ASSERT_EQ(played_part(s).characters.size(), 1u);
  EXPECT_EQ(played_part(s).characters[0].id, "b/ball");
  s.instances[0] = place("a", "pair", 0, {});
  s.instances[0].solo = true;
  ASSERT_EQ(played_part(s).characters.size(), 1u);
  EXPECT_EQ(played_part(s).characters[0].id, "a/ball");
}

TEST_F(FlattenTest, RefersToItemsOfInstances) {
  Scenario s = with_pair();
  s.instances = {place("a", "pair", 0, {})};
  ScenarioEvent push = testing::make_scenario().events[0];
  push.character = "a/human";
  s.events = {push};
  s.camera.follow = "a/ball";
  EXPECT_TRUE(check_scenario(s, &catalogue).empty()) << check_scenario(s, &catalogue).text();
  s.events[0].character = "a/nobody";
  invalid(s, "scenario/events/0/character", "no character 'a/nobody'");
}

TEST_F(FlattenTest, RefusesScenariosThatContainThemselves) {
  Scenario s = with_pair();
  Scenario group;
  group.id = "group";
  group.name = "Group";
  group.instances = {place("p", "pair", 0, {})};
  s.scenarios.push_back(group);
  s.scenarios[0].instances = {place("g", "group", 0, {})};
  s.instances = {place("a", "pair", 0, {})};
  invalid(s, "scenario/scenarios/1/instances/0/scenario", "The scenario 'Pair' would contain itself: Pair > Group > Pair.");
  EXPECT_FALSE(flatten(s).characters.empty()) << "ends";
  EXPECT_FALSE(read_scenario(write_scenario(s), "cycle"));
  s.scenarios[0].instances[0].scenario = "pair";
  invalid(s, "scenario/scenarios/0/instances/0/scenario", "Pair > Pair.");
}

TEST_F(FlattenTest, RefusesInvalidInstances) {
  Scenario s = with_pair();
  s.instances = {place("a", "none", 0, {})};
  invalid(s, "scenario/instances/0/scenario", "no scenario 'none'");
  s.instances = {place("a", "pair", -1, {})};
  invalid(s, "scenario/instances/0/start", "out of range");
  s.instances = {place("a", "pair", 0, {}), place("a", "pair", 0, {})};
  invalid(s, "scenario/instances/1/id", "Two items");
  s.instances = {place("a/b", "pair", 0, {})};
  invalid(s, "scenario/instances/0/id", "cannot be an id");
  s.instances = {place("a", "pair", 0, {9000, 0, 0, 0})};
  s.scenarios[0].characters[0].place.x = 9000;
  invalid(s, "scenario, flattened/characters/0/place", "out of range");
  s = with_pair();
  s.scenarios[0].characters[0].track[0].motion = "n-none";
  invalid(s, "scenario/scenarios/0/characters/0/track/0/motion", "no motion 'n-none'");
  s = with_pair();
  s.scenarios.push_back(s.scenarios[0]);
  invalid(s, "scenario/scenarios/1/id", "Two scenarios");
  s = with_pair();
  s.scenarios[0].events[0].id = "x/y";
  invalid(s, "scenario/scenarios/0/events/0/id", "cannot be an id");
}

TEST_F(FlattenTest, RefusesTooManyItems) {
  Scenario s = with_pair();
  std::string inner = "pair";
  for (int level = 0; level < 8; ++level) {  // 7 items, 10 times at each level
    Scenario group;
    group.id = group.name = "level" + std::to_string(level);
    for (int i = 0; i < 10; ++i) group.instances.push_back(place("i" + std::to_string(i), inner, 0, {}));
    inner = group.id;
    s.scenarios.push_back(group);
  }
  s.instances = {place("all", inner, 0, {})};
  const Error problems = check_scenario(s);
  EXPECT_NE(problems.text().find("more than 20000 items"), std::string::npos) << problems.text();
}

TEST_F(FlattenTest, ShotsThatStartTogetherAreShownOnce) {
  Scenario s = with_pair();
  FilmCamera camera;
  camera.id = "v1";
  camera.name = "Near";
  camera.follow = "human";
  camera.view.target = {1, 0, 0.9};
  s.scenarios[0].cameras = {camera};
  FilmShot shot;
  shot.id = "h1";
  shot.camera = "v1";
  s.scenarios[0].shots = {shot};
  s.instances = {place("a", "pair", 0, {}), place("b", "pair", 0, {0, 0, 1, 90}), place("c", "pair", 3, {})};
  EXPECT_TRUE(check_scenario(s, &catalogue).empty()) << check_scenario(s, &catalogue).text();
  const Scenario flat = flatten(s);
  ASSERT_EQ(flat.shots.size(), 2u);
  EXPECT_EQ(flat.shots[1].camera, "c/v1");
  EXPECT_EQ(flat.shots[1].start, 3);
  EXPECT_EQ(flat.cameras[1].follow, "b/human");
  EXPECT_NEAR(flat.cameras[1].view.target.y, 1, 1e-12) << "relative to the character, turned";
  EXPECT_NEAR(flat.cameras[1].view.target.z, 1.9, 1e-12) << "a height in the world";
}

TEST_F(FlattenTest, LongIdsOfRulesGiveValidCircuits) {
  Scenario s = with_pair();
  Rule rule;
  rule.id = std::string(38, 'r') + ".1";
  rule.conditions.emplace_back();
  rule.action.type = ActionType::push;
  rule.action.character = "human";
  rule.action.link = "leg";
  s.scenarios[0].rules = {rule};
  s.instances = {place(std::string(40, 'a'), "pair", 0, {}), place(std::string(39, 'a') + "b", "pair", 0, {3, 0, 0, 0})};
  EXPECT_NE(run(s, resources, 2), 0u);
}

}  // namespace
}  // namespace ugoki::content
