// Stored poses, groups and order of tracks in the scenario document: JSON form, checks, commands.

#include <gtest/gtest.h>

#include "fixture.h"
#include "ugoki/content/commands.h"
#include "ugoki/content/scenario.h"

namespace ugoki::content {
namespace {

using testing::make_resources;
using testing::make_scenario;

constexpr const char* crouch =
    R"({"name": "Crouch", "mechanism": "m-walker", "joints": [{"link": "pelvis", "q": [0, 0, 0.6, 1, 0, 0, 0]}, {"link": "leg", "q": [0.8]}]})";

class PosesTest : public ::testing::Test {
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
  static std::string add(const std::string& pose) { return R"({"type": "pose.add", "pose": )" + pose + "}"; }

  Resources resources = make_resources();
  Catalogue catalogue = catalogue_of(resources);
  Scenario document = make_scenario();
  std::uint64_t next_id = 1;
};

TEST_F(PosesTest, CommandsStoreRenameAndRemovePoses) {
  EXPECT_EQ(good(add(crouch)), "Store pose");
  EXPECT_EQ(good(R"({"type": "pose.add", "at": 0, "pose": {"id": "p9", "mechanism": "m-gone", "joints": [{"link": "leg", "q": [0.1]}]}})"),
            "Store pose");
  ASSERT_EQ(document.poses.size(), 2u);
  EXPECT_EQ(document.poses[0].name, "Pose 2");
  EXPECT_EQ(document.poses[1].joints[0].q.size(), 7u);
  EXPECT_EQ(good(R"({"type": "pose.set", "id": "p9", "pose": {"name": "Reach"}})"), "Rename pose");
  EXPECT_EQ(good(R"({"type": "pose.set", "id": "p9", "pose": {"joints": [{"link": "leg", "q": [0.3]}]}})"), "Replace stored pose");
  EXPECT_EQ(document.poses[0].joints[0].q[0], 0.3);
  EXPECT_EQ(good(R"({"type": "pose.remove", "id": "p9"})"), "Remove pose");
  ASSERT_EQ(document.poses.size(), 1u);
  EXPECT_EQ(document.poses[0].name, "Crouch");
}

TEST_F(PosesTest, DocumentKeepsPosesGroupsAndOrder) {
  EXPECT_EQ(write_scenario(document).find("poses"), std::string::npos);
  EXPECT_EQ(write_scenario(document).find("track_order"), std::string::npos);
  EXPECT_EQ(write_scenario(document).find("group"), std::string::npos);
  good(add(crouch));
  EXPECT_EQ(good(R"({"type": "character.set", "id": "ball", "group": "Props"})"), "Group tracks");
  EXPECT_EQ(good(R"({"type": "track.move", "character": "ball", "at": 0})"), "Move track");
  const std::string text = write_scenario(document);
  const Result<Scenario> read = read_scenario(text, "scenario");
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(*read, document);
  EXPECT_EQ(write_scenario(*read), text);
}

TEST_F(PosesTest, OrderOfTracksLeavesTheOrderOfCharacters) {
  good(R"({"type": "character.add", "mechanism": "m-ball", "id": "c5"})");
  good(R"({"type": "track.move", "character": "c5", "at": 0})");
  good(R"({"type": "track.move", "character": "human", "at": 7})");
  EXPECT_EQ(document.track_order, (std::vector<std::string>{"c5", "ball", "human"}));
  EXPECT_EQ(document.characters[0].id, "human");
  good(R"({"type": "character.remove", "id": "c5"})");
  EXPECT_EQ(document.track_order, (std::vector<std::string>{"ball", "human"}));
}

TEST_F(PosesTest, PosesAndLayoutAreNotPlayed) {
  const Scenario before = played_part(document);
  good(add(crouch));
  good(R"({"type": "character.set", "id": "ball", "group": "Props"})");
  good(R"({"type": "track.move", "character": "ball", "at": 0})");
  EXPECT_EQ(played_part(document), before);
}

TEST_F(PosesTest, WrongPosesAreRefused) {
  bad(add(R"({"joints": [{"link": "leg", "q": [0.1]}]})"), ErrorCode::syntax, "scenario/poses/0/mechanism");
  bad(add(R"({"mechanism": "m-walker", "joints": []})"), ErrorCode::structure, "scenario/poses/0/joints");
  bad(add(R"({"mechanism": "m-walker", "joints": [{"link": "leg", "q": [0]}, {"link": "leg", "q": [1]}]})"), ErrorCode::duplicate,
      "scenario/poses/0/joints/1/link");
  bad(add(R"({"mechanism": "m-walker", "joints": [{"link": "leg", "q": [1e6]}]})"), ErrorCode::range, "scenario/poses/0/joints/0/q");
  bad(R"({"type": "pose.remove", "id": "p1"})", ErrorCode::unknown, "command/id");
  bad(R"({"type": "track.move", "character": "nobody", "at": 0})", ErrorCode::unknown, "command/character");
}

}  // namespace
}  // namespace ugoki::content
