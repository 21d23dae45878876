// Keyed layers of clips: commands, documents, and the motion that content plays.
#include <gtest/gtest.h>

#include "fixture.h"
#include "ugoki/content/commands.h"
#include "ugoki/content/executable.h"
#include "ugoki/content/layered_motions.h"
#include "ugoki/content/track.h"
#include "ugoki/json/json.h"

namespace ugoki::content {
namespace {

class LayersTest : public ::testing::Test {
 protected:
  std::string good(const std::string& command) {
    auto effect = apply_command(document, command, catalogue, next_id);
    EXPECT_TRUE(effect) << command << "\n" << (effect ? "" : effect.error().text());
    if (!effect) return {};
    document = std::move(effect->scenario);
    created = std::move(effect->created);
    return effect->label;
  }
  void bad(const std::string& command, ErrorCode code, const std::string& location) {
    const auto effect = apply_command(document, command, catalogue, next_id);
    ASSERT_FALSE(effect) << command;
    const Problem& p = effect.error().problems.front();
    EXPECT_EQ(p.code, code) << p.text();
    EXPECT_EQ(p.location, location) << p.text();
    EXPECT_FALSE(p.remedy.empty()) << p.text();
  }
  ScenarioClip& clip(std::size_t i = 0) { return document.characters[0].track[i]; }
  static std::string on(const std::string& type, const std::string& more) {
    return R"({"type": ")" + type + R"(", "character": "human", "clip": "k1", )" + more + "}";
  }
  void add_layer_with_keys() {
    good(on("layer.add", R"("value": {"id": "fix", "name": "Fix", "ease_in": 0.2})"));
    good(on("key.edit",
            R"("layer": "fix", "put": [{"link": "leg", "time": 0.5, "value": [0.2]}, {"link": "leg", "time": 1.5, "value": [-0.1]},
                            {"link": "pelvis", "part": "position", "time": 1, "value": [0, 0, 0.05]}])"));
  }

