#include "ugoki/motion_edit/intermediate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "characters.h"
#include "ugoki/motion_edit/edit.h"
#include "ugoki/motion_edit/mean_pose.h"
#include "ugoki/motion_edit/progression.h"
#include "ugoki/motion_edit/rounds.h"

namespace ugoki::motion_edit {
namespace {

/// Checks the properties of intermediate motions for several weights between two motions: cyclic, no sliding, monotone speed, exact ends.
void check_weights(const Mechanism& m, const Motion& a, const Motion& b, const std::string& name) {
  SCOPED_TRACE(name);
  const Motion* sources[] = {&a, &b};
  auto made = Intermediate::make(m, sources);
  ASSERT_TRUE(made) << made.error().text();
  const double from = made->facts(made->cycle(0)).speed, to = made->facts(made->cycle(1)).speed;
  double before = from;
  for (const double w : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    SCOPED_TRACE(w);
    const double weights[] = {1 - w, w};
    FootLockReport report;
    const Motion motion = made->blend(weights, &report).value();
    ASSERT_TRUE(check_motion(motion, m).empty());
    EXPECT_TRUE(motion.cyclic);
    // The motion is cyclic: the last frame equals the first frame, displaced by one cycle.
    std::vector<double> last(motion.frame(motion.frames - 1), motion.frame(motion.frames - 1) + motion.nq), d(at(m.nv()));
    displace_root(m, inverse(cycle_of(motion, m)), last);
    difference(m, {motion.frame(0), at(m.nq())}, last, d);
    for (const double x : d) EXPECT_LT(std::fabs(x), 1e-11);
    // No foot slides.
    const CycleFacts facts = made->facts(motion);
    EXPECT_LT(facts.skate.worst_cm, 1.0);
    EXPECT_LT(report.max_miss, 0.005) << report.miss_link << " in frame " << report.miss_frame;
    // The speed changes monotonically from one source to the other.
    if (w > 0) EXPECT_GT((facts.speed - before) * (to >= from ? 1 : -1), -1e-9);
    before = facts.speed;
    // At the weights 0 and 1 the result is exactly one of the sources.
    if (w == 0) EXPECT_EQ(motion.q, made->cycle(0).q);
    if (w == 1) EXPECT_EQ(motion.q, made->cycle(1).q);
  }
}

/// A hurried version of the walk: faster, with longer steps, and the root lowered by 20 mm so that knees bend more.
Motion hurried(const Mechanism& m, const Motion& walk) {
  Motion out = scale(m, walk, {.time = 0.8}).value();
  const Placement way = cycle_of(walk, m);
  for (int f = 0; f < out.frames; ++f) displace_root(m, {0.15 * way.x * f / (out.frames - 1), 0, -0.02, 0}, {out.frame(f), at(out.nq)});
  out.name = "hurried";
  out.contacts.clear();
  return out;
}

TEST(Intermediate, SampleWalksMixWithoutSliding) {
  const Character human = human_walk();
  check_weights(human.m(), human.motion, hurried(human.m(), human.motion), "human");
  const Character dog = dog_trot();
  check_weights(dog.m(), dog.motion, hurried(dog.m(), dog.motion), "dog");
}

TEST(Intermediate, MixingAMotionWithItselfGivesTheMotion) {
  const Character human = human_walk();
  const Motion* sources[] = {&human.motion, &human.motion};
  const Intermediate made = Intermediate::make(human.m(), sources).value();
  const double half[] = {0.5, 0.5};
  EXPECT_LT(max_difference(human.m(), made.blend(half).value(), made.cycle(0)), 0.02);
}

TEST(Intermediate, IsContinuousAtItsSources) {
  const Character human = human_walk();
  const Motion fast = hurried(human.m(), human.motion);
  const Motion* sources[] = {&human.motion, &fast};
  const Intermediate made = Intermediate::make(human.m(), sources).value();
  const double near[] = {0.999, 0.001};
  EXPECT_LT(max_difference(human.m(), made.blend(near).value(), made.cycle(0)), 0.03);
}

TEST(Intermediate, StartPhaseHasNoEffect) {
  // The walk that starts a third of a cycle later must be aligned with the original walk.
  const Character human = human_walk();
  const Motion walk = unrolled(human.m(), human.motion, 2);
  Motion later = trim(walk, human.motion.frames / 3, human.motion.frames / 3 + human.motion.frames - 1).value();
  later.cyclic = true;
  const Motion* sources[] = {&human.motion, &later};
  const Intermediate made = Intermediate::make(human.m(), sources).value();
  const double half[] = {0.5, 0.5};
  const Motion mixed = made.blend(half).value();
  // Compare the speed and the vertical range of the pelvis, which do not depend on the start phase.
  const CycleFacts facts = made.facts(mixed);
  EXPECT_NEAR(facts.speed, made.facts(made.cycle(0)).speed, 1e-3);
  EXPECT_LT(facts.skate.worst_cm, 0.5);
  double low = 1e9, high = -1e9, low0 = 1e9, high0 = -1e9;
  for (int f = 0; f < mixed.frames; ++f) {
    low = std::min(low, mixed.frame(f)[2]);
    high = std::max(high, mixed.frame(f)[2]);
  }
  for (int f = 0; f < made.cycle(0).frames; ++f) {
    low0 = std::min(low0, made.cycle(0).frame(f)[2]);
    high0 = std::max(high0, made.cycle(0).frame(f)[2]);
  }
  EXPECT_NEAR(high - low, high0 - low0, 0.005);  // opposite phases would flatten the rise and fall of the pelvis
}

TEST(Intermediate, MixtureOfThreeHasMeanDuration) {
  const Character human = human_walk();
  const Motion fast = hurried(human.m(), human.motion), faster = hurried(human.m(), fast);
  const Motion* sources[] = {&human.motion, &fast, &faster};
  const Intermediate made = Intermediate::make(human.m(), sources).value();
  const double weights[] = {2, 1, 1};
  const CycleFacts facts = made.facts(made.blend(weights).value());
  double duration = 0;
  for (int i = 0; i < 3; ++i) duration += (i == 0 ? 0.5 : 0.25) * made.facts(made.cycle(i)).duration;
  EXPECT_NEAR(facts.duration, duration, 0.5 / human.motion.rate + 1e-9);
  EXPECT_LT(facts.skate.worst_cm, 1.0);
  EXPECT_GT(facts.speed, made.facts(made.cycle(0)).speed);
  EXPECT_LT(facts.speed, made.facts(made.cycle(2)).speed);
}

TEST(Intermediate, BadWeightsAndMotionsAreRefused) {
  const Character human = human_walk(), dog = dog_trot();
  const Motion* sources[] = {&human.motion, &dog.motion};
  const auto wrong = Intermediate::make(human.m(), sources);
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().text().find("coordinates"), std::string::npos);
  const Motion* one[] = {&human.motion};
  const Intermediate made = Intermediate::make(human.m(), one).value();
  for (const std::vector<double>& w : {std::vector<double>{}, {0.0}, {-1.0}, {NAN}, {0.5, 0.5}}) EXPECT_FALSE(made.blend(w));
  EXPECT_FALSE(Intermediate::make(human.m(), {}));
}

TEST(Intermediate, RecordedWalkAndRunMixWithoutSliding) {
  if (!has_recordings()) GTEST_SKIP() << "the shared data is absent";
  const MeasuredMotion walk = read_recording("02", "02_01"), run = read_recording("02", "02_03");
  const body::Body body = body::make_body(walk, {.keep_unmoved = true}).value();
  check_weights(*body.mechanism, body::to_motion(body, walk), body::to_motion(body, run), "02_01 and 02_03");
}

TEST(MeanPose, MeanOfTwoRotationsIsOnTheGreatArc) {
  const Quat a = exp_map({0.3, -1.2, 0.5}), b = exp_map({-0.7, 0.4, 1.1});
  for (const double t : {0.1, 0.5, 0.8}) {
    const Quat rotations[] = {a, b};
    const double weights[] = {1 - t, t};
    EXPECT_LT(norm(log_map(calc_mean(rotations, weights).conjugate() * slerp(a, b, t))), 1e-12) << t;
  }
  // For three rotations, the weighted rotation vectors from the mean to all of them sum to zero.
  const Quat c = exp_map({0.2, 0.1, -0.4});
  const Quat three[] = {a, b, c};
  const double weights[] = {0.5, 0.2, 0.3};
  const Quat mean = calc_mean(three, weights);
  Vec3 sum;
  for (int i = 0; i < 3; ++i) sum += log_map(mean.conjugate() * three[i]) * weights[i];
  EXPECT_LT(norm(sum), 1e-12);
}

}  // namespace
}  // namespace ugoki::motion_edit
