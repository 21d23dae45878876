// Tests of contents as text, with the files of examples/content: recipes of mechanisms and motions, and what the contents do.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "ugoki/content/player.h"
#include "ugoki/files/files.h"
#include "ugoki/samples/samples.h"
#include "ugoki/studio/content_recipes.h"

namespace ugoki::studio {
namespace {

namespace fs = std::filesystem;

const std::string folder = std::string(UGOKI_SOURCE_DIR) + "/examples/content/";

Result<content::ContentText> read(const std::string& name) {
  const Result<std::string> text = files::read_file(folder + name + ".json");
  if (!text) return fail(text.error());
  return make_content(*text, name);
}

content::Player play(const std::string& name) {
  const Result<content::ContentText> made = read(name);
  EXPECT_TRUE(made) << name << ": " << (made ? "" : made.error().text());
  const auto bytes = content::generate(made->scenario, made->resources);
  EXPECT_TRUE(bytes) << name << ": " << (bytes ? "" : bytes.error().text());
  auto player = content::Player::open(*bytes, name);
  EXPECT_TRUE(player) << name << ": " << (player ? "" : player.error().text());
  return std::move(*player);
}

void run(content::Player& player, double seconds) {
  while (player.time() < seconds - 1e-9) {
    const Result<void> stepped = player.step();
    ASSERT_TRUE(stepped) << stepped.error().text();
  }
}

TEST(Gallery, EveryContentIsMadeAndRuns) {
  int count = 0;
  for (const fs::directory_entry& file : fs::directory_iterator(folder)) {
    if (file.path().extension() != ".json") continue;
    const std::string name = file.path().stem().string();
    SCOPED_TRACE(name);
    content::Player player = play(name);
    for (int i = 0; i < (name == "band" ? 2 : 25); ++i) ASSERT_TRUE(player.step());
    ++count;
  }
  EXPECT_GE(count, 16);
}

// Gaits without measurement: the bodies walk to the ends of their paths and stand there; the human and the child without root assist.
TEST(Gallery, BodiesWalkAlongTheirPaths) {
  const Result<content::ContentText> made = read("paths");
  ASSERT_TRUE(made) << made.error().text();
  for (const content::ScenarioCharacter& c : made->scenario.characters) EXPECT_TRUE(c.track[0].gait) << "the gait can be changed";
  content::Player player = play("paths");
  run(player, 13.5);
  constexpr double ends[3][3] = {{10, 0, 0.8}, {4, 0.1, 0.45}, {11.5, 0.4, -0.2}};  // x, y: end of the path; height of a standing root, m
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(player.q(c)[0], ends[c][0], 0.4) << c;
    EXPECT_NEAR(player.q(c)[1], ends[c][1], 0.4) << c;
    EXPECT_GT(player.q(c)[2], ends[c][2]) << c;
  }
}

// The duet is placed three times: each pair walks the same way, later and elsewhere. The second one is turned by half a turn.
TEST(Gallery, DuetWalksInThreePlaces) {
  content::Player player = play("duet");
  ASSERT_EQ(player.content().characters.size(), 6u);
  EXPECT_EQ(player.content().characters[2].id, "duet.2/blue");
  run(player, 1.4);
  EXPECT_NEAR(player.q(2)[0], 4.5, 0.1) << "still stands at its begin";
  run(player, 3.2);
  const double first = player.q(0)[0];
  EXPECT_GT(first, 1) << "walks";
  run(player, 4.7);
  EXPECT_NEAR(player.q(2)[0], 4.5 - first, 0.2) << "1.5 s later, in the opposite direction";
  run(player, 11.5);
  constexpr double ends[6][2] = {{4, 0.6}, {4, -0.6}, {0.5, 3.4}, {0.5, 4.6}, {4, -2.9}, {4, -4.1}};
  for (int c = 0; c < 6; ++c) {
    EXPECT_NEAR(player.q(c)[0], ends[c][0], 0.5) << c;
    EXPECT_NEAR(player.q(c)[1], ends[c][1], 0.5) << c;
    EXPECT_GT(player.q(c)[2], 0.8) << c;
  }
}

// The published angle of K1 after 0.03 s is 15.81077 rad (IVP test set, problem Andrews). The content is 120 times slower, so its step of
// 0.5 ms corresponds to 4.2 us. The error of the method is of first order: 0.19 rad with twice the step, 0.048 rad with half of it.
TEST(Gallery, SqueezerTurnsAsPublished) {
  content::Player player = play("andrews");
  run(player, 3.6);
  constexpr double first = -0.0617138900142764;
  EXPECT_NEAR(first + player.q(0)[0], 15.81077, 0.1);
}

TEST(Gallery, WalkerOfManyLoopsWalks) {
  content::Player player = play("jansen");
  ASSERT_EQ(player.world().characters()[0].mechanism->loops().size(), 24u);
  run(player, 1.5);
  const auto q = player.q(0);
  EXPECT_GT(q[0], 0.8) << "m forwards";
  EXPECT_LT(std::fabs(q[1]), 0.1) << "m to the side";
}

TEST(Gallery, PoleIsBalancedThroughAPush) {
  content::Player player = play("own-lsi");
  run(player, 7.5);  // the push is at 4 s
  EXPECT_NEAR(player.q(0)[1], -0.12, 0.03) << "upright; the pole starts 0.12 rad from it";
  EXPECT_NEAR(player.q(0)[0], 0, 0.1) << "m, the cart";
}

TEST(Gallery, ToolOfTheRobotFollowsThePath) {
  content::Player player = play("five-bar");
  run(player, 3.75);  // a quarter of the second round: the right end of the path
  const content::PlayerMeasures m = player.measures(0);
  EXPECT_LT(m.tracking_rms_deg, 1);
}

TEST(Recipes, AreFollowedInAnyOrderAndRefusedIfTheyNeedThemselves) {
  const auto with = [](const std::string& more) {
    return make_content(R"({"scenario": {"version": 1, "name": "t", "characters": [{"id": "a", "name": "A", "mechanism": "small",
      "track": [{"id": "k", "motion": "mirrored", "start": 0, "length": 1, "loop": true}]}]}, )" +
                            more + "}",
                        "text");
  };
  const auto good = with(R"("motions": {"mirrored": {"operation": "mirror", "motion": "walk", "of": "small"},
    "walk": {"operation": "retarget", "motion": "human-walk", "of": "human", "for": "small"}}, "mechanisms": {"small": {"person": 1.2}})");
  ASSERT_TRUE(good) << good.error().text();
  EXPECT_TRUE(good->resources.motions.contains("walk"));
  EXPECT_EQ(good->resources.motions.at("mirrored")->nq, good->resources.mechanisms.at("small")->nq());
  const auto refused = [&](const std::string& more, const char* sentence) {
    const auto made = with(more);
    ASSERT_FALSE(made) << more;
    EXPECT_NE(made.error().text().find(sentence), std::string::npos) << made.error().text();
  };
  const std::string small = R"("mechanisms": {"small": {"person": 1.2}}, )";
  refused(small + R"("motions": {"mirrored": {"operation": "mirror", "motion": "mirrored", "of": "small"}})", "needs its own result");
  refused(small + R"("motions": {"mirrored": {"operation": "twist", "motion": "human-walk", "of": "human"}})", "no operation 'twist'");
  refused(small + R"("motions": {"mirrored": {"operation": "mirror", "motion": "nothing", "of": "small"}})",
          "does not define the motion 'nothing'");
  refused(R"("motions": {})", "does not define the mechanism 'small'");
  refused(R"("mechanisms": {"small": {"scale": "small", "factor": 2}})", "needs its own result");
  refused(R"("mechanisms": {"small": {"person": "tall"}})", "person");
}

TEST(Recipes, MeasuredMotionAndItsCorrection) {
  const auto made = read("natural");
  ASSERT_TRUE(made) << made.error().text();
  const Motion &raw = *made->resources.motions.at("capture"), &corrected = *made->resources.motions.at("corrected");
  EXPECT_EQ(raw.frames, corrected.frames);
  EXPECT_NE(raw.q, corrected.q);
}

}  // namespace
}  // namespace ugoki::studio
