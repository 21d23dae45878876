#include "ugoki/content/commands.h"

#include <gtest/gtest.h>

#include <array>
#include <map>

#include "field_names.h"
#include "fixture.h"
#include "mesh_body.h"
#include "random_commands.h"
#include "ugoki/content/delta.h"

namespace ugoki::content {
namespace {

using testing::make_resources;
using testing::make_scenario;

/// Fields without a value in a new document that random commands must set: one of each part of the document that is optional.
constexpr std::array optional_fields = {"characters/*/track/*/gait/stages/*/speed",
                                        "characters/*/track/*/layers/*/joints/*/keys/*/value/*",
                                        "characters/*/secondary/*/frequency",
                                        "characters/*/link_colors/*",
                                        "characters/*/shape_colors/*",
                                        "characters/*/shown",
                                        "characters/*/control/swing",
                                        "characters/*/group",
                                        "characters/*/muted",
                                        "characters/*/solo",
                                        "characters/*/locked",
                                        "characters/*/prop/mesh",
                                        "characters/*/prop/seed",
                                        "events/*/push/force/*",
                                        "events/*/push/axes",
                                        "events/*/pull/path/*/*",
                                        "events/*/throw/spin/*",
                                        "events/*/grab/reach",
                                        "events/*/release/link",
                                        "rules/*/if/*/key/key",
                                        "rules/*/if/*/touch/other",
                                        "rules/*/if/*/near/distance",
                                        "rules/*/if/*/time/time",
                                        "rules/*/if/*/playing/rule",
                                        "rules/*/if/*/released/character",
                                        "rules/*/if/*/variable/compare",
                                        "rules/*/if/*/time/not",
                                        "rules/*/do/play/motion",
                                        "rules/*/do/push/duration",
                                        "rules/*/do/push/axes",
                                        "rules/*/do/grab/limit",
                                        "rules/*/do/release/link",
                                        "rules/*/do/set/change",
                                        "variables/*/unit",
                                        "poses/*/joints/*/q/*",
                                        "markers/*/time",
                                        "track_order/*",
                                        "range/to",
                                        "cameras/*/keys/*/field_of_view",
                                        "shots/*/camera",
                                        "look/sky/zenith",
                                        "look/sun/color",
                                        "circuit/lsis/*/type",
                                        "circuit/wires/*/from",
                                        "circuit/notes/*/text",
                                        "circuit/probes/*/pin",
                                        "circuit/circuits/*/name",
                                        "instances/*/place/heading",
                                        "instances/*/muted",
                                        "order/*",
                                        "scenarios/*/events/*/push/time",
                                        "scenarios/*/instances/*/start"};
class CommandsTest : public ::testing::Test {
 protected:
  /// Applies the command to the document and expects success. @return the label
  std::string good(const std::string& command) {
    auto effect = apply_command(document, command, catalogue, next_id);
    EXPECT_TRUE(effect) << command << "\n" << (effect ? "" : effect.error().text());
    if (!effect) return {};
    document = std::move(effect->scenario);
    created = std::move(effect->created);
    return effect->label;
  }
  /// Expects that the command is refused with this code and location, and that no id is used.
  void bad(const std::string& command, ErrorCode code, const std::string& location) {
    const std::uint64_t before = next_id;
    const auto effect = apply_command(document, command, catalogue, next_id);
    ASSERT_FALSE(effect) << command;
    const Problem& p = effect.error().problems.front();
    EXPECT_EQ(p.code, code) << p.text();
    EXPECT_EQ(p.location, location) << p.text();
    EXPECT_FALSE(p.remedy.empty()) << p.text();
    EXPECT_EQ(next_id, before);
  }
  const ScenarioClip* clip(const std::string& id) {
    for (const auto& c : document.characters)
      for (const auto& k : c.track)
        if (k.id == id) return &k;
    return nullptr;
  }

