// Two hands on a bar: a gymnast hangs, swings by the work of the joints alone, releases the bar, lands and stands. No external force but
// the grips, the ground and gravity acts.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "play.h"
#include "ugoki/dynamics/centroidal.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::studio {
namespace {

/// Books the energy of the gymnast: kinetic and potential energy and the springs of the joints, against the work of drives and dampers.
class Books {
 public:
  explicit Books(content::Player& player)
      : player_(player), m_(*player.world().characters()[0].mechanism), ws_(m_), before_(player.v(0).begin(), player.v(0).end()) {}

  void step() {
    ASSERT_TRUE(player_.step());
    const double* applied = output(player_, "dynamics.applied");
    for (std::size_t i = 6; i < before_.size(); ++i) {
      const double mean = 0.5 * (before_[i] + player_.v(0)[i]), work = applied[i] * mean * player_.step_size();
      balance_ += work - ws_.dofs[i].damping * player_.v(0)[i] * mean * player_.step_size();
      if (work > 0) turnover_ += work;
    }
    std::ranges::copy(player_.v(0), before_.begin());
  }
  /// J: kinetic, potential and elastic energy.
  double energy() {
    dynamics::update_kinematics(m_, player_.q(0), player_.v(0), ws_);
    const dynamics::Centroidal c = dynamics::calc_centroidal(m_, ws_);
    std::vector<Pose> X(static_cast<std::size_t>(m_.link_count()));
    std::vector<Vec6> V(X.size());
    calc_poses(m_, player_.q(0), X);
    calc_velocities(m_, player_.q(0), player_.v(0), V);
    double sum = 9.81 * c.mass * c.centre.z;
    for (std::size_t i = 0; i < X.size(); ++i) sum += 0.5 * dot(V[i], m_.links()[i].inertia * V[i]);
    std::vector<double> x(static_cast<std::size_t>(m_.nv()));
    for (const Link& link : m_.links()) joint_displacement(link.joint, player_.q(0).data() + link.q_index, x.data() + link.v_index);
    for (std::size_t i = 6; i < x.size(); ++i) {
      const Dof& d = ws_.dofs[i];
      if (d.stiffness > 0) sum += 0.5 * d.stiffness * (x[i] - d.rest) * (x[i] - d.rest);
      sum += 0.5 * d.armature * player_.v(0)[i] * player_.v(0)[i];
    }
    return sum;
  }
  [[nodiscard]] double balance() const { return balance_; }    ///< J: work of drives minus losses in dampers
  [[nodiscard]] double turnover() const { return turnover_; }  ///< J: positive work of the drives
  /// rad: angle of the centre of mass ahead of the bar, which is 2.5 m high.
  double angle() {
    dynamics::update_kinematics(m_, player_.q(0), player_.v(0), ws_);
    const Vec3 c = dynamics::calc_centroidal(m_, ws_).centre;
    return std::atan2(c.x, 2.5 - c.z);
  }

 private:
  content::Player& player_;
  const Mechanism& m_;
  dynamics::Workspace ws_;
  std::vector<double> before_;
  double balance_ = 0, turnover_ = 0;
};

TEST(Bar, HangsSwingsLetsGoLandsAndStands) {
  content::Player player = open_content("bar");
  Books books(player);
  const double start = books.energy();
  double gap = 0, before = 0;
  for (const double until : {4.0, 7.0, 9.6}) {
    double widest = 0;
    while (player.time() < until - 1e-9) {
      books.step();
      if (HasFatalFailure()) return;
      ASSERT_EQ(grips_of(player).size(), 2u);
      for (const lsi::EventRecord& e : grips_of(player)) gap = std::max(gap, e.spare[0]);
      widest = std::max(widest, std::fabs(books.angle()));
    }
    EXPECT_GT(widest, before + 0.08) << "rad: the amplitude grows, at " << until << " s";
    before = widest;
  }
  EXPECT_GT(before, 0.4) << "rad";
  EXPECT_LT(gap, 1e-4) << "m";
  EXPECT_NEAR(books.energy() - start, books.balance(), 0.005 * books.turnover()) << "J, of a work of " << books.turnover();
  std::vector<std::byte> saved;
  player.save(saved);
  bool flew = false;
  while (player.time() < 13.5) {
    ASSERT_TRUE(player.step());
    flew = flew || (grips_of(player).empty() && player.measures(0).feet_on_ground == 0);
    EXPECT_LT(output(player, "gymnast/control.recovery")[0], 2) << "falls at " << player.time() << " s";
    if (HasFailure()) return;
  }
  EXPECT_TRUE(flew);
  EXPECT_GT(player.q(0)[2], 0.8) << "m: height of the hips; the gymnast stands";
  double speed = 0;
  for (std::size_t i = 0; i < 6; ++i) speed = std::max(speed, std::fabs(player.v(0)[i]));
  EXPECT_LT(speed, 0.2) << "rad/s, m/s";
  EXPECT_EQ(output(player, "gymnast/control.report")[7], 0) << "root assist";
  const std::uint64_t hash = player.state_hash();
  ASSERT_TRUE(player.restore(saved));
  while (player.time() < 13.5) ASSERT_TRUE(player.step());
  EXPECT_EQ(player.state_hash(), hash);
}

/// The content with another moment of the release [s], in steps of 2 ms.
content::Player released_at(const std::string& moment) {
  std::string text = content_text("bar");
  const auto replace = [&](const std::string& from, const std::string& to) {
    std::size_t count = 0;
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size(), ++count) text.replace(at, from.size(), to);
    return count;
  };
  EXPECT_EQ(replace("\"time\": 10.0", "\"time\": " + moment), 2u);
  EXPECT_EQ(replace("\"start\": 10.0", "\"start\": " + moment), 1u);
  EXPECT_EQ(replace("\"length\": 10.0", "\"length\": " + moment), 1u);
  EXPECT_EQ(replace("\"step\": 0.001", "\"step\": 0.002"), 1u);
  return open_text(text, "bar");
}

