// Files with other axes, units or rates give the original motion if the axes, units and rates are specified.

#include "ugoki/intake/correction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

#include "ugoki/formats/bvh.h"
#include "ugoki/formats/trc.h"
#include "ugoki/intake/arrange.h"
#include "ugoki/intake/intake.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/samples/samples.h"

namespace ugoki::intake {
namespace {

TEST(Correction, AxesByName) {
  EXPECT_EQ(file_axis_named("x"), (FileAxis{0, false}));
  EXPECT_EQ(file_axis_named("-z"), (FileAxis{2, true}));
  for (const char* wrong : {"", "-", "w", "xy", "--x", "X"}) EXPECT_EQ(file_axis_named(wrong), std::nullopt) << wrong;
  for (const char* name : {"x", "-x", "y", "-y", "z", "-z"}) EXPECT_EQ(name_of(*file_axis_named(name)), name);
}

TEST(Correction, EveryOrientationIsARotationToOurAxes) {
  int valid = 0;
  for (int i = 0; i < 36; ++i) {
    const Orientation file{{i % 3, i / 3 % 2 == 1}, {i / 6 % 3, i / 18 == 1}};
    if (!file.valid()) continue;
    ++valid;
    Vec3 up, forward;
    up[file.up.axis] = file.up.negative ? -1 : 1;
    forward[file.forward.axis] = file.forward.negative ? -1 : 1;
    const Mat3 R = rotation_to_ours(file);
    EXPECT_EQ(R * up, (Vec3{0, 0, 1}));
    EXPECT_EQ(R * forward, (Vec3{1, 0, 0}));
    EXPECT_EQ(dot(cross(R.row(0), R.row(1)), R.row(2)), 1);
  }
  EXPECT_EQ(valid, 24);
}

/// Maximum distance [m], over all frames, between the same joint in two motions.
double max_distance(const MeasuredMotion& a, const MeasuredMotion& b) {
  std::vector<Pose> A(static_cast<std::size_t>(a.joint_count())), B(A.size());
  double worst = 0;
  for (int f = 0; f < a.frames; ++f) {
    a.calc_joint_poses(f, A);
    b.calc_joint_poses(f, B);
    for (std::size_t j = 0; j < A.size(); ++j) worst = std::max(worst, norm(A[j].p - B[j].p));
  }
  return worst;
}

/// The BVH writer writes the file with Z up; its conversion of axes is independent of the corrections.
TEST(Correction, FileWithZUpIsReadCorrectlyIfItsAxesAreSpecified) {
  const MeasuredMotion walk = samples::make_human_walk();
  formats::BvhWriteOptions z_up;
  z_up.z_up = true;
  z_up.metres_per_unit = 0.01;
  IntakeOptions options;
  options.axes = usual_orientation(true);
  options.unit = 0.01;
  const auto intake = take_in(formats::write_bvh(walk, z_up), "walk.bvh", nullptr, options);
  ASSERT_TRUE(intake) << intake.error().text();
  EXPECT_LT(max_distance(*intake->measured, walk), 1e-6);
  EXPECT_TRUE(intake->conversion.check.empty()) << intake->conversion.check.front();

  // Without axes, up follows from the posture of the character.
  options.axes.reset();
  const auto guessed = take_in(formats::write_bvh(walk, z_up), "walk.bvh", nullptr, options);
  ASSERT_TRUE(guessed) << guessed.error().text();
  EXPECT_EQ(guessed->axes, usual_orientation(true));
  EXPECT_LT(max_distance(*guessed->measured, walk), 1e-6);
  EXPECT_TRUE(std::ranges::any_of(guessed->conversion.guessed, [](const std::string& g) { return g.starts_with("Up is assumed"); }));
}

TEST(Correction, UnitAndRateOfTheOptionsAreUsed) {
  const MeasuredMotion walk = samples::make_human_walk();
  formats::BvhWriteOptions write;
  write.metres_per_unit = 0.0254;
  const std::string text = formats::write_bvh(walk, write);
  IntakeOptions options;
  options.unit = 2 * 0.0254;
  options.frame_rate = walk.rate / 2;
  const auto intake = take_in(text, "walk.bvh", nullptr, options);
  ASSERT_TRUE(intake) << intake.error().text();
  EXPECT_NEAR(intake->body->height, 2 * 1.75, 0.06);
  EXPECT_DOUBLE_EQ(intake->motion->rate, walk.rate / 2);
  EXPECT_EQ(intake->motion->frames, walk.frames);
  EXPECT_FALSE(intake->unit_guessed);
  EXPECT_NE(intake->conversion.check.front().find("unit of length"), std::string::npos);
}

// Many recordings have a root named "reference" that carries only the hips, which move relative to it.
TEST(Correction, CarrierRootIsRemoved) {
  const MeasuredMotion walk = samples::make_human_walk();
  MeasuredMotion carried = walk;
  SkeletonJoint carrier;
  carrier.name = "reference";
  carrier.translates = true;
  carrier.dofs = {{{0, 0, 1}}, {{1, 0, 0}}, {{0, 1, 0}}};
  carried.skeleton.joints.insert(carried.skeleton.joints.begin(), carrier);
  for (std::size_t i = 1; i < carried.skeleton.joints.size(); ++i) ++carried.skeleton.joints[i].parent;
  carried.skeleton.joints[1].translates = true;
  const std::size_t n = walk.skeleton.joints.size();
  for (std::size_t f = static_cast<std::size_t>(walk.frames); f-- > 0;) {
    const double turn = 0.5 + 0.01 * static_cast<double>(f);
    const Pose X{rotation_about({0, 0, 1}, turn), {1, 0.2 * turn, 0.1}};
    Vec3& p = carried.translations[f * n];
    Quat& q = carried.rotations[f * n];
    p = transpose_times(X.R, p - X.p);
    q = axis_angle({0, 0, 1}, -turn) * q;
    carried.translations.insert(carried.translations.begin() + static_cast<std::ptrdiff_t>(f * n), X.p);
    carried.rotations.insert(carried.rotations.begin() + static_cast<std::ptrdiff_t>(f * n), axis_angle({0, 0, 1}, turn));
  }
  IntakeOptions options;
  options.unit = 0.01;
  const auto intake = take_in(formats::write_bvh(carried, {.metres_per_unit = 0.01}), "walk.bvh", nullptr, options);
  ASSERT_TRUE(intake) << intake.error().text();
  EXPECT_EQ(intake->mechanism->links().front().joint.type, JointType::floating);
  EXPECT_EQ(intake->measured->skeleton.joints.front().name, walk.skeleton.joints.front().name);
  EXPECT_LT(max_distance(*intake->measured, walk), 1e-6);
  EXPECT_TRUE(std::any_of(intake->report.begin(), intake->report.end(),
                          [](const std::string& line) { return line.find("Joint reference only carries") != std::string::npos; }));
}

TEST(Correction, UpAndForwardMustDiffer) {
  IntakeOptions options;
  options.axes = Orientation{{1, false}, {1, true}};
  EXPECT_FALSE(take_in(formats::write_bvh(samples::make_human_walk()), "walk.bvh", nullptr, options));
}

TEST(Correction, SetRateKeepsEventsAndSamplesAtTheirFrames) {
  MarkerMotion m;
  m.labels = {"A"};
  m.rate = 100;
  m.frames = 11;
  m.analog_rate = 1000;
  m.analog = {{"Fz", "N", ""}};
  m.events = {{0.05, "Foot Strike", "Left"}};
  set_rate(m, 50);
  EXPECT_DOUBLE_EQ(m.duration(), 0.2);
  EXPECT_EQ(m.samples_per_frame(), 10);
  EXPECT_DOUBLE_EQ(m.events[0].time, 0.1);
}

TEST(Correction, MechanismIsTurnedUprightIfItsAxesAreSpecified) {
  const std::string lying =
      "<robot name='post'><link name='base'/><joint name='j' type='revolute'><parent link='base'/><child link='post'/>"
      "<axis xyz='1 0 0'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint>"
      "<link name='post'><inertial><origin xyz='0 1 0'/><mass value='3'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' "
      "iyz='0'/></inertial>"
      "<collision><origin xyz='0 1 0'/><geometry><sphere radius='0.1'/></geometry></collision></link></robot>";
  IntakeOptions options;
  options.axes = usual_orientation(false);
  const auto intake = take_in(lying, "post.urdf", nullptr, options);
  ASSERT_TRUE(intake) << intake.error().text();
  const Mechanism& m = *intake->mechanism;
  std::vector<Pose> X(static_cast<std::size_t>(m.link_count()));
  calc_poses(m, m.neutral(), X);
  const int post = m.link_count() - 1;
  const Vec3 ball = X[static_cast<std::size_t>(post)] * m.link(post).shapes.at(0).X_BS.p;
  EXPECT_NEAR(ball.z, 1, 1e-12);
  EXPECT_NEAR(std::hypot(ball.x, ball.y), 0, 1e-12);
}

TEST(Arrange, TheCharacterHasTheJointsThatRemainWithoutACarrier) {
  MeasuredMotion m;  // a creature of six limbs below a joint that carries it
  m.rate = 30;
  m.frames = 30;
  const auto add = [&](const std::string& name, int parent, const Vec3& offset) {
    SkeletonJoint j;
    j.name = name;
    j.parent = parent;
    j.offset = offset;
    j.translates = parent <= 0;
    m.skeleton.joints.push_back(j);
    return static_cast<int>(m.skeleton.joints.size()) - 1;
  };
  add("Armature", -1, {});
  const int body = add("body", 0, {0, 0, 1});
  const int chest = add("chest", body, {0.8, 0, 0});
  for (int pair = 0; pair < 3; ++pair)
    for (const double side : {1.0, -1.0}) {
      const int upper = add("u", pair == 2 ? chest : body, {pair == 1 ? 0.4 : 0.0, 0.2 * side, 0});
      add("f", add("l", upper, {0, 0.1 * side, -0.45}), {0, 0, -0.45});
    }
  add("top", add("head", add("neck", chest, {0.2, 0, 0.2}), {0.2, 0, 0.2}), {0.2, 0, 0});
  for (int f = 0; f < m.frames; ++f)
    for (const SkeletonJoint& j : m.skeleton.joints) {
      m.translations.push_back(j.offset + (j.parent == 0 ? Vec3{0.02 * f, 0, 0.01 * (f % 3)} : Vec3{}));
      m.rotations.push_back(j.parent <= 0 ? Quat{} : axis_angle({0, 1, 0}, 0.2 * std::sin(0.3 * f)));
    }
  std::vector<MeasuredMotion> motions = {m};
  std::vector<std::string> report;
  const body::Character c = arrange(motions, report);
  ASSERT_LT(motions[0].joint_count(), m.joint_count());
  EXPECT_EQ(c.parts.size(), static_cast<std::size_t>(motions[0].joint_count()));
}

}  // namespace
}  // namespace ugoki::intake
