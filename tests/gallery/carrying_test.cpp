// Two people carry a box of 40 kg over more than 5 m without root assist; one of them is pushed.
#include <algorithm>
#include <cmath>

#include "play.h"

namespace ugoki::studio {
namespace {

constexpr int front = 0, rear = 1, box = 2;

TEST(Carrying, TwoPeopleCarryABoxThroughAPush) {
  content::Player player = open_content("box-by-two");
  ASSERT_EQ(player.world().characters().size(), 3u);
  double gap = 0, force = 0, lateral = 0;
  int count = 0;
  std::vector<std::byte> saved;
  while (player.time() < 12) {
    ASSERT_TRUE(player.step());
    ASSERT_EQ(grips_of(player).size(), 4u) << "all hands hold, at " << player.time() << " s";
    for (const lsi::EventRecord& e : grips_of(player)) {
      gap = std::max(gap, e.spare[0]);
      if (player.time() > 2) force -= e.a.z;
    }
    if (player.time() > 2) ++count;
    for (const int c : {front, rear}) ASSERT_GT(player.q(c)[2], 0.85) << "m: height of the hips of " << c << " at " << player.time() << " s";
    ASSERT_NEAR(player.q(box)[2], 0.81, 0.06) << "m, at " << player.time() << " s";
    if (player.time() > 5 && player.time() < 7) lateral = std::max(lateral, std::fabs(player.q(rear)[1]));
    if (saved.empty() && player.time() > 10) player.save(saved);
  }
  EXPECT_LT(gap, 1e-4) << "m";
  EXPECT_NEAR(force / count, 40 * 9.81, 4) << "N: mean force of all hands";
  EXPECT_GT(player.q(box)[0], 5.5) << "m";
  EXPECT_GT(lateral, 0.1) << "m: the push has an effect";
  for (const char* report : {"front/control.report", "rear/control.report"}) EXPECT_EQ(output(player, report)[7], 0) << "root assist";
  const std::uint64_t hash = player.state_hash();
  ASSERT_TRUE(player.restore(saved));
  while (player.time() < 12) ASSERT_TRUE(player.step());
  EXPECT_EQ(player.state_hash(), hash);
}

}  // namespace
}  // namespace ugoki::studio