// The gymnast prepares the release: she lands on her feet from all phases of the swing.
TEST(Bar, LandsAfterAReleaseInTheMiddleOfASwing) {
  for (const char* moment : {"8.95", "9.6", "9.8", "10.8"}) {  // behind, ahead, ahead at the lowest point, back at the lowest point
    content::Player player = released_at(moment);
    const double time = std::stod(moment);
    while (player.time() < time + 2.5) {
      ASSERT_TRUE(player.step());
      if (player.time() < time - 0.003) {
        ASSERT_EQ(grips_of(player).size(), 2u);
      }
      ASSERT_LT(output(player, "gymnast/control.recovery")[0], 2) << "released at " << moment << ", falls at " << player.time() << " s";
    }
    EXPECT_TRUE(grips_of(player).empty());
    EXPECT_GT(player.q(0)[2], 0.75) << "m: height of the hips; released at " << moment;
    EXPECT_EQ(output(player, "gymnast/control.report")[7], 0) << "root assist";
  }
}

// A person who stands without root assist holds a box with both hands. The controller knows the mass that the hands carry.
TEST(Bar, APersonHoldsABox) {
  content::Player player = open_text(R"({"scenario": {"version": 1, "name": "box", "duration": 4, "characters": [
    {"id": "a", "name": "A", "mechanism": "person", "control": {"mode": "track", "assist_limit": 0}, "track": [
      {"id": "k1", "motion": "stand", "start": 0, "length": 4, "loop": true, "layers": [{"id": "l1", "name": "arms", "mode": "replace",
       "ease_in": null, "ease_out": null, "joints": [{"link": "LeftForeArm", "keys": [{"time": 0, "value": [1.4]}]},
       {"link": "RightForeArm", "keys": [{"time": 0, "value": [1.4]}]}]}]}]},
    {"id": "box", "name": "Box", "mechanism": "box", "place": {"x": 0.35, "y": 0, "z": 0.95}, "control": {"mode": "passive"}}],
    "events": [
    {"id": "g1", "type": "grab", "time": 0, "character": "a", "link": "hand left", "point": [0, 0.07, 0], "other": "box",
     "other_link": "box", "reach": 2},
    {"id": "g2", "type": "grab", "time": 0, "character": "a", "link": "hand right", "point": [0, -0.07, 0], "other": "box",
     "other_link": "box", "reach": 2}]},
    "mechanisms": {"person": {"person": 1.75}, "box": {"format": "ugoki-mechanism", "version": 1, "name": "box", "links": [{"name": "box",
     "joint": {"type": "floating"}, "inertia": {"mass": 12, "centre": [0, 0, 0], "about_centre": [0.3, 0.3, 0.3, 0, 0, 0]},
     "shapes": [{"type": "box", "half_extents": [0.12, 0.12, 0.1], "collides": false}]}]}},
    "motions": {"stand": {"operation": "retarget", "motion": "human-stand", "of": "human", "for": "person"}}})",
                                     "box");
  while (player.time() < 1) ASSERT_TRUE(player.step());
  const double height = player.q(1)[2];
  while (player.time() < 4) {
    ASSERT_TRUE(player.step());
    ASSERT_NEAR(player.q(1)[2], height, 0.02) << "m: the box does not sink";
  }
  ASSERT_EQ(grips_of(player).size(), 2u);
  double force = 0;
  for (const lsi::EventRecord& e : grips_of(player)) force -= e.a.z;
  EXPECT_NEAR(force, 12 * 9.81, 1) << "N";
  EXPECT_GT(player.q(0)[2], 0.8) << "m: height of the hips";
  EXPECT_LT(output(player, "a/control.recovery")[0], 1);
}

}  // namespace
}  // namespace ugoki::studio
