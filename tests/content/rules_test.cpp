// Rules of the scenario document: JSON form, checks, commands, the generated circuit, and the run of a content with rules.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <nlohmann/json.hpp>

#include "fixture.h"
#include "ugoki/circuit/interpreter.h"
#include "ugoki/content/commands.h"
#include "ugoki/content/default_circuit.h"
#include "ugoki/content/mechanism_display.h"
#include "ugoki/content/player.h"
#include "ugoki/lsi/standard_library.h"

namespace ugoki::content {
namespace {

using testing::make_resources;
using testing::make_scenario;

/// One rule of each kind of condition and action, for the scenario of fixture.h.
constexpr const char* all_rules[] = {
    R"({"id": "r1", "mode": "while", "if": [{"type": "key", "key": "KeyW"}], "do": {"type": "play", "character": "human", "motion": "n-step", "loop": true}})",
    R"({"id": "r2", "if": [{"type": "touch", "character": "ball", "other": "human", "other_link": "leg"}],
        "do": {"type": "play", "character": "human", "motion": "n-walk", "speed": 1.5, "blend": 0.1}})",
    R"({"id": "r3", "if": [{"type": "near", "character": "human", "other": "ball", "distance": 0.4}, {"type": "key", "key": "Space", "not": true}],
        "do": {"type": "push", "character": "ball", "link": "ball", "force": [1, 2, 3], "duration": 0.1}})",
    R"({"id": "r4", "mode": "while", "if": [{"type": "time", "time": 2}, {"type": "playing", "character": "human", "rule": "r1"}],
        "do": {"type": "push", "character": "human", "force": [5, 0, 0]}})",
    R"({"id": "r5", "on": false, "if": [{"type": "released", "character": "human"}], "do": {"type": "push", "character": "human", "force": [0, 0, 1]}})",
};

class RulesTest : public ::testing::Test {
 protected:
  void good(const std::string& command) {
    auto effect = apply_command(document, command, catalogue, next_id);
    ASSERT_TRUE(effect) << command << "\n" << effect.error().text();
    document = std::move(effect->scenario);
    label = effect->label;
  }
  void bad(const std::string& rule, ErrorCode code, const std::string& location) {
    const auto effect = apply_command(document, R"({"type": "rule.add", "rule": )" + rule + "}", catalogue, next_id);
    ASSERT_FALSE(effect) << rule;
    EXPECT_EQ(effect.error().problems.front().code, code) << effect.error().text();
    EXPECT_EQ(effect.error().problems.front().location, location) << effect.error().text();
    EXPECT_FALSE(effect.error().problems.front().remedy.empty());
  }
  void add_all() {
    for (const char* rule : all_rules) good(R"({"type": "rule.add", "rule": )" + std::string(rule) + "}");
  }
  [[nodiscard]] std::vector<std::string> ids() const {
    std::vector<std::string> out;
    for (const Rule& r : document.rules) out.push_back(r.id);
    return out;
  }

  Resources resources = make_resources();
  Catalogue catalogue = catalogue_of(resources);
  Scenario document = make_scenario();
  std::uint64_t next_id = 1;
  std::string label;
};

using Ids = std::vector<std::string>;

TEST_F(RulesTest, DocumentKeepsRulesInTheirOrder) {
  add_all();
  const std::string text = write_scenario(document);
  const Result<Scenario> read = read_scenario(text, "scenario");
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(*read, document);
  EXPECT_EQ(write_scenario(*read), text);
  EXPECT_EQ(ids(), (Ids{"r1", "r2", "r3", "r4", "r5"}));
}

TEST_F(RulesTest, DocumentWithoutRulesDoesNotNameThem) { EXPECT_EQ(write_scenario(document).find("rules"), std::string::npos); }