  Resources resources = make_resources();
  Catalogue catalogue = catalogue_of(resources);
  Scenario document = make_scenario();
  std::uint64_t next_id = 1;
  std::vector<std::string> created;
};

TEST_F(CommandsTest, AddsClips) {
  EXPECT_EQ(good(R"({"type": "clip.add", "character": "human", "motion": "n-walk", "start": 6.5})"), "Add clip");
  ASSERT_EQ(created.size(), 1u);
  const ScenarioClip* k = clip(created[0]);
  ASSERT_NE(k, nullptr);
  EXPECT_DOUBLE_EQ(k->length, 2);  // default: the motion's duration
  EXPECT_EQ(document.characters[0].track.back().id, created[0]);
  good(R"({"type": "clip.add", "character": "human", "motion": "n-walk", "start": 7, "speed": 0.5, "offset": 1})");
  EXPECT_DOUBLE_EQ(clip(created[0])->length, 2);
}

TEST_F(CommandsTest, IdsAreNeverUsedTwice) {
  good(R"({"type": "clip.add", "character": "human", "motion": "n-walk", "start": 6.5, "id": "k7"})");
  good(R"({"type": "clip.add", "character": "human", "motion": "n-walk", "start": 6.7})");
  const std::string id = created[0];
  EXPECT_EQ(id, "k8");
  good(R"({"type": "clip.remove", "character": "human", "id": ")" + id + "\"}");
  good(R"({"type": "clip.add", "character": "human", "motion": "n-walk", "start": 6.7})");
  EXPECT_NE(created[0], id);
}

TEST_F(CommandsTest, MovesTrimsStretchesSlips) {
  EXPECT_EQ(good(R"({"type": "clip.set", "character": "human", "id": "k1", "start": 0.25})"), "Move clip");
  EXPECT_DOUBLE_EQ(clip("k1")->start, 0.25);
  EXPECT_EQ(good(R"({"type": "clip.set", "character": "human", "id": "k1", "length": 1})"), "Trim clip");
  EXPECT_EQ(good(R"({"type": "clip.set", "character": "human", "id": "k1", "offset": 0.5})"), "Slip clip");
  EXPECT_EQ(good(R"({"type": "clip.set", "character": "human", "id": "k1", "speed": 1.25, "length": 0.8})"), "Stretch clip");
  EXPECT_EQ(good(R"({"type": "clip.set", "character": "human", "id": "k1", "start": 4.5})"), "Move clip");
  EXPECT_EQ(document.characters[0].track[1].id, "k1") << "clips are sorted by start";
  EXPECT_EQ(good(R"({"type": "clip.set", "character": "human", "id": "k2", "loop": false, "length": 1})"), "Stop looping clip");
}

TEST_F(CommandsTest, RecipesOfGaitsStayWithTheirMotion) {
  good(
      R"({"type": "clip.set", "character": "human", "id": "k1", "gait": {"kind": "walk", "speed": 1.1, "path": [[2, 0], [3, 1]], "stages": [{"time": 3, "speed": 0.5}]}})");
  ASSERT_TRUE(clip("k1")->gait);
  EXPECT_EQ(clip("k1")->gait->speed, 1.1);
  EXPECT_EQ(clip("k1")->gait->path[1], (std::array{3.0, 1.0}));
  const Scenario read = read_scenario(write_scenario(document), "test").value();
  EXPECT_EQ(read, document) << "the document has the recipe";
  good(R"({"type": "clip.set", "character": "human", "id": "k1", "start": 0.25})");
  EXPECT_TRUE(clip("k1")->gait);
  good(R"({"type": "clip.set", "character": "human", "id": "k1", "motion": "n-step", "length": 0.5, "offset": 0})");
  EXPECT_FALSE(clip("k1")->gait) << "the recipe describes the former motion";
  good(R"({"type": "clip.set", "character": "human", "id": "k1", "gait": {}})");
  good(R"({"type": "clip.set", "character": "human", "id": "k1", "gait": null})");
  EXPECT_FALSE(clip("k1")->gait);
  bad(R"({"type": "clip.set", "character": "human", "id": "k1", "gait": {"pace": 2}})", ErrorCode::unknown, "command/gait/pace");
  bad(R"({"type": "clip.set", "character": "human", "id": "k1", "gait": {"path": [[1]]}})", ErrorCode::syntax, "command/gait/path/0");
  bad(R"({"type": "clip.set", "character": "human", "id": "k1", "gait": {"seconds": 1e9}})", ErrorCode::range,
      "scenario/characters/0/track/0/gait/seconds");
}

TEST_F(CommandsTest, SplitsClips) {
  EXPECT_EQ(good(R"({"type": "clip.split", "character": "human", "id": "k3", "time": 5.4})"), "Split clip");
  EXPECT_NEAR(clip("k3")->length, 0.4, 1e-12);
  const ScenarioClip* second = clip(created[0]);
  ASSERT_NE(second, nullptr);
  EXPECT_DOUBLE_EQ(second->start, 5.4);
  EXPECT_NEAR(second->length, 0.6, 1e-12);
  EXPECT_NEAR(second->offset, 0.5 + 0.4 * 1.5, 1e-12);
  EXPECT_EQ(second->blend, 0);
  good(R"({"type": "clip.split", "character": "human", "id": "k2", "time": 4.25})");
  EXPECT_NEAR(clip(created[0])->offset, 0.25, 1e-12) << "the offset is reduced to one cycle of the loop";
  bad(R"({"type": "clip.split", "character": "human", "id": "k1", "time": 2})", ErrorCode::range, "command/time");
}

TEST_F(CommandsTest, EditsCharacters) {
  EXPECT_EQ(good(R"({"type": "character.add", "mechanism": "m-ball", "place": {"x": 1}, "control": {"mode": "passive"}})"),
            "Add character");
  EXPECT_EQ(document.characters.back().name, "ball");
  EXPECT_EQ(document.characters.back().place.x, 1);
  EXPECT_EQ(good(R"({"type": "character.set", "id": "human", "place": {"y": 5}})"), "Place character");
  EXPECT_EQ(document.characters[0].place, (ScenarioPlace{1, 5, 0, 90})) << "fields that the command does not give are kept";
  EXPECT_EQ(good(R"({"type": "character.set", "id": "human", "name": "Ann"})"), "Rename character");
  EXPECT_EQ(good(R"({"type": "character.remove", "id": "human"})"), "Remove character");
  EXPECT_EQ(document.events.size(), 1u) << "the events of the character are removed as well";
  EXPECT_TRUE(document.camera.follow.empty());
}

TEST_F(CommandsTest, EditsEvents) {
  EXPECT_EQ(
      good(R"({"type": "event.add", "event": {"type": "push", "time": 1, "character": "human", "link": "pelvis", "force": [0, 100, 0]}})"),
      "Add push");
  EXPECT_EQ(document.events.front().id, created[0]);
  EXPECT_EQ(good(R"({"type": "event.set", "id": "e2", "event": {"time": 0.5}})"), "Move throw");
  EXPECT_EQ(document.events.front().id, "e2");
  EXPECT_EQ(good(R"({"type": "event.set", "id": "e1", "event": {"force": [1, 2, 3]}})"), "Change push");
  EXPECT_EQ(good(R"({"type": "event.remove", "id": "e1"})"), "Remove push");
  bad(R"({"type": "event.set", "id": "e2", "event": {"type": "push"}})", ErrorCode::structure, "command/event/type");
  bad(R"({"type": "event.add", "event": {"type": "push", "time": 1}})", ErrorCode::structure, "command/event/character");
}

TEST_F(CommandsTest, EditsSettingsAndCircuit) {
  EXPECT_EQ(good(R"({"type": "scenario.set", "duration": 12, "ground": {"friction": 0.4}})"), "Set duration");
  EXPECT_EQ(document.ground.friction, 0.4);
  EXPECT_EQ(document.ground.height, 0);
  EXPECT_EQ(good(R"({"type": "circuit.set", "circuit": {"version": 1, "name": "mine"}})"), "Change circuit");
  EXPECT_EQ(document.circuit, R"({"version":2,"name":"mine"})") << "converted to the present version";
  EXPECT_EQ(good(R"({"type": "circuit.set", "circuit": null})"), "Use default circuit");
  EXPECT_TRUE(document.circuit.empty());
}

TEST_F(CommandsTest, EditsMarkersAndRange) {
  EXPECT_EQ(good(R"({"type": "marker.add", "time": 4})"), "Add marker");
  ASSERT_EQ(created.size(), 1u);
  const std::string first = created[0];
  EXPECT_EQ(good(R"({"type": "marker.add", "id": "jump", "time": 2.5, "name": "Jump"})"), "Add marker");
  ASSERT_EQ(document.markers.size(), 2u);
  EXPECT_EQ(document.markers[0].name, "Jump") << "sorted by time";
  EXPECT_EQ(document.markers[1].name, "Marker 1");
  EXPECT_EQ(good(R"({"type": "marker.set", "id": "jump", "time": 6})"), "Move marker");
  EXPECT_EQ(document.markers[1].id, "jump");
  EXPECT_EQ(good(R"({"type": "marker.set", "id": "jump", "name": "Landing"})"), "Rename marker");
  EXPECT_EQ(good(R"({"type": "marker.remove", "id": ")" + first + "\"}"), "Remove marker");
  ASSERT_EQ(document.markers.size(), 1u);
  bad(R"({"type": "marker.set", "id": "none", "time": 1})", ErrorCode::unknown, "command/id");
  bad(R"({"type": "marker.add", "id": "k1", "time": 1})", ErrorCode::duplicate, "scenario/markers/0/id");
  bad(R"({"type": "marker.set", "id": "jump", "name": ""})", ErrorCode::range, "scenario/markers/0/name");

