// The requests `pose`, `curves` and `joints` over real sockets.
#include <cmath>

#include "studio_fixture.h"

namespace ugoki::studio {
namespace {

using nlohmann::json;
using test::Page;
using test::StudioTest;

class PoseTest : public StudioTest {
 protected:
  static json pose(double time, json more = json::object()) {
    json request = {{"op", "pose"}, {"character", "human"}, {"clip", "k1"}, {"time", time}};
    request.update(more);
    return request;
  }
  static json key_of(const json& reply, const std::string& link, const std::string& part) {
    for (const json& key : reply["keys"])
      if (key["link"] == link && key["part"] == part) return key;
    return nullptr;
  }
  static json set_leg(double value) { return {{"edit", {{"type", "set"}, {"link", 1}, {"dof", 0}, {"value", value}}}}; }
  /// Stores the moved keys of a reply in a new layer.
  static json store(const json& reply) {
    json put = json::array();
    for (const json& key : reply["keys"])
      if (key["moved"] == true)
        put.push_back({{"link", key["link"]}, {"part", key["part"]}, {"time", reply["motion_time"]}, {"value", key["value"]}});
    const json add = {
        {"type", "layer.add"}, {"character", "human"}, {"clip", "k1"}, {"value", {{"id", "fix"}, {"ease_in", 0.1}, {"ease_out", 0.1}}}};
    const json set = {{"type", "key.edit"}, {"character", "human"}, {"clip", "k1"}, {"layer", "fix"}, {"put", put}};
    return {{"op", "command"}, {"command", {{"type", "group"}, {"label", "Pose"}, {"commands", {add, set}}}}};
  }
};

TEST_F(PoseTest, KeysOfAnEditGiveTheEditedPose) {
  Page p = page();
  const json before = p.ask(pose(0.5));
  ASSERT_TRUE(before["ok"]) << before;
  EXPECT_EQ(before["links"].size(), 14u);
  EXPECT_EQ(before["changed"].size(), 0u);
  EXPECT_NEAR(before["angles"][1][0].get<double>(), 0.3 * std::sin(2 * 3.14159265 * 0.25), 1e-6);
  const json edited = p.ask(pose(0.5, set_leg(0.7)));
  ASSERT_TRUE(edited["ok"]) << edited;
  EXPECT_NEAR(edited["angles"][1][0].get<double>(), 0.7, 1e-6);
  EXPECT_EQ(edited["changed"].size(), 1u);
  EXPECT_EQ(key_of(edited, "leg", "joint")["moved"], true);
  EXPECT_EQ(key_of(edited, "pelvis", "rotation")["moved"], false);
  EXPECT_NEAR(key_of(edited, "leg", "joint")["value"][0].get<double>(), 0.7 - before["angles"][1][0].get<double>(), 2e-6);
  EXPECT_EQ(p.ask(pose(0.5))["links"], before["links"]) << "an edit alone changes nothing";
  ASSERT_TRUE(p.ask(store(edited))["ok"]);
  const json after = p.ask(pose(0.5));
  for (std::size_t i = 0; i < 14; ++i) EXPECT_NEAR(after["links"][i].get<double>(), edited["links"][i].get<double>(), 2e-6);
  EXPECT_EQ(p.ask(pose(0.9))["links"], p.ask(pose(0.9))["links"]);
  ASSERT_TRUE(p.ask({{"op", "undo"}})["ok"]);
  EXPECT_EQ(p.ask(pose(0.5))["links"], before["links"]);
}

TEST_F(PoseTest, EditsContinueFromUnkeyedChanges) {
  Page p = page();
  const json first = p.ask(pose(0.5, set_leg(0.4)));
  json second =
      p.ask(pose(0.5, {{"from", first["changed"]}, {"edit", {{"type", "turn"}, {"link", 1}, {"axis", {0, 2, 0}}, {"angle", 0.2}}}}));
  ASSERT_TRUE(second["ok"]) << second;
  EXPECT_NEAR(second["angles"][1][0].get<double>(), 0.6, 1e-6);
  // a drag of the root carries the whole character
  const json moved =
      p.ask(pose(0.5, {{"from", first["changed"]},
                       {"edit", {{"type", "reach"}, {"link", 0}, {"point", {0, 0, 0}}, {"target", {1.5, 2, 1.1}}, {"moves", "body"}}}}));
  ASSERT_TRUE(moved["ok"]) << moved;
  EXPECT_NEAR(moved["links"][0].get<double>(), 1.5, 0.01);
  EXPECT_NEAR(moved["links"][2].get<double>(), 1.1, 0.01);
  EXPECT_EQ(key_of(moved, "pelvis", "position")["moved"], true);
}

TEST_F(PoseTest, PoseOfALoopedClipUsesTheRoundAtThisTime) {
  Page p = page();
  json request = pose(2.25);
  request["clip"] = "k2";
  const json first = p.ask(request);
  request["time"] = 3.25;
  const json second = p.ask(request);
  EXPECT_NEAR(first["motion_time"].get<double>(), 0.25, 1e-9);
  EXPECT_NEAR(second["motion_time"].get<double>(), 0.25, 1e-9);
  EXPECT_EQ(first["angles"], second["angles"]);
  EXPECT_GT(std::hypot(first["links"][0].get<double>() - second["links"][0].get<double>(),
                       first["links"][1].get<double>() - second["links"][1].get<double>()),
            1)
      << "the character has walked on";
}

TEST_F(PoseTest, CurvesShowTheMotionWithAndWithoutKeys) {
  Page p = page();
  ASSERT_TRUE(p.ask(store(p.ask(pose(0.5, set_leg(0.7)))))["ok"]);
  const json curves = p.ask({{"op", "curves"}, {"character", "human"}, {"clip", "k1"}, {"links", {"leg", "pelvis"}}});
  ASSERT_TRUE(curves["ok"]) << curves;
  ASSERT_EQ(curves["curves"].size(), 3u);
  const json& leg = curves["curves"][0];
  EXPECT_EQ(leg["link"], "leg");
  EXPECT_EQ(curves["curves"][1]["part"], "rotation");
  EXPECT_EQ(curves["curves"][2]["part"], "position");
  EXPECT_EQ(curves["duration"], 2);
  const auto at = static_cast<std::size_t>(std::lround((0.5 - curves["from"].get<double>()) / curves["step"].get<double>()));
  EXPECT_NEAR(leg["result"][0][at].get<double>(), 0.7, 1e-4);
  EXPECT_NEAR(leg["base"][0][at].get<double>(), 0.3, 1e-2);
  EXPECT_EQ(leg["base"][0].back(), leg["result"][0].back()) << "after the fade";
}

TEST_F(PoseTest, StoredPosesAreAppliedWhereTheCharacterStands) {
  Page p = page();
  json request = pose(0.5, set_leg(0.7));
  request["coordinates"] = true;
  const json edited = p.ask(request);
  ASSERT_TRUE(edited["ok"]) << edited;
  const json& joints = edited["joints"];
  ASSERT_EQ(joints.size(), 2u);
  EXPECT_EQ(joints[0]["q"][0], 0) << "the root is stored without its place";
  EXPECT_EQ(joints[0]["q"][1], 0);
  const auto apply = [&](json more) {
    json edit = {{"type", "pose"}, {"joints", joints}};
    edit.update(more);
    return p.ask(pose(1.5, {{"edit", edit}}));
  };
  const json before = p.ask(pose(1.5)), applied = apply(json::object());
  ASSERT_TRUE(applied["ok"]) << applied;
  EXPECT_NEAR(applied["angles"][1][0].get<double>(), 0.7, 1e-5);
  const auto heading = [](const json& reply) { return 2 * std::atan2(reply["links"][6].get<double>(), reply["links"][3].get<double>()); };
  for (std::size_t i = 0; i < 2; ++i) EXPECT_NEAR(applied["links"][i].get<double>(), before["links"][i].get<double>(), 1e-5);
  EXPECT_NEAR(heading(applied), heading(before), 1e-4);
  EXPECT_GT(std::fabs(heading(before) - heading(edited)), 0.05) << "the character has turned between the two times";
  const double half = apply({{"share", 0.5}})["angles"][1][0].get<double>();
  EXPECT_NEAR(half, 0.5 * (0.7 + before["angles"][1][0].get<double>()), 1e-5);
  const json leg = apply({{"links", {"leg"}}});
  ASSERT_EQ(leg["changed"].size(), 1u);
  EXPECT_EQ(leg["changed"][0]["link"], 1);
  for (const json& wrong :
       {json{{"share", 2}}, json{{"links", {"wing"}}}, json{{"joints", {{{"link", "pelvis"}, {"q", {0, 0, 0, 0, 0, 0, 0}}}}}}})
    EXPECT_FALSE(apply(wrong)["ok"]) << wrong;

  const json add = {{"type", "pose.add"}, {"pose", {{"id", "p1"}, {"name", "Kick"}, {"mechanism", "m-walker"}, {"joints", joints}}}};
  ASSERT_TRUE(p.ask({{"op", "command"}, {"command", add}})["ok"]);
  const json pictures = p.ask({{"op", "poses"}, {"mechanism", "m-walker"}});
  ASSERT_EQ(pictures["poses"].size(), 1u) << pictures;
  EXPECT_EQ(pictures["poses"][0]["id"], "p1");
  EXPECT_EQ(pictures["poses"][0]["links"].size(), 14u);
  EXPECT_NEAR(pictures["poses"][0]["links"][2].get<double>(), edited["links"][2].get<double>(), 1e-5);
  EXPECT_EQ(p.ask({{"op", "poses"}, {"mechanism", "m-ball"}})["poses"].size(), 0u) << "the pose does not fit the ball";
}

/// Two ways to the same pose: a stored pose applied mirrored, and applied and then mirrored.
TEST_F(PoseTest, MirroredStoredPoseIsTheMirrorOfTheAppliedPose) {
  Page p = page();
  ASSERT_TRUE(p.ask({{"op", "new"}, {"path", "mirror.ugoki"}, {"from", "sample"}})["ok"]);
  const json human = p.ask({{"op", "hello"}})["document"]["characters"][0];
  const auto ask = [&](json more) {
    json request = {{"op", "pose"}, {"character", human["id"]}, {"clip", human["track"][0]["id"]}, {"time", 0.4}, {"coordinates", true}};
    request.update(more);
    json reply = p.ask(request);
    EXPECT_TRUE(reply["ok"]) << reply;
    return reply;
  };
  const json joints = ask({{"time", 0.9}})["joints"];
  const json applied = ask({{"edit", {{"type", "pose"}, {"joints", joints}}}});
  const json twice = ask({{"from", applied["changed"]}, {"edit", {{"type", "mirror"}}}});
  const json once = ask({{"edit", {{"type", "pose"}, {"joints", joints}, {"mirror", true}}}});
  EXPECT_NE(once["angles"], applied["angles"]);
  for (std::size_t i = 0; i < once["links"].size(); ++i)
    EXPECT_NEAR(once["links"][i].get<double>(), twice["links"][i].get<double>(), 2e-5) << i;
}

TEST_F(PoseTest, JointsListLimitsAndPartners) {
  Page p = page();
  const json reply = p.ask({{"op", "joints"}, {"mechanism", "m-walker"}});
  ASSERT_TRUE(reply["ok"]) << reply;
  ASSERT_EQ(reply["joints"].size(), 2u);
  EXPECT_EQ(reply["joints"][0]["type"], "floating");
  EXPECT_EQ(reply["joints"][0]["dofs"].size(), 6u);
  EXPECT_EQ(reply["joints"][1]["dofs"][0]["axis"], json({0, 1, 0}));
  EXPECT_EQ(reply["joints"][1]["dofs"][0]["lower"], nullptr) << "no limit";
}

TEST_F(PoseTest, FaultyRequestsGetAnErrorWithARemedy) {
  Page p = page();
  for (const json& wrong :
       {json{{"op", "pose"}}, pose(0.5, {{"character", "nobody"}}), pose(0.5, {{"clip", "k99"}}), pose(0.5, {{"layer", "none"}}),
        pose(0.5, {{"time", "now"}}), pose(0.5, {{"edit", {{"type", "dance"}}}}), pose(0.5, {{"edit", 3}}),
        pose(0.5, {{"edit", {{"type", "turn"}, {"link", 9}, {"axis", {0, 0, 1}}}}}),
        pose(0.5, {{"edit", {{"type", "set"}, {"link", 1}, {"dof", 4}, {"value", 1}}}}),
        pose(0.5, {{"pins", {77}}, {"edit", {{"type", "mirror"}}}}), pose(0.5, {{"pins", {"a"}}}),
        pose(0.5, {{"from", {{{"link", 0}, {"q", {0, 0, 0, 0, 0, 0, 0}}}}}}), pose(0.5, {{"from", {{{"link", 1}, {"q", {1, 2}}}}}}),
        json{{"op", "curves"}, {"character", "human"}, {"clip", "k1"}, {"links", {"wing"}}},
        json{{"op", "curves"}, {"character", "human"}, {"clip", "k1"}}, json{{"op", "joints"}, {"mechanism", "m-none"}},
        json{{"op", "joints"}}}) {
    const json reply = p.ask(wrong);
    ASSERT_FALSE(reply["ok"]) << wrong;
    EXPECT_FALSE(reply["error"]["problems"][0]["remedy"].get<std::string>().empty()) << wrong;
  }
  EXPECT_TRUE(p.ask(pose(0.5))["ok"]);
}

TEST_F(PoseTest, OperationsOnMotionsIncludeTheKeys) {
  Page p = page();
  ASSERT_TRUE(p.ask(store(p.ask(pose(0.5, set_leg(0.7)))))["ok"]);
  const json reply = p.ask({{"op", "motion"}, {"task", "t1"}, {"operation", "trim"}, {"character", "human"}, {"clip", "k1"}});
  ASSERT_TRUE(reply["ok"]) << reply;
  const json clip = p.ask({{"op", "hello"}})["document"]["characters"][0]["track"][0];
  EXPECT_FALSE(clip.contains("layers"));
  EXPECT_NEAR(p.ask(pose(0.5))["angles"][1][0].get<double>(), 0.7, 1e-4);
  ASSERT_TRUE(p.ask({{"op", "undo"}})["ok"]);
  EXPECT_TRUE(p.ask({{"op", "hello"}})["document"]["characters"][0]["track"][0].contains("layers"));
}

}  // namespace
}  // namespace ugoki::studio
