// Tests of the commands on nested scenarios: nesting and unnesting change neither the flattened document nor the bits of a run.

#include <set>

#include "command_fixture.h"
#include "random_commands.h"
#include "ugoki/content/flatten.h"

namespace ugoki::content {
namespace {

Rule make_rule(const std::string& id, const std::string& character) {
  Rule rule;
  rule.id = id;
  rule.conditions.emplace_back();
  rule.conditions[0].type = ConditionType::time;
  rule.conditions[0].time = 0.05;
  rule.action.type = ActionType::push;
  rule.action.character = character;
  rule.action.force = {40, 0, 0};
  return rule;
}

/// Three characters with events, rules and variables of one and of two of them.
Scenario make_three() {
  Scenario s = testing::make_scenario();
  ScenarioCharacter other = s.characters[0];
  other.id = "other";
  other.name = "Other";
  other.place = {1.3, 2, 0, 60};
  for (ScenarioClip& clip : other.track) clip.id += "o";
  s.characters.push_back(other);
  for (const char* id : {"e9", "e3", "e5"}) {  // several pushes at one time: their order is part of the result
    ScenarioEvent push = s.events[0];
    push.id = id;
    push.time = 0.02;
    push.duration = 0.1;
    push.force = {std::string(id) == "e3" ? 0.1 : 30, 0.3, 0};
    if (std::string(id) == "e5") push.character = "other";
    s.events.push_back(push);
  }
  ScenarioEvent grab;
  grab.id = "g1";
  grab.type = EventType::grab;
  grab.time = 0.06;
  grab.character = "human";
  grab.link = "leg";
  grab.grip.other = "other";
  grab.grip.other_link = "leg";
  grab.grip.reach = 5;
  s.events.push_back(grab);
  s.rules = {make_rule("r1", "human"), make_rule("r2", "other"), make_rule("r3", "human"), make_rule("r4", "ball")};
  RuleCondition near;
  near.type = ConditionType::near;
  near.character = "human";
  near.other = "ball";
  near.distance = 10;
  s.rules[2].conditions.push_back(near);
  for (const char* id : {"x1", "x2"}) {
    ScenarioVariable v;
    v.id = id;
    v.name = std::string("Variable ") + id;
    s.variables.push_back(v);
  }
  RuleCondition compare;
  compare.type = ConditionType::variable;
  compare.variable = "x1";
  compare.compare = Comparison::below;
  s.rules[1].conditions.push_back(compare);  // of "other" only
  compare.variable = "x2";
  s.rules[0].conditions.push_back(compare);  // of "human" and "ball"
  s.rules[3].conditions.push_back(compare);
  put_in_order(s);
  return s;
}

class NestTest : public testing::CommandFixture {
 protected:
  NestTest() { document = make_three(); }

