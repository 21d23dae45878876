// A walking human climbs a ramp, crosses a platform between props, and goes down again, without root assist.
#include <algorithm>
#include <cmath>
#include <utility>

#include "play.h"

namespace ugoki::studio {
namespace {

TEST(Hill, AHumanWalksOverPropsWithoutAssist) {
  content::Player player = open_content("hill");
  const auto index_of = [&](std::string_view id) {
    const auto& all = player.content().characters;
    return static_cast<int>(std::find_if(all.begin(), all.end(), [&](const auto& c) { return c.id == id; }) - all.begin());
  };
  const int human = index_of("human"), crate = index_of("crate1"), ball = index_of("ball");
  constexpr double platform = 0.422;  // m, height
  double highest = 0;
  while (player.time() < 14) {
    ASSERT_TRUE(player.step());
    const double rise = player.q(human)[2] - (player.q(human)[0] > 5.7 && player.q(human)[0] < 8.3 ? platform : 0);
    ASSERT_GT(rise, 0.82) << "m: height of the hips above the ground, at " << player.time() << " s";
    highest = std::max(highest, player.q(human)[2]);
  }
  EXPECT_GT(player.q(human)[0], 12) << "m: past the second ramp";
  EXPECT_GT(highest, 0.9 + platform);
  EXPECT_EQ(output(player, "human/control.report")[7], 0) << "root assist";
  EXPECT_NEAR(player.q(crate)[2], platform, 2e-3) << "m: the crate stays on the platform";
  EXPECT_LT(player.q(ball)[1], -2.5) << "m: the ball has bounced down the stairs";
  EXPECT_NEAR(player.q(ball)[2], 0, 0.35) << "m";
}

// The same on hills, with a push from behind, in the axes of the chest.
TEST(Hill, AHumanWalksOverHillsWithoutAssist) {
  content::Player player = open_content("hills");
  const auto& characters = player.content().characters;
  const HeightField& field = *player.content().mechanisms[static_cast<std::size_t>(characters[1].mechanism)]->link(0).shapes.at(0).field;
  const auto ground = [&](double x, double y) {  // m, at the nearest point of the grid
    const double u = (x - 6 + field.half_x) / (2 * field.half_x), v = (y + field.half_y) / (2 * field.half_y);
    if (u < 0 || u > 1 || v < 0 || v > 1) return 0.0;
    return field.point(static_cast<int>(u * (field.columns - 1) + 0.5), static_cast<int>(v * (field.rows - 1) + 0.5)).z;
  };
  double highest = 0;
  while (player.time() < 10) {
    ASSERT_TRUE(player.step());
    const double* q = player.q(0).data();
    ASSERT_GT(q[2] - ground(q[0], q[1]), 0.75) << "m: height of the hips above the hills, at " << player.time() << " s";
    highest = std::max(highest, ground(q[0], q[1]));
  }
  EXPECT_GT(highest, 0.2) << "m: the way leads over hills";
  EXPECT_GT(player.q(0)[0], 11) << "m: beyond the hills";
  EXPECT_EQ(output(player, "human/control.report")[7], 0) << "root assist";
}

// A character that begins on a platform stands on it as on the floor, with and without root assist.
TEST(Hill, APlatformIsAFloor) {
  // In a contact, the body with the smaller index comes first: the platform stands before the character, and after it.
  for (const auto& [assist, before] : {std::pair{0.0, false}, {0.5, false}, {0.5, true}}) {
    double tracking[2] = {}, used[2] = {};
    for (const bool raised : {false, true}) {
      const std::string height = raised ? "3" : "0";
      const Result<content::ContentText> made = make_content(
          R"({"scenario": {"version": 1, "name": "platform", "duration": 4, "characters": [{"id": "human", "mechanism": "human",
          "place": {"x": 0, "y": 0, "z": )" +
              height + R"(}, "control": {"assist_limit": )" + std::to_string(assist) + R"(},
          "track": [{"id": "k1", "motion": "human-walk", "start": 0, "length": 4, "loop": true}]}, {"id": "p1", "place": {"x": 3},
          "prop": {"shape": "box", "size": [12, 4, )" +
              (raised ? "3" : "0.005") + R"(], "friction": 0.9}}]}, "mechanisms": {}, "motions": {}})",
          "platform");
      ASSERT_TRUE(made) << made.error().text();
      content::Scenario scenario = made->scenario;
      if (!raised) scenario.characters.pop_back();
      if (raised && before) std::swap(scenario.characters[0], scenario.characters[1]);
      const int human = raised && before ? 1 : 0;
      const auto bytes = content::generate(scenario, made->resources);
      ASSERT_TRUE(bytes) << bytes.error().text();
      auto player = content::Player::open(*bytes, "platform");
      ASSERT_TRUE(player) << player.error().text();
      int feet = 0, steps = 0;
      while (player->time() < 4) {
        ASSERT_TRUE(player->step());
        feet += player->measures(human).feet_on_ground;
        ++steps;
      }
      EXPECT_GT(player->q(human)[2], 0.82 + (raised ? 3 : 0)) << "m: assist " << assist;
      EXPECT_GT(feet, steps) << "feet on the ground, at least one on the average";
      tracking[raised] = player->measures(human).tracking_rms_deg;
      used[raised] = player->measures(human).assist_rms_bw;
    }
    EXPECT_NEAR(tracking[1], tracking[0], 0.2) << "degrees, assist limit " << assist;
    EXPECT_NEAR(used[1], used[0], 0.002) << "body weights, assist limit " << assist;
  }
}

}  // namespace
}  // namespace ugoki::studio
