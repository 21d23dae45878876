// Grips: made and opened by the events of a scenario.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ugoki/content/player.h"
#include "ugoki/lsi/payload.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/samples/samples.h"

namespace ugoki::content {
namespace {

/// A rod of 2 kg and 1 m, whose frame is at its upper end.
MechanismPtr make_rod(JointType type) {
  MechanismSpec spec;
  spec.name = "rod";
  LinkSpec rod;
  rod.name = "rod";
  rod.joint.type = type;
  rod.joint.axis = {0, 1, 0};
  rod.shapes = {Shape::capsule(0.02, {0, 0, 0}, {0, 0, -1})};
  rod.inertia = solid_inertia(rod.shapes[0], 2 / volume(rod.shapes[0]));
  spec.links = {rod};
  return Mechanism::make(std::move(spec)).value();
}

MechanismPtr make_box() {
  MechanismSpec spec;
  spec.name = "box";
  LinkSpec box;
  box.name = "box";
  box.joint.type = JointType::floating;
  box.shapes = {Shape::box({0.2, 0.15, 0.1})};
  box.inertia = solid_inertia(box.shapes[0], 5 / volume(box.shapes[0]));
  spec.links = {box};
  return Mechanism::make(std::move(spec)).value();
}

ScenarioCharacter passive(const std::string& id, const std::string& mechanism, const Vec3& at) {
  ScenarioCharacter c;
  c.id = c.name = id;
  c.mechanism = mechanism;
  c.place = {at.x, at.y, at.z, 0};
  c.control.mode = ControlMode::passive;
  return c;
}

ScenarioEvent grab(const std::string& id, const std::string& character, const std::string& link, double time) {
  ScenarioEvent e;
  e.id = id;
  e.type = EventType::grab;
  e.time = time;
  e.character = character;
  e.link = link;
  e.grip.limit = 1e5;
  return e;
}

ScenarioEvent thrown(const std::string& character, const Vec3& from, const Vec3& velocity, const Vec3& spin) {
  ScenarioEvent e;
  e.id = "throw";
  e.type = EventType::throw_;
  e.character = character;
  e.from = from;
  e.velocity = velocity;
  e.spin = spin;
  return e;
}

Player open(const Scenario& s, const Resources& r) {
  const auto ugx = generate(s, r);
  EXPECT_TRUE(ugx) << (ugx ? "" : ugx.error().text());
  Result<Player> player = Player::open(*ugx);
  EXPECT_TRUE(player) << (player ? "" : player.error().text());
  return std::move(*player);
}

std::span<const lsi::EventRecord> grips_of(Player& player) {
  return lsi::records<lsi::EventRecord>(player.interpreter().find_output("dynamics.grips")->bytes.data());
}

double energy(const Mechanism& m, std::span<const double> q, std::span<const double> v) {
  std::vector<Pose> X(static_cast<std::size_t>(m.link_count()));
  std::vector<Vec6> V(X.size());
  calc_poses(m, q, X);
  calc_velocities(m, q, v, V);
  double sum = 0;
  for (std::size_t i = 0; i < X.size(); ++i) {
    const Inertia& I = m.links()[i].inertia;
    sum += 0.5 * dot(V[i], I * V[i]) + 9.81 * I.mass * (X[i] * I.centre()).z;
  }
  return sum;
}

TEST(Grip, AHeldRodSwingsAsAPendulum) {
  // The rod stands on its gripped lower end and falls over; it turns around its grip with up to 8 rad/s.
  Resources resources;
  resources.mechanisms["m-free"] = make_rod(JointType::floating);
  Scenario s;
  s.duration = 10;
  s.ground.height = -100;
  s.characters = {passive("rod", "m-free", {0, 0, 0})};
  s.events = {thrown("rod", {0, 0, 0}, {3, 0, 0}, {0, 3, 0}), grab("g", "rod", "rod", 0)};
  s.events[1].grip.point = {0, 0, -1};
  Player player = open(s, resources);
  ASSERT_TRUE(player.step());
  const Mechanism& m = *resources.mechanisms["m-free"];
  const double before = energy(m, player.q(0), player.v(0));
  double gap = 0, worst = 0;
  for (int k = 1; k < 5000; ++k) {
    ASSERT_TRUE(player.step());
    const auto grips = grips_of(player);
    ASSERT_EQ(grips.size(), 1u);
    gap = std::max(gap, grips[0].spare[0]);
    worst = std::max(worst, std::fabs(energy(m, player.q(0), player.v(0)) - before));
  }
  const double swing = 0.5 * 2.0 / 3 * 9 + 2 * 9.81;  // J: kinetic energy at the lowest point; the centre has fallen by 1 m
  EXPECT_LT(gap, 1e-4) << "m";
  EXPECT_LT(worst, 0.005 * swing) << "J, of " << swing;
}

TEST(Grip, ForceOfAHangingBodyIsItsWeight) {
  Resources resources;
  resources.mechanisms["m-box"] = make_box();
  Scenario s;
  s.duration = 2;
  s.characters = {passive("box", "m-box", {0, 0, 1})};
  s.events = {grab("g", "box", "box", 0)};
  Player player = open(s, resources);
  for (int k = 0; k < 500; ++k) ASSERT_TRUE(player.step());
  ASSERT_EQ(grips_of(player).size(), 1u);
  EXPECT_NEAR(grips_of(player)[0].a.z, 5 * 9.81, 1e-6);
  EXPECT_NEAR(player.q(0)[2], 1, 1e-9);
}

TEST(Grip, TwoBodiesInTheAirKeepTheirMomentum) {
  Resources resources;
  resources.mechanisms["m-box"] = make_box();
  for (const bool rigid : {false, true}) {
    Scenario s;
    s.duration = 1;
    s.gravity = {};
    s.ground.height = -100;
    s.characters = {passive("box", "m-box", {0, 0, 0}), passive("other", "m-box", {0, 0, -0.4})};
    ScenarioEvent g = grab("g", "other", "box", 0.1);
    g.grip.point = {0.05, 0.1, 0.2};
    g.grip.other = "box";
    g.grip.other_link = "box";
    g.grip.rigid = rigid;
    s.events = {thrown("other", {0, 0, -0.4}, {0.3, 0.1, 0}, {1, 2, 0.5}), g};
    Player player = open(s, resources);
    const auto momentum = [&] {
      Vec3 p;
      for (int c = 0; c < 2; ++c) {
        const Mechanism& m = *player.world().characters()[static_cast<std::size_t>(c)].mechanism;
        std::vector<Pose> X(1);
        std::vector<Vec6> V(1);
        calc_poses(m, player.q(c), X);
        calc_velocities(m, player.q(c), player.v(c), V);
        p += X[0].R * ((m.link(0).inertia * V[0]).v);
      }
      return p;
    };
    for (int k = 0; k < 40; ++k) ASSERT_TRUE(player.step());
    const Vec3 before = momentum();
    Quat first;
    for (int k = 0; k < 400; ++k) {
      ASSERT_TRUE(player.step());
      const Quat turn = Quat{player.q(0)[3], player.q(0)[4], player.q(0)[5], player.q(0)[6]}.conjugate() *
                        Quat{player.q(1)[3], player.q(1)[4], player.q(1)[5], player.q(1)[6]};
      if (k == 100) first = turn;
      if (k > 100 && rigid) EXPECT_LT(norm(log_map(first.conjugate() * turn)), 1e-4);
    }
    ASSERT_EQ(grips_of(player).size(), 1u);
    EXPECT_LT(grips_of(player)[0].spare[0], 1e-4) << "m";
    EXPECT_LT(norm(momentum() - before), 1e-9);
  }
}

TEST(Grip, OpensAtItsEventAndBeyondItsLimit) {
  Resources resources;
  resources.mechanisms["m-box"] = make_box();
  Scenario s;
  s.duration = 2;
  s.characters = {passive("box", "m-box", {0, 0, 2})};
  ScenarioEvent release = grab("r", "box", "box", 0.5);
  release.type = EventType::release;
  s.events = {grab("g", "box", "box", 0), release};
  Player player = open(s, resources);
  for (int k = 0; k < 250; ++k) ASSERT_TRUE(player.step());
  EXPECT_EQ(grips_of(player).size(), 1u);
  for (int k = 0; k < 100; ++k) ASSERT_TRUE(player.step());
  EXPECT_TRUE(grips_of(player).empty());
  EXPECT_NEAR(player.q(0)[2], 2 - 0.5 * 9.81 * 0.2 * 0.2, 0.005) << "free fall since the release";

  s.events.pop_back();
  s.events[0].grip.limit = 40;  // N, below the weight
  Player weak = open(s, resources);
  for (int k = 0; k < 20; ++k) ASSERT_TRUE(weak.step());
  EXPECT_EQ(grips_of(weak).size(), 1u);
  for (int k = 0; k < 20; ++k) ASSERT_TRUE(weak.step());
  EXPECT_TRUE(grips_of(weak).empty());

  s.events[0].grip.limit = 450;
  s.events[0].grip.has_at = true;
  s.events[0].grip.at = {0, 0, 2.5};  // out of reach
  Player far = open(s, resources);
  ASSERT_TRUE(far.step());
  EXPECT_TRUE(grips_of(far).empty());
}

TEST(Grip, AHumanHangsByBothHandsFromTheWorldWithTheSameBitsAfterRestore) {
  samples::Sample sample = samples::make_sample();
  Scenario s = read_scenario(sample.document, "sample").value();
  std::erase_if(s.characters, [](const ScenarioCharacter& c) { return c.id != "human"; });
  s.rules.clear();
  s.camera.follow.clear();
  s.duration = 3;
  s.characters[0].control.mode = ControlMode::passive;
  s.characters[0].place.z = 1.5;
  s.events = {grab("left", "human", "hand left", 0), grab("right", "human", "hand right", 0)};
  Player player = open(s, sample.resources);
  std::vector<std::byte> saved;
  double gap = 0;
  for (int k = 0; k < 1500; ++k) {
    if (k == 500) player.save(saved);
    ASSERT_TRUE(player.step());
    for (const lsi::EventRecord& e : grips_of(player)) gap = std::max(gap, e.spare[0]);
  }
  ASSERT_EQ(grips_of(player).size(), 2u);
  EXPECT_LT(gap, 2e-4) << "m; largest while the limp body falls into its grips";
  const double weight = sample.resources.mechanisms.at(s.characters[0].mechanism)->mass() * 9.81;
  EXPECT_NEAR(grips_of(player)[0].a.z + grips_of(player)[1].a.z, weight, 0.2 * weight);
  const std::uint64_t hash = player.state_hash();
  ASSERT_TRUE(player.restore(saved));
  for (int k = 500; k < 1500; ++k) ASSERT_TRUE(player.step());
  EXPECT_EQ(player.state_hash(), hash);
}

TEST(Grip, TextFormAndRefusals) {
  const char* const text = R"({"version": 1, "characters": [{"id": "box", "mechanism": "m-box", "control": {"mode": "passive"}}],
    "events": [{"id": "g", "type": "grab", "time": 1, "character": "box", "link": "box", "at": [0, 0, 1], "rigid": true},
               {"id": "r", "type": "release", "time": 2, "character": "box", "link": "box"}]})";
  const auto s = read_scenario(text, "text");
  ASSERT_TRUE(s) << s.error().text();
  EXPECT_TRUE(s->events[0].grip.has_at && s->events[0].grip.rigid);
  EXPECT_EQ(read_scenario(write_scenario(*s), "again").value(), *s);
  Resources resources;
  resources.mechanisms["m-box"] = make_box();
  const auto refused = [&](auto&& change, const std::string& words) {
    Scenario bad = *s;
    change(bad.events[0]);
    const auto made = generate(bad, resources);
    ASSERT_FALSE(made) << words;
    EXPECT_NE(made.error().text().find(words), std::string::npos) << made.error().text();
  };
  refused([](ScenarioEvent& e) { e.link = "hand"; }, "has no link 'hand'");
  refused([](ScenarioEvent& e) { e.grip.other = "bar"; }, "no character 'bar'");
  refused([](ScenarioEvent& e) { e.grip.other_link = "bar"; }, "no character that has the link");
  refused([](ScenarioEvent& e) { e.grip.limit = 0; }, "out of range");
  refused([](ScenarioEvent& e) { e.grip.other = e.grip.other_link = "box"; }, "grips itself");
}

}  // namespace
}  // namespace ugoki::content
