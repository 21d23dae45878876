// A rider without root assist on a walking mount: the seat and the feet in stirrups are grips, the hands hold reins that lead to the bit.
#include <algorithm>
#include <cmath>

#include "play.h"

namespace ugoki::studio {
namespace {

constexpr int mount = 0, rider = 1;

TEST(Riding, TheRiderStaysInTheSaddleWithFeetInStirrupsAndReinsInHands) {
  content::Player player = open_content("riding");
  double gap = 0, tilt = 0;
  std::vector<std::byte> saved;
  while (player.time() < 8) {
    ASSERT_TRUE(player.step());
    ASSERT_EQ(grips_of(player).size(), 7u) << "seat, two stirrups, two hands, two ends of the bit, at " << player.time() << " s";
    for (const lsi::EventRecord& e : grips_of(player)) gap = std::max(gap, e.spare[0]);
    const auto q = player.q(rider);
    tilt = std::max(tilt, 2 * std::asin(std::min(1.0, std::hypot(q[4], q[5]))));
    if (saved.empty() && player.time() > 6) player.save(saved);
  }
  EXPECT_LT(gap, 1e-4) << "m";
  EXPECT_LT(tilt, 0.2) << "rad: the pelvis of the rider stays upright";
  EXPECT_GT(player.q(mount)[0], 5) << "m";
  EXPECT_NEAR(player.q(rider)[0] - player.q(mount)[0], 0.39, 0.1) << "m";
  EXPECT_LT(player.measures(mount).tracking_rms_deg, 3);
  EXPECT_LT(player.measures(rider).tracking_rms_deg, 3) << "the stirrups are no supports that pull the rider about";
  EXPECT_LT(player.measures(mount).assist_rms_bw, 0.06);
  EXPECT_EQ(output(player, "rider/control.report")[7], 0) << "root assist";
  const std::uint64_t hash = player.state_hash();
  ASSERT_TRUE(player.restore(saved));
  while (player.time() < 8) ASSERT_TRUE(player.step());
  EXPECT_EQ(player.state_hash(), hash);
}

}  // namespace
}  // namespace ugoki::studio