  std::uint64_t run(int steps) {
    Player player = open();
    for (int i = 0; i < steps; ++i) EXPECT_TRUE(player.step());
    return player.state_hash();
  }
  void nest(const std::vector<std::string>& characters, const std::string& name = "Duet") {
    std::string list;
    for (const std::string& id : characters) list += (list.empty() ? "\"" : ", \"") + id + "\"";
    apply(R"({"type": "scenario.nest", "name": ")" + name + R"(", "characters": [)" + list + "]}");
  }
  static std::set<std::string> ids(const auto& list) {
    std::set<std::string> out;
    for (const auto& item : list) out.insert(item.id);
    return out;
  }
  using Set = std::set<std::string>;
};

TEST_F(NestTest, WhatConcernsOnlyTheNestedCharactersMovesWithThem) {
  nest({"other", "human"});
  EXPECT_EQ(label, "Nest in a scenario");
  ASSERT_EQ(document.scenarios.size(), 1u);
  const Scenario& inner = document.scenarios[0];
  EXPECT_EQ(inner.id, "duet");
  EXPECT_EQ(inner.duration, 6) << "its last clip ends at 6 s";
  EXPECT_EQ(ids(inner.characters), (Set{"human", "other"}));
  EXPECT_EQ(ids(inner.events), (Set{"e1", "e3", "e5", "e9", "g1"}));
  EXPECT_EQ(ids(inner.rules), (Set{"r2"})) << "r3 names the ball; r1 shares a variable with a rule of the ball";
  EXPECT_EQ(ids(inner.variables), (Set{"x1"}));
  ASSERT_EQ(document.instances.size(), 1u);
  EXPECT_EQ(document.instances[0].id, "duet.1");
  EXPECT_EQ(document.instances[0].name, "Duet 1");
  EXPECT_EQ(document.rules[0].action.character, "duet.1/human");
  EXPECT_EQ(document.camera.follow, "duet.1/human");
}

TEST_F(NestTest, NestingChangesNoBitAndUnnestingRestoresTheDocument) {
  const Scenario before = document;
  const std::uint64_t expected = run(120);
  const std::vector<std::string> all = {"human", "ball", "other"};
  for (unsigned subset = 1; subset < 8; ++subset) {
    SCOPED_TRACE(subset);
    document = before;
    std::vector<std::string> chosen;
    for (unsigned i = 0; i < 3; ++i)
      if (subset >> i & 1u) chosen.push_back(all[i]);
    nest(chosen);
    EXPECT_EQ(run(120), expected);
    apply(R"({"type": "instance.unnest", "id": "duet.1"})");
    EXPECT_EQ(label, "Unnest");
    EXPECT_EQ(document, before);
  }
}

TEST_F(NestTest, NestsInstancesTogetherWithCharacters) {
  const std::uint64_t expected = run(120);
  nest({"other"}, "Solo");
  apply(R"({"type": "scenario.nest", "name": "Pair", "characters": ["human"], "instances": ["solo.1"]})");
  ASSERT_EQ(document.instances.size(), 1u);
  EXPECT_EQ(document.instances[0].id, "pair.1");
  EXPECT_EQ(ids(document.find_scenario("pair")->instances), (Set{"solo.1"}));
  EXPECT_EQ(run(120), expected);
  // Nesting inside an inner scenario renames the references of the scenarios that place it.
  apply(R"({"type": "in", "scenario": "pair", "command": {"type": "scenario.nest", "name": "Deep", "characters": ["human"]}})");
  EXPECT_EQ(document.camera.follow, "pair.1/deep.1/human");
  EXPECT_EQ(run(120), expected);
  apply(R"({"type": "in", "scenario": "pair", "command": {"type": "instance.unnest", "id": "deep.1"}})");
  apply(R"({"type": "instance.unnest", "id": "pair.1"})");
  apply(R"({"type": "instance.unnest", "id": "solo.1"})");
  EXPECT_EQ(document, make_three());
}

TEST_F(NestTest, UnnestingOneOfSeveralInstancesKeepsTheScenario) {
  nest({"human", "other"});
  apply(R"({"type": "instance.add", "scenario": "duet", "start": 2, "place": {"x": 4, "heading": 30}})");
  EXPECT_EQ(document.instances[1].name, "Duet 2");
  const Scenario flat = flatten(document);
  apply(R"({"type": "instance.unnest", "id": "duet.2"})");
  EXPECT_EQ(document.scenarios.size(), 1u);
  EXPECT_EQ(ids(document.characters), (Set{"ball", "human", "other"})) << "the ids are free here";
  const Scenario after = flatten(document);
  ASSERT_EQ(after.characters.size(), flat.characters.size());
  for (std::size_t i = 0; i < flat.characters.size(); ++i) EXPECT_EQ(after.characters[i].place, flat.characters[i].place) << i;
  apply(R"({"type": "instance.unnest", "id": "duet.1"})");
  EXPECT_EQ(document.characters.size(), 5u) << "with new ids";
  EXPECT_TRUE(document.scenarios.empty());
}

TEST_F(NestTest, EditsInsideChangeAllInstances) {
  nest({"human", "other"});
  apply(R"({"type": "instance.add", "scenario": "duet", "start": 2})");
  apply(R"({"type": "in", "scenario": "duet", "command": {"type": "clip.set", "character": "human", "id": "k1", "length": 1}})");
  EXPECT_EQ(label, "Trim clip");
  const Scenario flat = flatten(document);
  EXPECT_EQ(flat.find_character("duet.1/human")->track[0].length, 1);
  EXPECT_EQ(flat.find_character("duet.2/human")->track[0].length, 1);
  apply(R"({"type": "in", "scenario": "duet", "command": {"type": "scenario.set", "name": "Pair", "duration": 9, "step": 0.001}})");
  EXPECT_EQ(document.scenarios[0].name, "Pair");
  EXPECT_EQ(document.scenarios[0].duration, 9);
  EXPECT_EQ(document.name, "park");
  EXPECT_EQ(document.step, 0.001) << "all scenarios have one step";
  apply(R"({"type": "in", "scenario": "duet", "command": {"type": "character.remove", "id": "human"}})");
  EXPECT_TRUE(document.camera.follow.empty());
  for (const Rule& rule : document.rules) EXPECT_EQ(rule.id, "r4") << "rules that name it are removed";
  refuses(R"({"type": "in", "scenario": "duet", "command": {"type": "circuit.set", "circuit": null}})", ErrorCode::unsupported,
          "command/command/type");
}

TEST_F(NestTest, RemovingTheLastInstanceKeepsTheScenario) {
  nest({"human", "other"});
  refuses(R"({"type": "scenario.remove", "id": "duet"})", ErrorCode::conflict, "command/id");
  apply(R"({"type": "instance.remove", "id": "duet.1"})");
  EXPECT_TRUE(document.instances.empty());
  ASSERT_EQ(document.scenarios.size(), 1u);
  EXPECT_EQ(ids(document.rules), (Set{"r4"}));
  apply(R"({"type": "instance.add", "scenario": "duet", "name": "Again"})");
  EXPECT_EQ(document.instances[0].name, "Again");
  apply(R"({"type": "instance.set", "id": "duet.1", "name": "Other", "start": 3})");
  EXPECT_EQ(label, "Move scenario in time");
  apply(R"({"type": "instance.set", "id": "duet.1", "place": {"y": 2}})");
  EXPECT_EQ(label, "Place scenario");
  apply(R"({"type": "instance.remove", "id": "duet.1"})");
  apply(R"({"type": "scenario.remove", "id": "duet"})");
  EXPECT_TRUE(document.scenarios.empty());
}

TEST_F(NestTest, RefusesWhatItCannotDo) {
  refuses(R"({"type": "scenario.nest", "name": "X", "characters": []})", ErrorCode::structure, "command/characters");
  refuses(R"({"type": "scenario.nest", "name": "X", "characters": ["none"]})", ErrorCode::unknown, "command/characters/0");
  refuses(R"({"type": "instance.add", "scenario": "none"})", ErrorCode::unknown, "command/scenario");
  refuses(R"({"type": "instance.set", "id": "none"})", ErrorCode::unknown, "command/id");
  refuses(R"({"type": "in", "scenario": "none", "command": {}})", ErrorCode::unknown, "command/scenario");
  nest({"human"});
  refuses(R"({"type": "in", "scenario": "duet", "command": {"type": "instance.add", "scenario": "duet"}})", ErrorCode::structure,
          "scenario/scenarios/0/instances/0/scenario");
  apply(R"({"type": "character.set", "id": "ball", "locked": true})");
  refuses(R"({"type": "scenario.nest", "name": "X", "characters": ["ball"]})", ErrorCode::conflict, "command/characters");
  apply(R"({"type": "character.set", "id": "ball", "locked": false})");
  apply(R"({"type": "circuit.edit", "changes": []})");
  refuses(R"({"type": "scenario.nest", "name": "X", "characters": ["ball"]})", ErrorCode::conflict, "command/type", "nesting would change");
  refuses(R"({"type": "instance.remove", "id": "duet.1"})", ErrorCode::conflict, "command/type", "removing a scenario would change");
}

/// The flattened document with the items of one instance under their own ids and names.
Scenario without_prefix(Scenario s, const std::string& id, const std::string& name) {
  const auto cut = [](std::string& text, const std::string& prefix) {
    if (text.starts_with(prefix)) text.erase(0, prefix.size());
  };
  const auto cut_ids = [&](auto& list) {
    for (auto& item : list) cut(item.id, id + "/");
  };
  for_each_reference(s, [&](std::string& reference) { cut(reference, id + "/"); });
  for (ScenarioCharacter& c : s.characters) {
    cut(c.name, name + " / ");
    cut_ids(c.track);
  }
  for (ScenarioVariable& v : s.variables) cut(v.name, name + " / ");
  for (FilmCamera& c : s.cameras) cut(c.name, name + " / ");
  for (FilmShot& shot : s.shots) cut(shot.camera, id + "/");
  cut_ids(s.characters), cut_ids(s.events), cut_ids(s.rules), cut_ids(s.variables), cut_ids(s.cameras), cut_ids(s.shots);
  s.track_order.clear();
  std::ranges::sort(s.cameras, {}, &FilmCamera::id);  // their order has no effect
  return s;
}

// Nesting any tracks of any document changes only names, and so does unnesting.
TEST_F(NestTest, NestingRandomDocumentsChangesOnlyNames) {
  constexpr unsigned seed = 81;
  SCOPED_TRACE(seed);
  testing::RandomCommands random(seed);
  document = testing::make_scenario();
  int nested = 0;
  for (int i = 0; i < 2500; ++i) {
    if (auto effect = apply_command(document, random.next(document), catalogue, next_id)) document = std::move(effect->scenario);
    if (i % 5 != 0 || document.characters.empty()) continue;
    std::string list;
    for (const ScenarioCharacter& c : document.characters)
      if (random.pick(2)) list += (list.empty() ? "\"" : ", \"") + c.id + "\"";
    const auto made =
        apply_command(document, R"({"type": "scenario.nest", "name": "Part", "characters": [)" + list + "]}", catalogue, next_id);
    if (!made) continue;
    ++nested;
    const Scenario before = played_part(document);
    const ScenarioInstance instance = made->scenario.instances.back();
    ASSERT_EQ(write_scenario(without_prefix(played_part(made->scenario), instance.id, instance.name)),
              write_scenario(without_prefix(before, "", "?")));
    const auto back = apply_command(made->scenario, R"({"type": "instance.unnest", "id": ")" + instance.id + "\"}", catalogue, next_id);
    ASSERT_TRUE(back) << back.error().text();
    ASSERT_EQ(write_scenario(without_prefix(played_part(back->scenario), "", "?")), write_scenario(without_prefix(before, "", "?")));
    ASSERT_EQ(back->scenario.scenarios, document.scenarios);
  }
  EXPECT_GT(nested, 60);
}

}  // namespace
}  // namespace ugoki::content