  EXPECT_EQ(good(R"({"type": "scenario.set", "range": {"from": 1, "to": 3}})"), "Set in and out");
  EXPECT_TRUE(document.range.is_set());
  bad(R"({"type": "scenario.set", "range": {"from": 3, "to": 3}})", ErrorCode::range, "scenario/range");
  bad(R"({"type": "scenario.set", "range": {"from": 3}})", ErrorCode::structure, "command/range/to");
  EXPECT_EQ(good(R"({"type": "scenario.set", "range": null})"), "Clear in and out");
  EXPECT_FALSE(document.range.is_set());
}

TEST_F(CommandsTest, ALockedTrackRefusesChangesOfItsClips) {
  EXPECT_EQ(good(R"({"type": "character.set", "id": "human", "locked": true})"), "Lock track");
  for (const char* command : {R"({"type": "clip.set", "character": "human", "id": "k1", "start": 0.1})",
                              R"({"type": "clip.add", "character": "human", "motion": "n-walk", "start": 6.5})",
                              R"({"type": "clip.remove", "character": "human", "id": "k1"})",
                              R"({"type": "clip.split", "character": "human", "id": "k1", "time": 1})"})
    bad(command, ErrorCode::conflict, "command/character");
  bad(R"({"type": "character.remove", "id": "human"})", ErrorCode::conflict, "command/id");
  EXPECT_EQ(good(R"({"type": "character.set", "id": "human", "name": "Ann"})"), "Rename character");
  EXPECT_EQ(good(R"({"type": "character.set", "id": "human", "locked": false})"), "Unlock track");
  EXPECT_EQ(good(R"({"type": "clip.set", "character": "human", "id": "k1", "start": 0.1})"), "Move clip");
}