TEST_F(RulesTest, CommandsChangeMoveAndRemoveRules) {
  add_all();
  EXPECT_EQ(label, "Add rule");
  good(R"({"type": "rule.set", "id": "r1", "rule": {"on": false}})");
  EXPECT_EQ(label, "Switch off rule");
  EXPECT_FALSE(document.rules[0].on);
  EXPECT_EQ(document.rules[0].conditions.size(), 1u) << "fields that are not given keep their value";
  good(R"({"type": "rule.move", "id": "r1", "at": 2})");
  EXPECT_EQ(ids(), (Ids{"r2", "r3", "r1", "r4", "r5"}));
  good(
      R"({"type": "rule.add", "at": 0, "rule": {"if": [{"type": "key"}], "do": {"type": "push", "character": "ball", "force": [0, 0, 1]}}})");
  EXPECT_EQ(document.rules[0].id, "r6") << "a new id";
  good(R"({"type": "rule.remove", "id": "r1"})");
  EXPECT_EQ(ids(), (Ids{"r6", "r2", "r3", "r5"})) << "r4 depends on r1";
  good(R"({"type": "character.remove", "id": "ball"})");
  EXPECT_EQ(ids(), (Ids{"r5"}));
}

TEST_F(RulesTest, NamesTheMotionsOfCommands) {
  EXPECT_EQ(resources_named(R"({"type": "rule.add", "rule": {"do": {"type": "play", "motion": "n-walk"}}})"), (Ids{"n-walk"}));
}

TEST_F(RulesTest, RefusesFaultyRules) {
  add_all();
  const std::string at = "scenario/rules/5";
  const std::string key = R"("if": [{"type": "key"}])", push = R"("do": {"type": "push", "character": "ball", "force": [1, 0, 0]})";
  bad("{" + push + "}", ErrorCode::structure, at + "/if");
  bad(R"({"if": [{"type": "key", "key": "W!"}], )" + push + "}", ErrorCode::syntax, at + "/if/0/key");
  bad(R"({"if": [{"type": "wish"}], )" + push + "}", ErrorCode::unknown, "command/rule/if/0/type");
  bad(R"({"if": [{"type": "touch", "character": "cat"}], )" + push + "}", ErrorCode::unknown, at + "/if/0/character");
  bad(R"({"if": [{"type": "touch", "character": "human", "link": "nose"}], )" + push + "}", ErrorCode::unknown, at + "/if/0/link");
  bad(R"({"if": [{"type": "near", "character": "ball", "other": "ball"}], )" + push + "}", ErrorCode::structure, at + "/if/0/other");
  bad(R"({"if": [{"type": "near", "character": "ball", "other": "human", "distance": -1}], )" + push + "}", ErrorCode::range,
      at + "/if/0/distance");
  bad(R"({"if": [{"type": "playing", "character": "human", "rule": "r3"}], )" + push + "}", ErrorCode::unknown, at + "/if/0/rule");
  bad(R"({"if": [{"type": "key", "distance": 2}], )" + push + "}", ErrorCode::unknown, "command/rule/if/0/distance");
  bad("{" + key + R"(, "do": {"type": "play", "character": "human", "motion": "n-none"}})", ErrorCode::unknown, at + "/do/motion");
  bad("{" + key + R"(, "do": {"type": "play", "character": "ball", "motion": "n-walk"}})", ErrorCode::structure, at + "/do/motion");
  bad("{" + key + R"(, "do": {"type": "play", "character": "human", "motion": "n-walk", "speed": 0}})", ErrorCode::range, at + "/do/speed");
  bad("{" + key + R"(, "do": {"type": "push", "character": "human", "link": "nose"}})", ErrorCode::unknown, at + "/do/link");
}

TEST_F(RulesTest, PlayedPartHasNoRulesOfMutedCharacters) {
  add_all();
  good(R"({"type": "character.set", "id": "ball", "muted": true})");
  const Scenario played = played_part(document);
  Ids left;
  for (const Rule& r : played.rules) left.push_back(r.id);
  EXPECT_EQ(left, (Ids{"r1", "r4", "r5"}));
}

