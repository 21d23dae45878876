// A cyclist on a stand: two legs turn one crank, a chain turns the wheel, and the hands hold the handlebar. Crank, pedals and wheel have no
// drives.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "play.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/dynamics/loop_rows.h"

namespace ugoki::studio {
namespace {

class Loops {
 public:
  explicit Loops(const Mechanism& m) : m_(m), ws_(m), rows_(m.loops()) {}
  /// Maximum gap of all rows, m | rad.
  double gap(content::Player& player) {
    dynamics::update_kinematics(m_, player.q(0), player.v(0), ws_);
    dynamics::update_loop_rows(m_, ws_, m_.loops(), player.q(0), player.v(0), rows_);
    double out = 0;
    for (const double g : rows_.gap) out = std::max(out, std::fabs(g));
    return out;
  }

 private:
  const Mechanism& m_;
  dynamics::Workspace ws_;
  dynamics::LoopRows rows_;
};

TEST(Cyclist, FeetTurnThePedalsAndTheWheel) {
  content::Player player = open_content("cyclist");
  const Mechanism& m = *player.world().characters()[0].mechanism;
  Loops loops(m);
  const auto dof = [&](const char* link) { return static_cast<std::size_t>(m.link(m.find_link(link)).v_index); };
  const std::size_t crank = dof("crank"), wheel = dof("wheel");
  for (const std::size_t i : {crank, wheel}) ASSERT_EQ(m.dof(static_cast<int>(i)).effort, 0);
  double gap = 0;
  while (player.time() < 6) {
    ASSERT_TRUE(player.step());
    gap = std::max(gap, loops.gap(player));
  }
  EXPECT_LT(gap, 1e-4) << "m";
  std::vector<std::byte> saved;
  player.save(saved);
  // two turns at constant speed: the work of the drives is what bearings, wheel and joints dissipate
  const double speed = 2 * std::numbers::pi * 1.2, end = 6 + 2 / 1.2;
  double work = 0, wheel_loss = 0, losses = 0;
  std::vector<double> before(player.v(0).begin(), player.v(0).end());
  while (player.time() < end - 1e-9) {
    ASSERT_TRUE(player.step());
    const double* applied = output(player, "dynamics.applied");
    const auto v = player.v(0);
    for (std::size_t i = 0; i < v.size(); ++i) {
      const double mean = 0.5 * (before[i] + v[i]);
      const double loss = m.dof(static_cast<int>(i)).damping * v[i] * mean * player.step_size();
      work += applied[i] * mean * player.step_size();
      losses += loss;
      if (i == wheel) wheel_loss += loss;
    }
    EXPECT_EQ(applied[crank], 0) << "N m: nothing but the feet turns the crank";
    EXPECT_NEAR(v[crank], speed, 0.05 * speed) << "rad/s at " << player.time() << " s";
    EXPECT_NEAR(v[wheel], 2.6 * v[crank], 1e-6);
    if (HasFailure()) return;
    std::ranges::copy(v, before.begin());
  }
  EXPECT_NEAR(wheel_loss / (end - 6), 0.35 * 2.6 * 2.6 * speed * speed, 3) << "W";
  EXPECT_NEAR(work, losses, 0.02 * work) << "J";
  EXPECT_GT(wheel_loss, 0.5 * work) << "J";
  EXPECT_LT(player.measures(0).tracking_rms_deg, 1);
  const std::uint64_t hash = player.state_hash();
  ASSERT_TRUE(player.restore(saved));
  while (player.time() < end - 1e-9) ASSERT_TRUE(player.step());
  EXPECT_EQ(player.state_hash(), hash);
}

}  // namespace
}  // namespace ugoki::studio
