#include "ugoki/motion_edit/keyed_layer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "characters.h"

namespace ugoki::motion_edit {
namespace {

LayerKey key(double time, double value, Tangent tangent = Tangent::smooth) { return {time, {value, 0, 0}, tangent, {}, {}}; }

int link_labelled(const Mechanism& m, const std::string& label) {
  for (int i = 0; i < m.link_count(); ++i)
    if (m.link(i).label == label) return i;
  return -1;
}

TEST(KeyedLayer, CurvePassesThroughItsKeysAndIsConstantOutside) {
  const std::vector<LayerKey> keys = {key(0.5, 1), key(1, 3), key(2, 2, Tangent::linear), key(2.5, 2.5)};
  for (const LayerKey& k : keys) EXPECT_DOUBLE_EQ(value_at(keys, k.time)[0], k.value[0]);
  EXPECT_DOUBLE_EQ(value_at(keys, 0)[0], 1);
  EXPECT_DOUBLE_EQ(value_at(keys, 9)[0], 2.5);
  EXPECT_EQ(value_at({}, 1)[0], 0);
}

TEST(KeyedLayer, SmoothCurveStaysBetweenItsKeys) {
  std::mt19937 random(20261124);
  for (int round = 0; round < 200; ++round) {
    std::vector<LayerKey> keys;
    double t = 0;
    for (int i = 0; i < 6; ++i) {
      t += 0.02 + (random() % 1000) / 1000.0;
      keys.push_back(key(t, (random() % 2001) / 1000.0 - 1));
    }
    for (std::size_t i = 0; i + 1 < keys.size(); ++i)
      for (int k = 0; k <= 20; ++k) {
        const double s = keys[i].time + (keys[i + 1].time - keys[i].time) * k / 20, x = value_at(keys, s)[0];
        EXPECT_GE(x, std::min(keys[i].value[0], keys[i + 1].value[0]) - 1e-12);
        EXPECT_LE(x, std::max(keys[i].value[0], keys[i + 1].value[0]) + 1e-12);
      }
  }
}

TEST(KeyedLayer, LinearStepAndFreeTangentsHaveTheirClosedForms) {
  EXPECT_DOUBLE_EQ(value_at(std::vector{key(0, 1, Tangent::linear), key(2, 5, Tangent::linear)}, 0.5)[0], 2);
  EXPECT_DOUBLE_EQ(value_at(std::vector{key(0, 1, Tangent::step), key(2, 5)}, 1.999)[0], 1);
  // With the slopes of a cubic polynomial, Hermite interpolation is exact: p(t) = 1 + 2 t - t^2 + t^3.
  const auto p = [](double t) { return 1 + 2 * t - t * t + t * t * t; };
  const auto dp = [](double t) { return 2 - 2 * t + 3 * t * t; };
  std::vector<LayerKey> keys = {key(-1, p(-1), Tangent::free), key(0.5, p(0.5), Tangent::free), key(2, p(2), Tangent::free)};
  for (LayerKey& k : keys) k.slope_in[0] = k.slope_out[0] = dp(k.time);
  for (double t = -1; t <= 2; t += 0.01) EXPECT_NEAR(value_at(keys, t)[0], p(t), 1e-12);
}

TEST(KeyedLayer, FadesInBeforeTheFirstKeyAndOutAfterTheLast) {
  KeyedLayer layer;
  layer.weight = 0.5;
  layer.ease_in = 0.4;
  layer.ease_out = 0.2;
  EXPECT_EQ(layer.weight_at(1), 0) << "no keys";
  layer.joints = {{"a", JointPart::whole, 1, {key(1, 1)}}, {"b", JointPart::whole, 1, {key(2, 1)}}};
  EXPECT_DOUBLE_EQ(layer.weight_at(1), 0.5);
  EXPECT_DOUBLE_EQ(layer.weight_at(1.7), 0.5);
  EXPECT_DOUBLE_EQ(layer.weight_at(0.8), 0.25) << "half of the fade";
  EXPECT_EQ(layer.weight_at(0.6), 0);
  EXPECT_NEAR(layer.weight_at(2.1), 0.25, 1e-12);
  EXPECT_EQ(layer.weight_at(2.3), 0);
  layer.ease_in = layer.ease_out = -1;
  EXPECT_DOUBLE_EQ(layer.weight_at(0), 0.5);
  EXPECT_DOUBLE_EQ(layer.weight_at(99), 0.5);
  layer.ease_in = 0;
  EXPECT_EQ(layer.weight_at(0.999), 0);
}

TEST(KeyedLayer, LoopedMotionHasNoJumpAtItsEnd) {
  const Character dog = dog_trot();
  int hinge = -1;
  for (int i = 0; i < dog.m().link_count(); ++i)
    if (dog.m().link(i).joint.type == JointType::revolute) hinge = i;
  ASSERT_GE(hinge, 0);
  const double T = dog.motion.duration();
  for (const auto& [in, out] : {std::pair{0.1, 0.1}, {-1.0, -1.0}, {0.1, -1.0}, {-1.0, 0.05}, {5.0, 5.0}})
    for (const double last : {0.5 * T, T - 0.02}) {
      KeyedLayer layer;
      layer.ease_in = in;
      layer.ease_out = out;
      layer.joints = {{dog.m().link(hinge).name, JointPart::whole, 1, {key(0.3 * T, 0.4), key(last, 0.9)}}};
      const Motion made = apply_layers(dog.m(), dog.motion, std::vector{layer}, true).value();
      const int at_hinge = dog.m().link(hinge).q_index;
      const auto added = [&](int f) { return made.frame(f)[at_hinge] - dog.motion.frame(f)[at_hinge]; };
      EXPECT_NEAR(added(0), added(made.frames - 1), 1e-12) << in << " " << out << " " << last;
      EXPECT_NEAR(layer.weight_at(last, T), 1, 1e-12);
      // the value changes continuously: refining the times reduces the largest change
      const auto largest = [&](int count) {
        double change = 0, before = 0;
        for (int i = 0; i <= count; ++i) {
          const LayerMoment moment = moment_of(layer, i * T / count, T);
          const auto& keys = layer.joints[0].keys;
          const double now =
              moment.weight * (value_at(keys, moment.from)[0] * (1 - moment.mix) + value_at(keys, moment.to)[0] * moment.mix);
          if (i > 0) change = std::max(change, std::fabs(now - before));
          before = now;
        }
        return change;
      };
      EXPECT_LT(largest(40'000), 0.002) << in << " " << out << " " << last;
    }
}

TEST(KeyedLayer, AdditiveKeyOfAHingeAddsItsAngle) {
  const Character dog = dog_trot();
  int hinge = -1;
  for (int i = 0; i < dog.m().link_count(); ++i)
    if (dog.m().link(i).joint.type == JointType::revolute) hinge = i;
  ASSERT_GE(hinge, 0);
  KeyedLayer layer;
  layer.joints = {
      {dog.m().link(hinge).name, JointPart::whole, 1, {key(0, 0.1, Tangent::linear), key(dog.motion.duration(), 0.3, Tangent::linear)}}};
  const Motion out = apply_layers(dog.m(), dog.motion, std::vector{layer}).value();
  for (int f = 0; f < out.frames; ++f)
    for (int k = 0; k < out.nq; ++k) {
      const double added = k == dog.m().link(hinge).q_index ? 0.1 + 0.2 * f / (out.frames - 1) : 0;
      EXPECT_NEAR(out.frame(f)[k], dog.motion.frame(f)[k] + added, 1e-12);
    }
}

/// For every kind of joint part and both modes: the key computed by key_value() leads the motion exactly to the wanted pose.
TEST(KeyedLayer, KeyValueLeadsToTheWantedPoseAndRemoveIsTheInverse) {
  const Character human = human_walk();
  const Mechanism& m = human.m();
  std::mt19937 random(20261125);
  std::normal_distribution<double> normal;
  const double t = 0.25;
  std::vector<double> below(at(m.nq())), wanted(below), v(at(m.nv()));
  sample(human.motion, m, t, below);
  for (double& x : v) x = 0.2 * normal(random);
  integrate(m, below, v, 1, wanted);
  for (const LayerMode mode : {LayerMode::additive, LayerMode::replace})
    for (const double weight : {1.0, 0.6}) {
      KeyedLayer layer;
      layer.mode = mode;
      layer.weight = weight;
      for (int i = 0; i < m.link_count(); ++i) {
        const Link& link = m.link(i);
        for (const JointPart part : {JointPart::whole, JointPart::rotation, JointPart::position}) {
          const int count = component_count(link.joint.type, part);
          if (count == 0) continue;
          LayerKey k = key(t, 0);
          k.value = key_value(link.joint, part, mode, weight, below.data() + link.q_index, wanted.data() + link.q_index);
          layer.joints.push_back({link.name, part, count, {k}});
        }
      }
      std::vector<double> q = below, d(at(m.nv()));
      apply_layer(m, layer, t, q);
      difference(m, wanted, q, d);
      for (const double x : d) EXPECT_NEAR(x, 0, 1e-9) << static_cast<int>(mode) << " " << weight;
      const bool invertible = remove_layer(m, layer, t, q);
      EXPECT_EQ(invertible, mode == LayerMode::additive || weight < 1);
      if (!invertible) continue;
      difference(m, below, q, d);
      for (const double x : d) EXPECT_NEAR(x, 0, 1e-8);
    }
}

TEST(KeyedLayer, ReplacingLayerOfHalfWeightIsTheMeanRotation) {
  const Character human = human_walk();
  const Mechanism& m = human.m();
  const int arm = link_labelled(m, "upper arm left");
  ASSERT_GT(arm, 0);
  KeyedLayer layer;
  layer.mode = LayerMode::replace;
  layer.weight = 0.5;
  layer.joints = {{m.link(arm).name, JointPart::whole, 3, {{0, {0.4, -0.3, 0.2}, Tangent::smooth, {}, {}}}}};
  const Motion out = apply_layers(m, human.motion, std::vector{layer}).value();
  const Quat goal = exp_map({0.4, -0.3, 0.2});
  for (int f = 0; f < out.frames; f += 7) {
    const double* a = human.motion.frame(f) + m.link(arm).q_index;
    const double* b = out.frame(f) + m.link(arm).q_index;
    const Quat mean = slerp({a[0], a[1], a[2], a[3]}, goal, 0.5);
    EXPECT_NEAR(std::fabs(mean.w * b[0] + mean.x * b[1] + mean.y * b[2] + mean.z * b[3]), 1, 1e-12);
  }
}

TEST(KeyedLayer, RefusesUnknownLinksPartsAndUnsortedKeys) {
  const Character human = human_walk();
  KeyedLayer layer;
  layer.joints = {{"no such link", JointPart::whole, 1, {key(0, 0)}},
                  {human.m().link(0).name, JointPart::whole, 3, {key(0, 0)}},
                  {human.m().link(0).name, JointPart::position, 3, {key(1, 0), key(0.5, 0)}}};
  const auto out = apply_layers(human.m(), human.motion, std::vector{layer});
  ASSERT_FALSE(out);
  ASSERT_EQ(out.error().problems.size(), 3u);
  EXPECT_EQ(out.error().problems[0].code, ErrorCode::unknown);
  EXPECT_EQ(out.error().problems[1].code, ErrorCode::structure);
  for (const Problem& p : out.error().problems) EXPECT_FALSE(p.remedy.empty());
}

}  // namespace
}  // namespace ugoki::motion_edit