TEST_F(RulesTest, GeneratedCircuitHasOneActionForEachRule) {
  const std::string plain = default_circuit(document);
  add_all();
  const Result<circuit::Circuit> c = circuit::read_circuit(default_circuit(document));
  ASSERT_TRUE(c);
  const auto type_of = [&](const std::string& id) {
    const auto found = std::find_if(c->lsis.begin(), c->lsis.end(), [&](const circuit::Instance& l) { return l.id == id; });
    return found == c->lsis.end() ? std::string() : found->type;
  };
  EXPECT_EQ(type_of("rule-r1"), "play rule");
  EXPECT_EQ(type_of("rule-r2"), "play rule");
  EXPECT_EQ(type_of("rule-r3"), "push");
  EXPECT_EQ(type_of("rule-r4"), "push");
  EXPECT_EQ(type_of("rule-r5"), "") << "the rule is off";
  EXPECT_EQ(type_of("human"), "character human") << "one box for each character";
  EXPECT_TRUE(std::ranges::any_of(c->circuits.at(0).lsis, [](const circuit::Instance& l) { return l.type == "motion choice"; }));
  const auto wired = [&](const char* from, const char* to) {
    return std::any_of(c->wires.begin(), c->wires.end(), [&](const circuit::Wire& w) { return w.from == from && w.to == to; });
  };
  EXPECT_TRUE(wired("rule-r1.choice", "human.choice")) << "the first rule has priority";
  EXPECT_TRUE(wired("rule-r2.choice", "rule-r1.below"));
  EXPECT_TRUE(wired("rule-r3.events", "rule-r4.events"));
  EXPECT_TRUE(wired("rule-r4.events", "dynamics.events"));
  document.rules.clear();
  EXPECT_EQ(default_circuit(document), plain);
}

/// Runs the document for `seconds` while `keys` are held. @return the player
Player run(const Scenario& document, const Resources& resources, const std::vector<std::string>& keys, double seconds) {
  const auto bytes = generate(document, resources);
  EXPECT_TRUE(bytes) << (bytes ? "" : bytes.error().text());
  auto player = Player::open(*bytes, "test");
  EXPECT_TRUE(player) << (player ? "" : player.error().text());
  circuit::DeviceState held;
  held.keys = keys;
  player->hold(held);
  for (int i = 0; i < static_cast<int>(seconds / document.step); ++i) EXPECT_TRUE(player->step()) << i;
  return std::move(*player);
}
double value(Player& player, const char* pin) { return player.interpreter().find_output(pin)->numbers()[0]; }

/// Counts the touches of the ball on the ground; the third one switches `done` on, which pushes the ball.
constexpr const char* counting_rules[] = {
    R"({"type": "variable.add", "variable": {"id": "hits", "name": "Hits", "maximum": 3, "unit": "x"}})",
    R"({"type": "variable.add", "variable": {"id": "done", "name": "Done", "kind": "switch", "shown": false}})",
    R"({"type": "rule.add", "rule": {"id": "r6", "if": [{"type": "key", "key": "KeyH"}], "do": {"type": "set", "variable": "hits"}}})",
    R"({"type": "rule.add", "rule": {"id": "r7", "if": [{"type": "variable", "variable": "hits", "compare": "at_least", "value": 3}],
        "do": {"type": "set", "variable": "done", "change": "toggle"}}})",
    R"({"type": "rule.add", "rule": {"id": "r8", "if": [{"type": "variable", "variable": "done", "compare": "equal", "value": 1}],
        "do": {"type": "play", "character": "human", "motion": "n-step", "loop": true}}})",
    R"({"type": "rule.add", "rule": {"id": "r9", "if": [{"type": "near", "character": "human", "link": "leg", "other": "ball", "distance": 9}],
        "do": {"type": "grab", "character": "ball", "link": "ball", "other": "human", "other_link": "leg", "limit": 900}}})"};

