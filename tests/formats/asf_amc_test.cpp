// ASF and AMC: skeletons and poses against closed forms, and variants of the formats.
#include "ugoki/formats/asf.h"

#include "expect.h"

namespace ugoki::formats {
namespace {

constexpr double degree = pi / 180;

const std::string units =
    ":version 1.10\n:name character\n:units\n  mass 2.0\n  length 0.5\n  angle deg\n:documentation\n  any (text) :here\n";
const std::string root = ":root\n  order TX TY TZ RX RY RZ\n  axis XYZ\n  position 0 0 0\n  orientation 0 0 0\n";
const std::string two_bones =
    ":bonedata\n  begin\n    id 2\n    name shin # lower\n    direction 0 -1 0\n    length 3\n    axis 0 0 90 XYZ\n    dof rx\n    limits "
    "(-10.0 170.0)\n    bodymass 4\n  end\n"
    "  begin\n    id 1\n    name thigh\n    direction 0 -1 0\n    length 4\n    axis 0 0 0 XYZ\n    dof rx ry rz\n    limits (-160.0 "
    "20.0)\n           (-inf inf)\n           (-70\n 60)\n    cofmass 0.5\n    bodymass 6\n  end\n";
const std::string tree = ":hierarchy\n  begin\n    root thigh\n    thigh shin\n  end\n";

Asf read(const std::string& text, const AsfOptions& options = {}) {
  auto asf = read_asf(text, "one.asf", options);
  EXPECT_TRUE(asf.has_value()) << (asf ? std::string() : text_of(asf.error()));
  return asf ? std::move(*asf) : Asf{};
}
MeasuredMotion read_motion(const std::string& text, const Asf& asf, ReadNotes* notes = nullptr) {
  auto motion = read_amc(text, "one_01.amc", asf, {}, notes);
  EXPECT_TRUE(motion.has_value()) << (motion ? std::string() : text_of(motion.error()));
  return motion ? std::move(*motion) : MeasuredMotion{};
}

TEST(AsfReader, JointIsAtTheStartOfItsBone) {
  const Asf asf = read(units + root + two_bones + tree);
  const Skeleton& s = asf.skeleton;
  ASSERT_EQ(s.joints.size(), 3U);
  EXPECT_EQ(s.name, "character");
  const double unit = 0.0254 / 0.5;
  EXPECT_DOUBLE_EQ(s.unit, unit);
  EXPECT_DOUBLE_EQ(s.mass, 5);  // sum of the bone masses, divided by the mass scale: (4 + 6) / 2
  EXPECT_EQ(s.joints[0].name, "root");
  EXPECT_EQ(s.joints[1].name, "thigh");
  EXPECT_EQ(s.joints[2].name, "shin");
  EXPECT_EQ(s.joints[2].parent, 1);
  expect_near(s.joints[1].offset, {}, 0, "thigh starts at the root");
  expect_near(s.joints[2].offset, {0, 0, -4 * unit}, 1e-15, "shin starts where the thigh ends");
  EXPECT_TRUE(s.joints[1].end_sites.empty());
  ASSERT_EQ(s.joints[2].end_sites.size(), 1U);
  expect_near(s.joints[2].end_sites[0], {0, 0, -3 * unit}, 1e-15, "the shin's end");
}

TEST(AsfReader, DofsAreOutermostFirstWithAxesAndLimits) {
  const Asf asf = read(units + root + two_bones + tree);
  const auto& thigh = asf.skeleton.joints[1].dofs;
  ASSERT_EQ(thigh.size(), 3U);
  EXPECT_EQ(thigh[0].axis, (Vec3{1, 0, 0})) << "rz of the file is applied last, so it is outermost; the file's z is our x";
  EXPECT_EQ(thigh[2].axis, (Vec3{0, 1, 0})) << "the file's x is our y";
  EXPECT_TRUE(thigh[0].limited);
  EXPECT_NEAR(thigh[0].lower, -70 * degree, 1e-15);
  EXPECT_NEAR(thigh[0].upper, 60 * degree, 1e-15);
  EXPECT_FALSE(thigh[1].limited);
  EXPECT_NEAR(thigh[2].lower, -160 * degree, 1e-15);
  const auto& shin = asf.skeleton.joints[2].dofs;
  ASSERT_EQ(shin.size(), 1U);
  expect_near(shin[0].axis, {0, 0, 1}, 1e-15, "the bone's x axis, rotated by 90 degrees about the file's z, is the file's y, our z");
}

TEST(AmcReader, RotatesABoneAboutItsOwnAxes) {
  const Asf asf = read(units + root + two_bones + tree);
  const double unit = 0.0254 / 0.5;
  const MeasuredMotion m = read_motion(
      ":FULLY-SPECIFIED\n:DEGREES\n1\nroot 1 2 3 0 0 90\nthigh 90 0 0\nshin 0\n2\nthigh 0 0 0\nshin 90\nroot 0 0 0 0 0 0\n", asf);
  EXPECT_EQ(m.frames, 2);
  EXPECT_EQ(m.rate, 120);
  EXPECT_EQ(m.name, "one_01");
  expect_near(m.translations[0], Vec3{3, 1, 2} * unit, 1e-15, "root");
  std::vector<Pose> X;
  m.calc_joint_poses(0, X);
  // In file axes: the thigh (0, -4, 0), rotated by 90 degrees about x, is (0, 0, -4); the rotation of the root about z does not change it.
  expect_near(X[2].p, Vec3{3 - 4, 1, 2} * unit, 1e-14, "knee");
  m.calc_joint_poses(1, X);
  // The shin rotates about the file's y axis. This is the direction of the shin, so only its frame rotates and the foot stays.
  expect_near(X[2] * m.skeleton.joints[2].end_sites[0], Vec3{0, 0, -7} * unit, 1e-14, "foot");
  expect_near(X[2].R * Vec3{1, 0, 0}, {0, 1, 0}, 1e-14, "frame of the shin");
}

TEST(AmcReader, FirstDofIsAppliedFirst) {
  const Asf asf = read(units + root + two_bones + tree);
  const MeasuredMotion m = read_motion("1\nroot 0 0 0 0 0 0\nthigh 10 20 30\nshin 0\n", asf);
  // Expected rotation: Rz(30) Ry(20) Rx(10) in file axes, degrees. R is this rotation in our axes.
  const Mat3 R = rotation_about({1, 0, 0}, 30 * degree) * rotation_about({0, 0, 1}, 20 * degree) * rotation_about({0, 1, 0}, 10 * degree);
  const Mat3 actual = to_matrix(m.rotations[1]);
  for (int i = 0; i < 3; ++i) expect_near(actual.row(i), R.row(i), 1e-15, "row");
}

TEST(AmcReader, RootChannelOrderAndRadiansAreRespected) {
  std::string text = units + root + two_bones + tree;
  text.replace(text.find("TX TY TZ RX RY RZ"), 17, "rz tz ry tx rx ty");
  text.replace(text.find("angle deg"), 9, "angle rad");
  text.replace(text.find("0 0 90 XYZ"), 10, "1.5707963267948966 0 0 ZYX");
  text.replace(text.find("(-10.0 170.0)"), 13, "(-1 2.5)");
  const Asf asf = read(text);
  EXPECT_FALSE(asf.degrees);
  expect_near(asf.skeleton.joints[2].dofs[0].axis, {0, 0, 1}, 1e-15, "first angle about z in the order ZYX");
  EXPECT_EQ(asf.skeleton.joints[2].dofs[0].upper, 2.5);
  const MeasuredMotion m = read_motion("1\nroot 0.3 3 0.2 1 0.1 2\nthigh 0 0 0\nshin 0\n", asf);
  expect_near(m.translations[0], Vec3{3, 1, 2} * asf.skeleton.unit, 1e-15, "root");
  const Mat3 R =
      rotation_about({0, 1, 0}, 0.1) * rotation_about({0, 0, 1}, 0.2) * rotation_about({1, 0, 0}, 0.3);  // rz is applied first, rx last
  expect_near(to_matrix(m.rotations[0]).row(0), R.row(0), 1e-15, "rotation of the root");
  const MeasuredMotion in_degrees = read_motion(":DEGREES\n1\nroot 90 0 0 0 0 0\nthigh 0 0 0\nshin 0\n", asf);
  EXPECT_NEAR(in_degrees.rotations[0].w, std::sqrt(0.5), 1e-15);
}

TEST(AmcReader, TranslationAndLengthDofsMoveTheBone) {
  std::string text = units + root + two_bones + tree;
  text.replace(text.find("dof rx\n    limits (-10.0 170.0)"), 31, "dof rx tx");
  text.replace(text.find("dof rx ry rz"), 12, "dof rx ry l");
  const Asf asf = read(text);
  const double unit = asf.skeleton.unit;
  EXPECT_TRUE(asf.skeleton.joints[2].translates);
  const MeasuredMotion m = read_motion("1\nroot 0 0 0 0 0 0\nthigh 0 0 0.5\nshin 0 2\n", asf);
  // The thigh is 0.5 longer. The shin moves by 2 along its own x axis, which is the file's y, upwards.
  expect_near(m.translations[2], Vec3{0, 0, -4 - 0.5 + 2} * unit, 1e-15, "shin");
}

TEST(AmcReader, FramesStartAtAnyNumberAndGapsAreInterpolated) {
  const Asf asf = read(units + root + two_bones + tree);
  ReadNotes notes;
  const std::string at_rest = "thigh 0 0 0\nshin 0\n";
  const MeasuredMotion m =
      read_motion("#comment\n98\nroot 0 0 0 0 0 0\n" + at_rest + "# between\n102\nroot 8 0 0 0 0 40\n" + at_rest, asf, &notes);
  ASSERT_EQ(m.frames, 5);
  expect_near(m.translations[3], Vec3{0, 2, 0} * asf.skeleton.unit, 1e-15, "a quarter of the way");
  EXPECT_NEAR(2 * std::acos(m.rotations[6].w), 20 * degree, 1e-12);
  EXPECT_EQ(notes.remarks.size(), 2U);
}

TEST(AsfReader, UnitOptionOverridesTheFile) {
  const Asf asf = read(units + root + two_bones + tree, {.metres_per_unit = 0.1});
  EXPECT_EQ(asf.skeleton.unit, 0.1);
  ReadNotes notes;
  ASSERT_TRUE(read_asf(units + root + two_bones + tree, "a", {}, &notes));
  EXPECT_NE(notes.remarks.at(0).find("inches"), std::string::npos);
}

TEST(AsfReader, BoneWithoutDofsNeedsNoLineInFrames) {
  std::string text = units + root + two_bones + tree;
  text.erase(text.find("    dof rx\n    limits (-10.0 170.0)\n"), 37);
  const Asf asf = read(text);
  EXPECT_TRUE(asf.skeleton.joints[2].dofs.empty());
  EXPECT_EQ(read_motion("1\nroot 0 0 0 0 0 0\nthigh 0 0 0\n2\nroot 0 0 0 0 0 0\nthigh 0 0 0\nshin\n", asf).frames, 2);
}

}  // namespace
}  // namespace ugoki::formats
