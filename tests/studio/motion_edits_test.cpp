// Tests of operations on the motions of clips: compare the motion that the clip shows before and after the operation.
#include "ugoki/studio/motion_edits.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "ugoki/mechanism/state.h"
#include "ugoki/motion/clip.h"
#include "ugoki/motion_edit/foot_contacts.h"
#include "ugoki/motion_edit/root_path.h"
#include "ugoki/samples/samples.h"

namespace ugoki::studio {
namespace {

using json::Json;

/// The sample's walk (one cyclic stride) and stand, on the sample's human.
struct Cast {
  samples::Sample sample = samples::make_sample();
  MechanismPtr human = sample.resources.mechanisms.at("human");
  MotionPtr walk = sample.resources.motions.at("human-walk"), stand = sample.resources.motions.at("human-stand");
};
const Cast& cast() {
  static const Cast only;
  return only;
}

MotionEdit make_edit(const std::string& operation, Json options = Json::object(), double offset = 0, double length = 0, double speed = 1,
                     bool loop = false) {
  MotionEdit edit;
  edit.operation = operation;
  edit.options = std::move(options);
  edit.mechanism = cast().human;
  edit.target.motion = cast().walk;
  edit.target.clip.id = "k1";
  edit.target.clip.start = 1;
  edit.target.clip.offset = offset;
  edit.target.clip.speed = speed;
  edit.target.clip.loop = loop;
  edit.target.clip.length = length > 0 ? length : cast().walk->duration() / speed;
  return edit;
}

EditedMotion run(const MotionEdit& edit) {
  Result<EditedMotion> made = edit_motion(edit);
  EXPECT_TRUE(made) << edit.operation << ": " << (made ? "" : made.error().text());
  if (!made) return {};
  EXPECT_EQ(check_motion(made->motion, *cast().human).text(), "") << edit.operation;
  EXPECT_FALSE(made->label.empty());
  EXPECT_GT(made->clip.length, 0);
  if (!made->clip.loop)
    EXPECT_LE(made->clip.offset + made->clip.length * made->clip.speed, made->motion.duration() + 1e-9) << edit.operation;
  return std::move(*made);
}

/// The motion that the clip shows after an operation.
Motion shown(const EditedMotion& made) {
  return bake_clip(*cast().human, {made.clip, std::make_shared<const Motion>(made.motion)}).value();
}
/// The motion that the clip shows before the operation.
Motion shown(const MotionEdit& edit) { return bake_clip(*edit.mechanism, edit.target).value(); }

double max_difference(const Motion& a, const Motion& b, bool backwards = false) {
  EXPECT_EQ(a.frames, b.frames);
  double difference = 0;
  for (int f = 0; f < std::min(a.frames, b.frames); ++f)
    for (int k = 0; k < a.nq; ++k)
      difference = std::max(difference, std::fabs(a.frame(f)[k] - b.frame(backwards ? b.frames - 1 - f : f)[k]));
  return difference;
}

/// Direction of the root's path at its end or start, rad about Z.
double direction(const Motion& motion, bool end) {
  const std::vector<motion_edit::PathPoint> path = motion_edit::root_path(*cast().human, motion);
  const std::size_t reach = path.size() / 8, from = end ? path.size() - 1 - reach : 0;
  return std::atan2(path[from + reach].y - path[from].y, path[from + reach].x - path[from].x);
}

/// Index of the link with this label.
std::size_t labelled(const std::string& label) {
  for (int i = 0; i < cast().human->link_count(); ++i)
    if (cast().human->link(i).label == label) return static_cast<std::size_t>(i);
  ADD_FAILURE() << "no link labelled " << label;
  return 0;
}

/// An operation on three consecutive strides of the walk.
MotionEdit long_walk(const std::string& operation, Json options = Json::object()) {
  MotionEdit edit = make_edit("trim", Json::object(), 0, 3 * cast().walk->duration(), 1, true);
  const EditedMotion strides = run(edit);
  edit.operation = operation;
  edit.options = std::move(options);
  edit.target.motion = std::make_shared<const Motion>(strides.motion);
  edit.target.clip = strides.clip;
  return edit;
}

TEST(MotionEdits, CorrectionRemovesSlidingAndStrengthScalesIt) {
  MotionEdit edit = make_edit("correct", {{"percent", 100}});
  Motion sliding = *cast().walk;  // the root moves 10 % slower than the steps, so that standing feet slide
  for (int f = 0; f < sliding.frames; ++f) sliding.frame(f)[0] -= 0.1 * (cast().walk->frame(f)[0] - cast().walk->frame(0)[0]);
  sliding.cyclic = false;
  edit.target.motion = std::make_shared<const Motion>(sliding);
  const EditedMotion all = run(edit);
  EXPECT_EQ(all.label, "Correct the physics");
  const auto slide = std::ranges::find_if(all.report, [](const std::string& line) { return line.starts_with("Sliding"); });
  ASSERT_NE(slide, all.report.end());
  double before = 0, after = 0;
  ASSERT_EQ(std::sscanf(slide->c_str(), "Sliding of standing feet: %lf cm before, %lf cm after", &before, &after), 2) << *slide;
  EXPECT_GT(before, 1) << "cm";
  EXPECT_LT(after, 0.2 * before) << "cm";
  edit.options = {{"percent", 0}};
  EXPECT_LT(max_difference(run(edit).motion, sliding), 1e-9) << "strength 0 keeps the motion";
  edit.options = {{"percent", 101}};
  EXPECT_FALSE(edit_motion(edit));
}

TEST(MotionEdits, TrimKeepsShownMotion) {
  for (const MotionEdit& edit :
       {make_edit("trim", Json::object(), 0.25, 0.4, 1.5), make_edit("trim", Json::object(), 0.3, 3.1, 0.8, true)}) {
    const EditedMotion made = run(edit);
    EXPECT_EQ(made.clip.offset, 0);
    EXPECT_FALSE(made.clip.loop);
    EXPECT_NEAR(made.clip.length, edit.target.clip.length, 1 / made.motion.rate);
    EXPECT_EQ(max_difference(made.motion, shown(edit)), 0);
    EXPECT_LT(max_difference(shown(made), shown(edit)), 1e-12);
  }
}

TEST(MotionEdits, TrimKeepsFramesOfTheClip) {
  const Motion& walk = *cast().walk;
  const int first = walk.frames / 4, count = walk.frames / 3;
  const EditedMotion made = run(make_edit("trim", Json::object(), first / walk.rate, count / walk.rate));
  EXPECT_NEAR(made.motion.frames, count + 1, 1);
  for (int f = 0; f < count; ++f)
    for (int k = 0; k < walk.nq; ++k) EXPECT_NEAR(made.motion.frame(f)[k], walk.frame(first + f)[k], 1e-9) << f;
}

TEST(MotionEdits, ReverseShowsTheSameSectionBackwards) {
  MotionEdit edit = make_edit("reverse", Json::object(), 0.25, 0.5);
  const EditedMotion made = run(edit);
  EXPECT_NE(made.clip.offset, edit.target.clip.offset);
  EXPECT_LT(max_difference(shown(made), shown(edit), true), 1e-9);
}

TEST(MotionEdits, MirrorTwiceRestoresTheMotion) {
  MotionEdit edit = make_edit("mirror");
  const EditedMotion once = run(edit);
  EXPECT_GT(max_difference(once.motion, *edit.target.motion), 0.1);
  // The left foot of the mirrored motion has the height of the right foot of the original at the same frame.
  std::vector<Pose> X(static_cast<std::size_t>(cast().human->link_count())), Y(X.size());
  for (int f = 0; f < once.motion.frames; ++f) {
    calc_poses(*cast().human, std::span(once.motion.frame(f), static_cast<std::size_t>(once.motion.nq)), X);
    calc_poses(*cast().human, std::span(cast().walk->frame(f), static_cast<std::size_t>(once.motion.nq)), Y);
    EXPECT_NEAR(X[labelled("foot left")].p.z, Y[labelled("foot right")].p.z, 1e-6) << f;
  }
  EXPECT_EQ(once.motion.name, cast().walk->name + ", mirrored");
  edit.target.motion = std::make_shared<const Motion>(once.motion);
  const EditedMotion twice = run(edit);
  EXPECT_LT(max_difference(twice.motion, *cast().walk), 1e-9);
  EXPECT_EQ(twice.motion.name, cast().walk->name);
}

TEST(MotionEdits, WarpAppliesRequestedSpeeds) {
  const MotionEdit same = make_edit("warp", {{"speeds", {100, 100, 100}}}, 0.1, 0.8);
  EXPECT_LT(max_difference(shown(run(same)), shown(same)), 2e-3);
  // The speed v rises linearly from 50 to 100 per cent along the motion of length T = 0.8 s. The new length is the integral of ds / v over
  // the motion: T ln 2 / 0.5.
  const MotionEdit rising = make_edit("warp", {{"speeds", {50, 100}}}, 0.1, 0.8);
  EXPECT_NEAR(run(rising).clip.length, 0.8 * std::log(2) / 0.5, 0.02);
}

TEST(MotionEdits, PathTurnsByRequestedAngle) {
  for (const double turn : {90.0, -150.0, 360.0}) {
    const EditedMotion made = run(long_walk("path", {{"shape", "turn"}, {"turn", turn}}));
    const double turned = direction(made.motion, true) - direction(made.motion, false);
    EXPECT_NEAR(std::remainder(turned - turn * std::numbers::pi / 180, 2 * std::numbers::pi), 0, std::fabs(turn) * 0.004) << turn;
  }
}

TEST(MotionEdits, PathEndsAtRequestedPoint) {
  const MotionEdit edit = long_walk("path", {{"shape", "to"}, {"forward", 3.0}, {"left", -2.0}});
  const double heading = direction(*edit.target.motion, false);
  const EditedMotion made = run(edit);
  const std::vector<motion_edit::PathPoint> path = motion_edit::root_path(*cast().human, made.motion);
  const double x = path.back().x - path.front().x, y = path.back().y - path.front().y;
  EXPECT_NEAR(x * std::cos(heading) + y * std::sin(heading), 3, 0.1);
  EXPECT_NEAR(y * std::cos(heading) - x * std::sin(heading), -2, 0.1);
}

TEST(MotionEdits, ScaledPathKeepsFeetFromSliding) {
  const MotionEdit edit = long_walk("scale", {{"way", 1.15}, {"time", 1.1}});
  const EditedMotion made = run(edit);
  const Placement before = cycle_of(*edit.target.motion, *cast().human), after = cycle_of(made.motion, *cast().human);
  EXPECT_NEAR(std::hypot(after.x, after.y), 1.15 * std::hypot(before.x, before.y), 0.02);
  EXPECT_NEAR(made.clip.length, 1.1 * edit.target.clip.length, 0.02);
  const motion_edit::FootContacts contacts =
      motion_edit::labelled_contacts(*cast().human, made.motion, motion_edit::find_foot_limbs(*cast().human));
  EXPECT_LT(motion_edit::measure_skate(*cast().human, made.motion, contacts).worst_cm, 1);
}

TEST(MotionEdits, JoinBlendsOverTheOverlap) {
  MotionEdit edit = make_edit("join");
  edit.next.motion = cast().stand;
  edit.next.clip.id = "k2";
  edit.next.clip.start = edit.target.clip.start + edit.target.clip.length - 0.25;
  edit.next.clip.length = 2;
  const EditedMotion made = run(edit);
  EXPECT_NEAR(made.clip.length, edit.target.clip.length + 2 - 0.25, 0.02);
  edit.next.motion = nullptr;
  EXPECT_FALSE(edit_motion(edit)) << "join without a next clip must be rejected";
}

TEST(MotionEdits, BlendAt0And100PercentHasTheMotionsSpeeds) {
  // The second motion is the same walk at half the frame rate, so at half the speed.
  MotionEdit edit = make_edit("blend", {{"percent", 0}});
  Motion slow = *cast().walk;
  slow.name = "slow";
  slow.rate *= 0.5;
  edit.other = std::make_shared<const Motion>(slow);
  edit.other_mechanism = cast().human;
  const auto speed = [&](double percent) {
    edit.options = {{"percent", percent}};
    const EditedMotion made = run(edit);
    EXPECT_TRUE(made.clip.loop);
    EXPECT_TRUE(made.motion.cyclic);
    const Placement stride = cycle_of(made.motion, *cast().human);
    return std::hypot(stride.x, stride.y) / made.motion.duration();
  };
  const double fast = speed(0), end = speed(100), middle = speed(50);
  EXPECT_NEAR(end, fast / 2, 0.02 * fast);
  EXPECT_LT(middle, fast);
  EXPECT_GT(middle, end);
}

TEST(MotionEdits, MixAndLayerWithWeight0ChangeNothing) {
  for (const char* operation : {"mix", "layer"}) {
    MotionEdit edit = make_edit(operation, {{"joints", Json::array()}, {"weight", 0.0}});
    edit.other = cast().stand;
    edit.other_mechanism = cast().human;
    EXPECT_LT(max_difference(run(edit).motion, *cast().walk), 1e-9) << "weight 0 must not change the motion";
    edit.options = {{"weight", 1.0}, {"joints", {"no such link"}}};
    EXPECT_FALSE(edit_motion(edit));
  }
}

TEST(MotionEdits, MixStartsAtRequestedTime) {
  constexpr int delay = 20;  // frames
  MotionEdit edit = make_edit("mix", {{"joints", {"upper arm left"}}, {"fade", 0.0}, {"at", delay / cast().walk->rate}});
  edit.other = cast().stand;
  edit.other_mechanism = cast().human;
  ASSERT_EQ(cast().stand->rate, cast().walk->rate);
  const Motion mixed = run(edit).motion;
  const Link& arm = cast().human->link(static_cast<int>(labelled("upper arm left")));
  const Motion &walk = *cast().walk, &stand = *cast().stand;
  ASSERT_TRUE(stand.cyclic || stand.frames > walk.frames);
  for (int f = 0; f < mixed.frames; ++f) {
    if (f == delay) continue;
    const double* from = f < delay ? walk.frame(f) : stand.frame((f - delay) % (stand.frames - 1));
    for (int k = 0; k < arm.joint.nq(); ++k) EXPECT_NEAR(mixed.frame(f)[arm.q_index + k], from[arm.q_index + k], 1e-6) << f;
    for (int k = 0; k < 7; ++k) EXPECT_EQ(mixed.frame(f)[k], walk.frame(f)[k]);
  }
}

TEST(MotionEdits, RetargetedMotionFitsTheOtherBody) {
  MotionEdit edit = make_edit("retarget", Json::object(), 0, 2, 1, true);
  edit.body = samples::make_person(1.1).value();
  const Result<EditedMotion> made = edit_motion(edit);
  ASSERT_TRUE(made) << made.error().text();
  EXPECT_EQ(check_motion(made->motion, *edit.body).text(), "");
  EXPECT_GT(made->report.size(), 1u);
}

TEST(MotionEdits, OtherOperationsGiveValidMotions) {
  for (const auto& [operation, options] : {std::pair<const char*, Json>("cycle", Json::object()),
                                           {"resample", {{"rate", 30}}},
                                           {"contacts", Json::object()},
                                           {"lock", Json::object()},
                                           {"reduce", {{"degrees", 1.0}}}}) {
    const EditedMotion made = run(make_edit(operation, options));
    EXPECT_FALSE(made.report.empty()) << operation;
  }
  MotionEdit bare = make_edit("contacts");
  Motion without = *bare.target.motion;
  without.contacts.clear();
  bare.target.motion = std::make_shared<const Motion>(std::move(without));
  EXPECT_FALSE(run(bare).motion.contacts.empty());
  EXPECT_NEAR(run(make_edit("resample", {{"rate", 30}})).motion.rate, 30, 1);
}

TEST(MotionEdits, InvalidOptionsAreRejectedWithRemedy) {
  const std::pair<const char*, Json> wrong[] = {
      {"nonsense", Json::object()},     {"mirror", {{"unknown", 1}}},  {"mirror", Json::array()},
      {"warp", Json::object()},         {"warp", {{"speeds", {100}}}}, {"warp", {{"speeds", {100, "x"}}}},
      {"warp", {{"speeds", {100, 0}}}}, {"resample", Json::object()},  {"resample", {{"rate", -1}}},
      {"scale", {{"way", 0}}},          {"scale", {{"time", 1e9}}},    {"path", Json::object()},
      {"path", {{"shape", "spiral"}}},  {"path", {{"shape", "to"}}},   {"path", {{"shape", "turn"}, {"turn", 1e9}}},
      {"lock", {{"ease", -1}}},         {"reduce", {{"degrees", 0}}}};
  for (const auto& [operation, options] : wrong) {
    const Result<EditedMotion> made = edit_motion(make_edit(operation, options));
    ASSERT_FALSE(made) << operation << " " << json::to_text(options);
    EXPECT_FALSE(made.error().problems.front().message.empty());
    EXPECT_FALSE(made.error().problems.front().remedy.empty()) << operation << " " << json::to_text(options);
  }
}

}  // namespace
}  // namespace ugoki::studio