TEST_F(RulesTest, VariablesAreKeptChangedAndRemovedWithTheirRules) {
  for (const char* command : counting_rules) good(command);
  const std::string text = write_scenario(document);
  const Result<Scenario> read = read_scenario(text, "scenario");
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(*read, document);
  EXPECT_EQ(write_scenario(*read), text);
  good(R"({"type": "variable.set", "id": "hits", "variable": {"name": "Points", "maximum": null}})");
  EXPECT_EQ(label, "Rename variable");
  EXPECT_EQ(document.variables[0].maximum, max_variable);
  EXPECT_EQ(document.variables[0].unit, "x") << "fields that are not given keep their value";
  good(R"({"type": "variable.add", "variable": {}})");
  EXPECT_EQ(document.variables[2].name, "Variable 3");
  good(R"({"type": "variable.remove", "id": "hits"})");
  EXPECT_EQ(ids(), (Ids{"r8", "r9"})) << "r6 changes it, r7 compares it";
  good(R"({"type": "character.remove", "id": "human"})");
  EXPECT_EQ(ids(), (Ids{}));
}

TEST_F(RulesTest, DocumentWithoutVariablesDoesNotNameThem) { EXPECT_EQ(write_scenario(document).find("variables"), std::string::npos); }

TEST_F(RulesTest, RefusesFaultyVariables) {
  for (const char* command : counting_rules) good(command);
  const auto faulty = [&](const std::string& command, ErrorCode code, const std::string& location) {
    const auto effect = apply_command(document, command, catalogue, next_id);
    ASSERT_FALSE(effect) << command;
    EXPECT_EQ(effect.error().problems.front().code, code) << effect.error().text();
    EXPECT_EQ(effect.error().problems.front().location, location) << effect.error().text();
    EXPECT_FALSE(effect.error().problems.front().remedy.empty());
  };
  const auto set = [](const char* fields) { return R"({"type": "variable.set", "id": "hits", "variable": )" + std::string(fields) + "}"; };
  faulty(set(R"({"initial": 4})"), ErrorCode::range, "scenario/variables/0/initial");
  faulty(set(R"({"minimum": 5})"), ErrorCode::range, "scenario/variables/0/minimum");
  faulty(set(R"({"maximum": 1e10})"), ErrorCode::range, "scenario/variables/0/maximum");
  faulty(set(R"({"kind": "text"})"), ErrorCode::unknown, "command/variable/kind");
  faulty(set(R"({"name": ""})"), ErrorCode::range, "scenario/variables/0/name");
  faulty(set(R"({"unit": "kilograms per second squared"})"), ErrorCode::range, "scenario/variables/0/unit");
  faulty(R"({"type": "variable.set", "id": "done", "variable": {"initial": 0.5}})", ErrorCode::range, "scenario/variables/1/initial");
  faulty(R"({"type": "variable.remove", "id": "none"})", ErrorCode::unknown, "command/id");
  faulty(R"({"type": "variable.add", "variable": {"id": "r6"}})", ErrorCode::duplicate, "scenario/variables/2/id");
  const std::string at = "scenario/rules/4", push = R"("do": {"type": "push", "character": "ball", "force": [1, 0, 0]}})",
                    key = R"({"if": [{"type": "key"}], )";
  bad(R"({"if": [{"type": "variable", "variable": "none"}], )" + push, ErrorCode::unknown, at + "/if/0/variable");
  bad(R"({"if": [{"type": "variable", "variable": "hits", "compare": "near"}], )" + push, ErrorCode::unknown, "command/rule/if/0/compare");
  bad(key + R"("do": {"type": "set", "variable": "none"}})", ErrorCode::unknown, at + "/do/variable");
  bad(key + R"("do": {"type": "set", "variable": "hits", "change": "toggle"}})", ErrorCode::structure, at + "/do/change");
  bad(key + R"("do": {"type": "set", "variable": "hits", "value": 1e12}})", ErrorCode::range, at + "/do/value");
  bad(key + R"("do": {"type": "grab", "character": "human"}})", ErrorCode::structure, at + "/do/link");
  bad(key + R"("do": {"type": "grab", "character": "human", "link": "leg", "other": "human", "other_link": "leg"}})", ErrorCode::structure,
      at + "/do/other_link");
  bad(key + R"("do": {"type": "release", "character": "ball", "link": "nose"}})", ErrorCode::unknown, at + "/do/link");
  bad(R"({"if": [{"type": "near", "character": "human", "link": "nose", "other": "ball"}], )" + push, ErrorCode::unknown,
      at + "/if/0/link");
}