TEST_F(CommandsTest, MutesAndSolosTracks) {
  EXPECT_EQ(good(R"({"type": "character.set", "id": "ball", "muted": true})"), "Mute track");
  EXPECT_EQ(good(R"({"type": "character.set", "id": "ball", "muted": false})"), "Unmute track");
  EXPECT_EQ(good(R"({"type": "character.set", "id": "ball", "solo": true})"), "Solo track");
  EXPECT_EQ(good(R"({"type": "character.set", "id": "ball", "solo": false})"), "End solo of track");
}

TEST_F(CommandsTest, GroupsAreOneEdit) {
  EXPECT_EQ(good(R"({"type": "group", "label": "Duplicate clip", "commands": [
    {"type": "clip.add", "character": "human", "motion": "n-walk", "start": 6.5},
    {"type": "clip.set", "character": "human", "id": "k1", "start": 0.1}]})"),
            "Duplicate clip");
  const Scenario before = document;
  bad(R"({"type": "group", "label": "x", "commands": [{"type": "clip.remove", "character": "human", "id": "k1"}, {"type": "clip.remove", "character": "human", "id": "none"}]})",
      ErrorCode::unknown, "command/commands/1/id");
  EXPECT_EQ(document, before);
}

TEST_F(CommandsTest, RefusesInvalidCommands) {
  bad("", ErrorCode::truncated, "command:1:1");
  bad("[]", ErrorCode::syntax, "command");
  bad("{}", ErrorCode::structure, "command/type");
  bad(R"({"type": "clip.fly"})", ErrorCode::unsupported, "command/type");
  bad(R"({"type": "clip.set", "character": "human", "id": "k1", "stretch": 2})", ErrorCode::unknown, "command/stretch");
  bad(R"({"type": "clip.set", "character": "nobody", "id": "k1"})", ErrorCode::unknown, "command/character");
  bad(R"({"type": "clip.set", "character": "human", "id": "k77"})", ErrorCode::unknown, "command/id");
  bad(R"({"type": "clip.set", "character": "human", "id": "k1", "length": 60})", ErrorCode::range, "scenario/characters/0/track/0/length");
  bad(R"({"type": "clip.add", "character": "human", "motion": "n-none", "start": 0.5})", ErrorCode::unknown,
      "scenario/characters/0/track/1/motion");
  bad(R"({"type": "clip.add", "character": "human", "motion": "n-walk", "start": 0})", ErrorCode::structure,
      "scenario/characters/0/track/1/start");
  bad(R"({"type": "character.add", "mechanism": 5})", ErrorCode::syntax, "command/mechanism");
  bad(R"({"type": "circuit.set", "circuit": "default"})", ErrorCode::syntax, "command/circuit");
  bad(R"({"type": "scenario.set", "frame_rate": 17})", ErrorCode::range, "scenario/frame_rate");
  bad(R"({"type": "group", "commands": {"type": "clip.remove"}})", ErrorCode::syntax, "command/commands");
  bad(std::string(200, '{'), ErrorCode::range, "command:1:101");
}

