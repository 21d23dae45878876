// A walking human climbs a ramp, crosses a platform between props, and goes down again, without root assist.
#include <algorithm>
#include <cmath>

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

}  // namespace
}  // namespace ugoki::studio