TEST_F(RulesTest, AThirdTouchOfAKeyPlaysAMotion) {
  for (const char* command : counting_rules) good(command);
  const auto bytes = generate(document, resources);
  ASSERT_TRUE(bytes) << bytes.error().text();
  auto player = Player::open(*bytes, "test");
  ASSERT_TRUE(player) << player.error().text();
  const auto press = [&](bool down) {
    circuit::DeviceState held;
    if (down) held.keys = {"KeyH"};
    player->hold(held);
    for (int i = 0; i < 10; ++i) ASSERT_TRUE(player->step());
  };
  for (int round = 1; round <= 5; ++round) {
    press(true);
    press(false);
    EXPECT_EQ(value(*player, "variable-hits.value"), std::min(round, 3)) << "the maximum is 3";
    EXPECT_EQ(value(*player, "variable-done.value"), round < 3 ? 0 : 1) << round;
    EXPECT_EQ(value(*player, "human/choice.now"), round < 3 ? 0 : 1) << round;
  }
  EXPECT_EQ(value(*player, "rule-r9.count"), 1);
}

TEST_F(RulesTest, ViewersSeeTheValuesOfShownVariables) {
  for (const char* command : counting_rules) good(command);
  Player player = run(document, resources, {"KeyH"}, 0.02);
  ASSERT_EQ(player.content().variables, std::vector{document.variables[0]}) << "the variable that is not shown is left out";
  std::vector<double> values;
  player.variable_values(values);
  EXPECT_EQ(values, std::vector{1.0});
  EXPECT_NE(scene_json(player.content()).find(R"("variables":[{"id":"hits","name":"Hits","kind":"number")"), std::string::npos)
      << scene_json(player.content());
  player.reset();
  player.variable_values(values);
  EXPECT_EQ(values, std::vector{0.0});
  // Rules act in the generated circuit only. A circuit of its own that has no LSI for the variable has no value.
  Scenario wired = document;
  Scenario plain = document;
  plain.rules.clear();
  plain.variables.clear();
  wired.circuit = run(plain, resources, {}, 0.01).content().circuit;
  EXPECT_TRUE(run(wired, resources, {}, 0.01).content().variables.empty());
}

/// Each comparison of the variable with 2, for its values 1, 2 and 3.
TEST_F(RulesTest, ComparisonsOfVariables) {
  const std::pair<const char*, std::array<bool, 3>> cases[] = {{"at_least", {false, true, true}},
                                                               {"at_most", {true, true, false}},
                                                               {"above", {false, false, true}},
                                                               {"below", {true, false, false}},
                                                               {"equal", {false, true, false}}};
  for (const auto& [name, wanted] : cases)
    for (const bool negated : {false, true})
      for (int x = 1; x <= 3; ++x) {
        document = make_scenario();
        good(R"({"type": "variable.add", "variable": {"id": "x", "initial": )" + std::to_string(x) + "}}");
        good(R"({"type": "rule.add", "rule": {"id": "r1", "mode": "while", "if": [{"type": "variable", "variable": "x", "compare": ")" +
             std::string(name) + R"(", "value": 2, "not": )" + (negated ? "true" : "false") +
             R"(}], "do": {"type": "push", "character": "human", "force": [0, 0, 1]}}})");
        Player player = run(document, resources, {}, 0.01);
        EXPECT_EQ(value(player, "rule-r1.active") > 0, wanted[static_cast<std::size_t>(x - 1)] != negated) << name << " " << x << negated;
      }
}