  Resources resources = testing::make_resources();
  Catalogue catalogue = catalogue_of(resources);
  Scenario document = testing::make_scenario();
  std::uint64_t next_id = 1;
  std::vector<std::string> created;
};

TEST_F(LayersTest, CommandsChangeLayersAndKeys) {
  EXPECT_EQ(good(on("layer.add", R"("value": {"mode": "replace"})")), "Add layer");
  ASSERT_EQ(created.size(), 1u);
  EXPECT_EQ(clip().layers[0].id, created[0]);
  EXPECT_EQ(clip().layers[0].keyed.mode, motion_edit::LayerMode::replace);
  EXPECT_LT(clip().layers[0].keyed.ease_in, 0) << "no fade by default";
  const std::string first = created[0];
  EXPECT_EQ(good(on("layer.add", R"("value": {"name": "Below"}, "at": 0)")), "Add layer");
  EXPECT_NE(created[0], first);
  EXPECT_EQ(clip().layers[1].id, first);
  EXPECT_EQ(good(on("layer.move", R"("layer": ")" + first + R"(", "at": 0)")), "Move layer");
  EXPECT_EQ(clip().layers[0].id, first);
  const std::string on_first = R"("layer": ")" + first + R"(", )";
  EXPECT_EQ(good(on("layer.set", on_first + R"("value": {"name": "Arm fix"})")), "Rename layer");
  EXPECT_EQ(good(on("layer.set", on_first + R"("value": {"on": false})")), "Switch off layer");
  EXPECT_EQ(good(on("layer.set", on_first + R"("value": {"weight": 0.5, "on": true})")), "Switch on layer");
  EXPECT_EQ(good(on("layer.set", on_first + R"("value": {"ease_out": 0.4})")), "Change layer");
  EXPECT_EQ(clip().layers[0].keyed.weight, 0.5);
  EXPECT_EQ(clip().layers[0].keyed.ease_out, 0.4);
  EXPECT_EQ(good(on("key.edit",
                    on_first + R"("put": [{"link": "leg", "time": 1, "value": [0.1]}, {"link": "leg", "time": 0.5, "value": [0.2]}])")),
            "Set key");
  const auto& keys = clip().layers[0].keyed.joints[0].keys;
  ASSERT_EQ(keys.size(), 2u);
  EXPECT_EQ(keys[0].time, 0.5) << "sorted by time";
  EXPECT_EQ(
      good(on("key.edit",
              on_first + R"("put": [{"link": "leg", "time": 0.5, "tangent": "free", "in": [1], "out": [2]}], "label": "Turn tangent")")),
      "Turn tangent");
  EXPECT_EQ(clip().layers[0].keyed.joints[0].keys[0].value[0], 0.2) << "absent fields keep their value";
  EXPECT_EQ(clip().layers[0].keyed.joints[0].keys[0].slope_out[0], 2);
  EXPECT_EQ(
      good(on("key.edit", on_first + R"("take": [{"link": "leg", "time": 0.5}], "put": [{"link": "leg", "time": 0.75, "value": [0.2]}])")),
      "Move keys");
  EXPECT_EQ(clip().layers[0].keyed.joints[0].keys[0].time, 0.75);
  EXPECT_EQ(good(on("key.edit", on_first + R"("take": [{"link": "leg", "time": 0.75}, {"link": "leg", "time": 1}])")), "Remove keys");
  EXPECT_TRUE(clip().layers[0].keyed.joints.empty()) << "a curve without keys is removed";
  EXPECT_EQ(good(on("layer.remove", R"("layer": ")" + first + "\"")), "Remove layer");
  EXPECT_EQ(clip().layers.size(), 1u);
}

TEST_F(LayersTest, FaultyCommandsAreRefusedWithTheirLocation) {
  add_layer_with_keys();
  bad(on("layer.set", R"("layer": "none", "value": {})"), ErrorCode::unknown, "command/layer");
  bad(on("layer.add", R"("value": {"id": "fix"})"), ErrorCode::duplicate, "scenario/characters/0/track/0/layers/1/id");
  bad(on("layer.add", R"("value": {"mode": "mix"})"), ErrorCode::unknown, "command/value/mode");
  bad(on("layer.set", R"("layer": "fix", "value": {"weight": 1.5})"), ErrorCode::range, "scenario/characters/0/track/0/layers/0/weight");
  bad(on("layer.set", R"("layer": "fix", "value": {"ease_in": -2})"), ErrorCode::range, "command/value/ease_in");
  bad(on("layer.set", R"("layer": "fix", "value": {"joints": []})"), ErrorCode::unknown, "command/value/joints");
  bad(on("key.edit", R"("layer": "fix", "take": [{"link": "leg", "time": 0.7}])"), ErrorCode::unknown, "command/take/0/time");
  bad(on("key.edit", R"("layer": "fix", "put": [{"link": "leg", "time": 2}])"), ErrorCode::structure, "command/put/0/value");
  bad(on("key.edit", R"("layer": "fix", "put": [{"link": "leg", "time": 1, "value": [1, 2]}])"), ErrorCode::structure,
      "command/put/0/value");
  bad(on("key.edit", R"("layer": "fix", "put": [{"link": "wing", "time": 1, "value": [1]}])"), ErrorCode::unknown,
      "scenario/characters/0/track/0/layers/0/joints/2/link");
  bad(on("key.edit", R"("layer": "fix", "put": [{"link": "pelvis", "time": 1, "value": [1]}])"), ErrorCode::structure,
      "scenario/characters/0/track/0/layers/0/joints/1");
  bad(on("key.edit", R"("layer": "fix", "put": [{"link": "leg", "time": -1, "value": [1]}])"), ErrorCode::range,
      "scenario/characters/0/track/0/layers/0/joints/0/keys/0/time");
  good(R"({"type": "character.set", "id": "human", "locked": true})");
  bad(on("layer.remove", R"("layer": "fix")"), ErrorCode::conflict, "command/character");
}

TEST_F(LayersTest, DocumentWithLayersIsReadAsItWasWritten) {
  add_layer_with_keys();
  good(on("key.edit",
          R"("layer": "fix", "put": [{"link": "leg", "time": 1, "value": [0.3], "tangent": "free", "in": [0.5], "out": [-0.25]}])"));
  good(on("layer.add", R"("value": {"mode": "replace", "on": false})"));
  const std::string text = write_scenario(document);
  const Result<Scenario> read = read_scenario(text, "test");
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(*read, document);
  EXPECT_EQ(write_scenario(*read), text);
  EXPECT_EQ(write_scenario(testing::make_scenario()).find("layers"), std::string::npos) << "clips without layers have no such field";
}

TEST_F(LayersTest, SplitAndCopiedClipsKeepTheMotion) {
  add_layer_with_keys();
  const auto layers = clip().layers;
  good(R"({"type": "clip.split", "character": "human", "id": "k1", "time": 0.8})");
  EXPECT_EQ(clip(0).layers, layers);
  EXPECT_EQ(clip(1).layers, layers) << "keys have the time of the motion, so both halves play as before";
  json::Json copy = json::parse_json(write_scenario(document), "test").value()["characters"][0]["track"][0];
  copy.erase("id");
  copy["type"] = "clip.add";
  copy["character"] = "human";
  copy["start"] = 7;
  good(copy.dump());
  EXPECT_EQ(document.characters[0].track.back().layers, layers);
}

TEST_F(LayersTest, GeneratedContentPlaysTheKeys) {
  const Result<std::vector<std::byte>> plain = generate(document, resources);
  ASSERT_TRUE(plain);
  add_layer_with_keys();
  const Result<std::vector<std::byte>> keyed = generate(document, resources);
  ASSERT_TRUE(keyed) << keyed.error().text();
  EXPECT_NE(*plain, *keyed);
  EXPECT_EQ(*generate(document, resources), *keyed) << "equal input gives equal bytes";
  const Result<Executable> made = read_executable(*keyed, "park.ugx");
  ASSERT_TRUE(made) << made.error().text();

  const Result<LayeredContent> layered = apply_layers(document, resources);
  ASSERT_TRUE(layered);
  const ScenarioCharacter& human = layered->scenario.characters[0];
  EXPECT_TRUE(human.track[0].layers.empty());
  EXPECT_TRUE(human.track[0].motion.starts_with("l-"));
  EXPECT_EQ(human.track[2].motion, "n-walk") << "another clip of the same motion is unchanged";
  const Motion& motion = *layered->resources.motions.at(human.track[0].motion);
  const Motion& original = *resources.motions.at("n-walk");
  const auto angle = [](const Motion& m, double t) { return m.frame(static_cast<int>(t * m.rate))[7]; };
  EXPECT_NEAR(angle(motion, 0.5) - angle(original, 0.5), 0.2, 1e-12);
  EXPECT_NEAR(angle(motion, 1.5) - angle(original, 1.5), -0.1, 1e-12);
  EXPECT_NEAR(motion.frame(100)[2] - original.frame(100)[2], 0.05, 1e-12);
  EXPECT_EQ(angle(motion, 0.29), angle(original, 0.29)) << "before the fade";

  good(on("layer.set", R"("layer": "fix", "value": {"on": false})"));
  EXPECT_EQ(*generate(document, resources), *plain) << "a layer that is off has no effect";
}

}  // namespace
}  // namespace ugoki::content
