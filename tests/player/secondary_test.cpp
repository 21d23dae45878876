// Secondary motion in content: chains on springs swing at their frequency, and the document is checked.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ugoki/content/generate.h"
#include "ugoki/content/player.h"
#include "ugoki/content/scenario_json.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::content {
namespace {

/// A post at a height of 1 m with a horizontal tail of four rods, each 0.1 m long with a mass of 0.1 kg.
MechanismPtr make_tail() {
  MechanismSpec spec;
  spec.name = "tail";
  LinkSpec post;
  post.name = "post";
  post.joint.X_PJ.p = {0, 0, 1};
  post.inertia = Inertia::from_centre(1, {}, {0.01, 0.01, 0.01, 0, 0, 0});
  spec.links.push_back(post);
  for (int i = 0; i < 4; ++i) {
    LinkSpec rod;
    rod.name = "rod" + std::to_string(i);
    if (i == 0) rod.label = "tail";
    rod.parent = spec.links.back().name;
    rod.joint.type = JointType::universal;
    rod.joint.axis = {0, 1, 0};
    rod.joint.axis2 = {0, 0, 1};
    if (i > 0) rod.joint.X_PJ.p = {0.1, 0, 0};
    rod.inertia = Inertia::from_centre(0.1, {0.05, 0, 0}, {1e-5, 9e-5, 9e-5, 0, 0, 0});
    spec.links.push_back(rod);
  }
  return Mechanism::make(std::move(spec)).value();
}

Resources make_resources() {
  Resources r;
  r.mechanisms["m-tail"] = make_tail();
  return r;
}

Scenario make_scenario() {
  Scenario s;
  s.name = "tail";
  ScenarioCharacter c;
  c.id = c.name = "tail";
  c.mechanism = "m-tail";
  c.control.mode = ControlMode::passive;
  c.secondary = {{"tail", 2, 0.1, false}};
  s.characters = {c};
  ScenarioEvent push;
  push.id = "e1";
  push.time = 0.1;
  push.duration = 0.1;
  push.character = "tail";
  push.link = "rod3";
  push.force = {0, 0.02, 0.05};
  s.events = {push};
  return s;
}

Player open(const Scenario& scenario) {
  const auto bytes = generate(scenario, make_resources());
  EXPECT_TRUE(bytes) << (bytes ? "" : bytes.error().text());
  auto player = Player::open(*bytes);
  EXPECT_TRUE(player) << (player ? "" : player.error().text());
  return std::move(*player);
}

TEST(SecondaryMotion, TailSettlesLikeADampedOscillator) {
  for (const double frequency : {1.5, 3.0})
    for (const double damping : {0.05, 0.2}) {
      Scenario s = make_scenario();
      s.characters[0].secondary = {{"tail", frequency, damping, false}};
      Player player = open(s);
      std::vector<double> height, side;  // m: displacement of the tip
      const MechanismPtr m = make_tail();
      std::vector<Pose> X(static_cast<std::size_t>(m->link_count()));
      const int from = static_cast<int>((0.2 + 1 / frequency) / 0.002);  // higher modes decay within the first period
      for (int k = 0; k < from + static_cast<int>(4 / frequency / 0.002); ++k) {
        ASSERT_TRUE(player.step());
        if (k < from) continue;
        calc_poses(*m, player.q(0), X);
        height.push_back((X.back() * Vec3{0.1, 0, 0}).z - 1);
        side.push_back((X.back() * Vec3{0.1, 0, 0}).y);
      }
      for (const std::vector<double>& x : {height, side}) {
        // Fit of the closed form: x'' = -w^2 x - 2 z w x', by least squares over the recorded samples
        double xx = 0, xv = 0, vv = 0, xa = 0, va = 0;
        for (std::size_t i = 5; i + 5 < x.size(); ++i) {
          const double v = (x[i + 5] - x[i - 5]) / 0.02, a = (x[i + 5] - 2 * x[i] + x[i - 5]) / 1e-4;
          xx += x[i] * x[i];
          xv += x[i] * v;
          vv += v * v;
          xa += x[i] * a;
          va += v * a;
        }
        const double det = xx * vv - xv * xv, k = -(xa * vv - va * xv) / det, d = -(va * xx - xa * xv) / det;
        const double w = std::sqrt(k);
        EXPECT_NEAR(w / (2 * pi), frequency, 0.02 * frequency) << damping;
        EXPECT_NEAR(d / (2 * w), damping, 0.1 * damping) << frequency;
      }
    }
}

TEST(SecondaryMotion, RestsInTheStartPoseAtOnce) {
  Scenario s = make_scenario();
  s.events.clear();
  Player player = open(s);
  for (int k = 0; k < 500; ++k) ASSERT_TRUE(player.step());
  for (const double angle : player.q(0)) EXPECT_NEAR(angle, 0, 1e-9);
}

TEST(SecondaryMotion, IsPartOfTheDocument) {
  const Scenario s = make_scenario();
  const auto again = read_scenario(write_scenario(s), "tail.json");
  ASSERT_TRUE(again) << again.error().text();
  EXPECT_EQ(*again, s);
  const Catalogue catalogue = catalogue_of(make_resources());
  const auto problem = [&](const ScenarioSecondary& secondary) {
    Scenario wrong = s;
    wrong.characters[0].secondary = {secondary};
    const Error problems = check_scenario(wrong, &catalogue);
    return problems.empty() ? std::string() : problems.problems.front().location;
  };
  EXPECT_EQ(problem({"rod9", 2, 0.1, false}), "scenario/characters/0/secondary/0/link");
  EXPECT_EQ(problem({"tail", 100, 0.1, false}), "scenario/characters/0/secondary/0/frequency");
  EXPECT_EQ(problem({"tail", 2, -1, false}), "scenario/characters/0/secondary/0/damping");
  EXPECT_EQ(problem({"tail", 2, 0.1, true}), "");
  Scenario twice = s;
  twice.characters[0].secondary.push_back({"rod2", 2, 0.1, false});
  const auto refused = generate(twice, make_resources());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().problems.front().location, "character 'tail', link rod2");
}

}  // namespace
}  // namespace ugoki::content