TEST_F(RulesTest, AConditionOnAMotionAlsoHoldsForOtherRulesOfThisMotion) {
  const auto play = [](const char* id, const char* key) {
    return R"({"type": "rule.add", "rule": {"id": ")" + std::string(id) + R"(", "mode": "while", "if": [{"type": "key", "key": ")" + key +
           R"("}], "do": {"type": "play", "character": "human", "motion": "n-step", "loop": true}}})";
  };
  good(play("r1", "KeyA"));
  good(play("r2", "KeyB"));
  good(R"({"type": "rule.add", "rule": {"id": "r3", "mode": "while", "if": [{"type": "playing", "character": "human", "rule": "r1"}],
          "do": {"type": "push", "character": "ball", "force": [0, 0, 1]}}})");
  for (const auto& [key, wanted] : {std::pair{"KeyA", 1.0}, {"KeyB", 1.0}, {"KeyC", 0.0}}) {
    Player player = run(document, resources, {key}, 0.1);
    EXPECT_EQ(value(player, "rule-r3.active"), wanted) << key;
  }
}

TEST_F(RulesTest, TheFirstRuleChangesAVariableLast) {
  good(R"({"type": "variable.add", "variable": {"id": "x", "initial": 5}})");
  for (const char* value : {"1", "2"})
    good(R"({"type": "rule.add", "rule": {"mode": "while", "if": [{"type": "time", "time": 0}], "do": {"type": "set", "variable": "x", )"
         R"("change": "set", "value": )" +
         std::string(value) + "}}}");
  Player player = run(document, resources, {}, 0.1);
  EXPECT_EQ(value(player, "variable-x.value"), 1);
}

TEST_F(RulesTest, AllKindsOfRulesRun) {
  add_all();
  Player idle = run(document, resources, {}, 0.5), held = run(document, resources, {"KeyW"}, 0.5);
  EXPECT_EQ(value(idle, "human/choice.now"), 0);
  EXPECT_EQ(value(held, "human/choice.now"), 1);
  EXPECT_EQ(value(held, "rule-r1.count"), 1);
  EXPECT_EQ(value(idle, "rule-r4.active"), 0);
  Player later = run(document, resources, {"KeyW"}, 2.1);
  EXPECT_EQ(value(later, "rule-r4.active"), 1) << "2 s have passed while r1 plays";
}

TEST_F(RulesTest, RulesOfACharacterWithoutMotionControlHaveNoEffect) {
  add_all();
  document.characters[0].control.mode = ControlMode::passive;
  Player player = run(document, resources, {"KeyW"}, 0.1);
  EXPECT_FALSE(player.interpreter().find_output("rule-r1.count"));
}

/// The page reads rules back from circuits. Its tests use a document with a rule of every kind, and its circuit; both must stay in step.
TEST(RuleCircuit, IsThatOfTheTestsOfThePage) {
  std::ifstream file(std::string(UGOKI_WEB_TESTS) + "/rule_circuit.json");
  ASSERT_TRUE(file);
  const nlohmann::json sample = nlohmann::json::parse(file);
  const Result<Scenario> scenario = read_scenario(sample["document"].dump(), "rule_circuit.json");
  ASSERT_TRUE(scenario) << scenario.error().text();
  EXPECT_EQ(nlohmann::json::parse(default_circuit(*scenario)), sample["circuit"])
      << "Write the circuit of the document into web/test/rule_circuit.json, and adapt web/src/core/circuit_rules.ts.";
}

}  // namespace
}  // namespace ugoki::content