TEST_F(CommandsTest, ListsTheResourcesThatACommandNames) {
  EXPECT_EQ(resources_named(
                R"({"type": "group", "commands": [{"type": "clip.add", "motion": "n-1"}, {"type": "character.add", "mechanism": "m-2"}]})"),
            (std::vector<std::string>{"n-1", "m-2"}));
  EXPECT_TRUE(resources_named("nonsense").empty());
}

TEST_F(CommandsTest, DeltasOfRandomEditsWorkInBothDirections) {
  constexpr unsigned seed = 4711;
  SCOPED_TRACE(seed);
  testing::RandomCommands random(seed);
  int accepted = 0;
  for (int i = 0; i < 400; ++i) {
    const auto effect = apply_command(document, random.next(document), catalogue, next_id);
    if (!effect) continue;
    ++accepted;
    if (effect->scenario == document) continue;
    const auto before = parse_json(write_scenario(document), "before"), after = parse_json(write_scenario(effect->scenario), "after");
    ASSERT_TRUE(before && after);
    EXPECT_EQ(apply_delta(*before, make_delta(*before, *after))->dump(), after->dump());
    EXPECT_EQ(apply_delta(*after, make_delta(*after, *before))->dump(), before->dump());
    document = effect->scenario;
  }
  EXPECT_GT(accepted, 200);
}

// The tests of undo and redo use these random commands. A new type of command, or of item, belongs into them.
TEST_F(CommandsTest, RandomCommandsReachEveryTypeAndItem) {
  constexpr unsigned seed = 2026;
  SCOPED_TRACE(seed);
  Resources with_mesh = make_resources();
  with_mesh.mechanisms["m-table"] = testing::body_of({{{-0.5, -0.5, 0}, {0.5, 0.5, 0.7}}});
  const Catalogue known = catalogue_of(with_mesh);
  testing::RandomCommands random(seed);
  testing::FieldNames fields;
  std::map<std::string_view, int> applied;
  for (int i = 0; i < 6000; ++i) {
    const std::string command = random.next(document);
    auto effect = apply_command(document, command, known, next_id);
    if (!effect || effect->scenario == document) continue;
    document = std::move(effect->scenario);
    fields.add(parse_json(write_scenario(document), "document").value());
    for (const std::string_view type : command_types())
      if (command.find("\"type\": \"" + std::string(type) + "\"") != std::string::npos) ++applied[type];
  }
  for (const std::string_view type : command_types()) EXPECT_GT(applied[type], 0) << "no command " << type;
  for (const char* field : optional_fields) EXPECT_TRUE(fields.has(field)) << "no document had the field " << field;
}

TEST(Delta, RefusesADeltaThatDoesNotFitTheDocument) {
  const Json target = {{"a", 1}, {"list", {1, 2, 3}}};
  for (const char* text :
       {"{}", "[]", "3", R"({"x": 1})", R"({"o": {"b": {"v": 1}}})", R"({"o": []})", R"({"a": [[0, {"v": 1}]]})",
        R"({"o": {"list": {"a": [[3, {"v": 1}]]}}})", R"({"o": {"list": {"s": [2, 2, []]}}})", R"({"o": {"list": {"s": [-1, 0, []]}}})",
        R"({"o": {"list": {"s": [0, 18446744073709551615, []]}}})", R"({"o": {"list": {"a": [[0]]}}})"})
    EXPECT_FALSE(apply_delta(target, *parse_json(text, "delta"))) << text;
}

}  // namespace
}  // namespace ugoki::content
