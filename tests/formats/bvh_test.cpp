// BVH: poses against closed forms, variants of the format, and round trips through the writer.
#include "ugoki/formats/bvh.h"

#include <random>

#include "expect.h"

namespace ugoki::formats {
namespace {

constexpr double degree = pi / 180;

/// A file with a root and an arm of 2 units along the file's y axis. @param channels CHANNELS line of the arm
/// @param numbers values of the single frame
std::string arm(const std::string& channels, const std::string& numbers) {
  return "HIERARCHY\nROOT Hips\n{\n\tOFFSET 0 0 0\n\tCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n"
         "\tJOINT Arm\n\t{\n\t\tOFFSET 0 1 0\n\t\t" +
         channels + "\n\t\tEnd Site\n\t\t{\n\t\t\tOFFSET 0 2 0\n\t\t}\n\t}\n}\nMOTION\nFrames: 1\nFrame Time: 0.01\n" + numbers + "\n";
}

MeasuredMotion read(const std::string& text, const BvhOptions& options = {.metres_per_unit = 1}, ReadNotes* notes = nullptr) {
  auto result = read_bvh(text, "folder/test.bvh", options, notes);
  EXPECT_TRUE(result.has_value()) << (result ? std::string() : text_of(result.error()));
  return result ? std::move(*result) : MeasuredMotion{};
}

/// World position of the first end site of a joint.
Vec3 tip(const MeasuredMotion& m, std::size_t joint, int frame = 0) {
  std::vector<Pose> X;
  m.calc_joint_poses(frame, X);
  return X[joint] * m.skeleton.joints[joint].end_sites.at(0);
}

TEST(BvhReader, ConvertsAxesAndPlacesRootAtItsPositionChannels) {
  const MeasuredMotion m = read(arm("CHANNELS 3 Zrotation Xrotation Yrotation", "10 20 30 0 0 0 0 0 0"));
  ASSERT_EQ(m.joint_count(), 2);
  EXPECT_EQ(m.name, "test");
  EXPECT_EQ(m.source, "folder/test.bvh");
  EXPECT_EQ(m.frames, 1);
  EXPECT_EQ(m.rate, 100);
  EXPECT_EQ(m.translations[0], (Vec3{30, 10, 20}));
  EXPECT_EQ(m.skeleton.joints[1].offset, (Vec3{0, 0, 1}));
  expect_near(tip(m, 1), {30, 10, 23}, 1e-14, "tip at rest");
  EXPECT_TRUE(m.skeleton.joints[0].translates);
  EXPECT_FALSE(m.skeleton.joints[1].translates);
  EXPECT_EQ(m.skeleton.joints[1].rotation_order, "ZXY");
  ASSERT_EQ(m.skeleton.joints[1].dofs.size(), 3U);
  EXPECT_EQ(m.skeleton.joints[1].dofs[0].axis, (Vec3{1, 0, 0}));  // the file's z axis is our x axis
}

TEST(BvhReader, LineMotionMayBeMissing) {
  const std::string with = arm("CHANNELS 1 Zrotation", "0 0 0 0 0 0 90");
  std::string without = with;
  without.erase(without.find("MOTION\n"), 7);
  const MeasuredMotion m = read(without);
  EXPECT_EQ(m.frames, 1);
  expect_near(tip(m, 1), {0, -2, 1}, 1e-14, "turned arm");
  // A hierarchy whose braces are not closed is still refused.
  without.erase(without.find("}\nFrames"), 2);
  EXPECT_FALSE(read_bvh(without, "test.bvh", {}).has_value());
}

TEST(BvhReader, SingleRotationChannelRotatesAboutItsAxis) {
  // 90 degrees about the file's z axis rotate the arm from the file's y to its -x, which is our -y.
  const MeasuredMotion m = read(arm("CHANNELS 1 Zrotation", "0 0 0 0 0 0 90"));
  expect_near(tip(m, 1), {0, -2, 1}, 1e-14, "turned arm");
  EXPECT_EQ(m.skeleton.joints[1].rotation_order, "Z");
}

TEST(BvhReader, JointWithZeroChannelsIsRigid) {
  const MeasuredMotion m = read(arm("CHANNELS 0", "0 0 0 0 90 0"));
  EXPECT_TRUE(m.skeleton.joints[1].dofs.empty());
  expect_near(tip(m, 1), {3, 0, 0}, 1e-14, "90 degrees about the file's x rotate the character forward");
}

TEST(BvhReader, JointWithoutChannelsLineIsRigid) {
  const MeasuredMotion m = read(arm("", "0 0 0 0 0 0"));
  EXPECT_TRUE(m.skeleton.joints[1].dofs.empty());
}

TEST(BvhReader, FirstRotationChannelIsOutermostInEveryOrder) {
  const double a = 20 * degree, b = -35 * degree, c = 70 * degree;
  // Rotation matrices in the file's axes, independent of the reader's quaternions.
  const auto elementary = [](char axis, double t) {
    const double s = std::sin(t), k = std::cos(t);
    return axis == 'X'   ? Mat3{1, 0, 0, 0, k, -s, 0, s, k}
           : axis == 'Y' ? Mat3{k, 0, s, 0, 1, 0, -s, 0, k}
                         : Mat3{k, -s, 0, s, k, 0, 0, 0, 1};
  };
  for (const std::string order : {"XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX", "ZXZ", "XYX"}) {
    std::string channels = "CHANNELS 3";
    for (const char x : order) channels += std::string(" ") + x + "rotation";
    const MeasuredMotion m = read(arm(channels, "0 0 0 0 0 0 20 -35 70"));
    const Vec3 in_file = elementary(order[0], a) * (elementary(order[1], b) * (elementary(order[2], c) * Vec3{0, 2, 0})) + Vec3{0, 1, 0};
    expect_near(tip(m, 1), {in_file.z, in_file.x, in_file.y}, 1e-14, order);
  }
}

TEST(BvhReader, PositionChannelsReplaceComponentsOfOffset) {
  const MeasuredMotion all = read(arm("CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation", "0 0 0 0 0 0 4 5 6 0 0 0"));
  EXPECT_EQ(all.translations[1], (Vec3{6, 4, 5}));
  const MeasuredMotion one = read(arm("CHANNELS 2 Zposition Zrotation", "0 0 0 0 0 0 4 0"));
  EXPECT_EQ(one.translations[1], (Vec3{4, 0, 1}));  // z from the frame; x and y from the OFFSET
  EXPECT_TRUE(one.skeleton.joints[1].translates);
  const MeasuredMotion only = read(arm("CHANNELS 3 Xposition Yposition Zposition", "0 0 0 0 0 0 1 2 3"));
  EXPECT_EQ(only.translations[1], (Vec3{3, 1, 2}));
}

TEST(BvhReader, TranslationPrecedesRotationForAnyChannelOrder) {
  std::string text = arm("CHANNELS 0", "0 90 0 10 20 30");
  const std::string usual = "Xposition Yposition Zposition Zrotation Xrotation Yrotation";
  text.replace(text.find(usual), usual.size(), "Zrotation Xrotation Yrotation Xposition Yposition Zposition");
  const MeasuredMotion m = read(text);
  EXPECT_EQ(m.translations[0], (Vec3{30, 10, 20}));
  expect_near(tip(m, 1), {33, 10, 20}, 1e-13, "root rotated about its own position");
}

TEST(BvhReader, AcceptsCommonVariantsOfTheFormat) {
  const std::string body =
      "hierarchy\r\n# made by hand\r\nRoot  Left Hip : main {\r\n  Offset\t0 0 0\r\n  channels 3 XROTATION yrotation Zrotation\r\n"
      "  Joint mixamorig:Spine {\r\n  OFFSET +1.5e0 -.5 2.\r\n  CHANNELS 3\r\n   Zrotation Xrotation\r\n Yrotation\r\n  End site\r\n{ "
      "OFFSET 1 1 1 }\r\n"
      "  End Site second end\r\n { OFFSET 2 2 2 } }\r\n}\r\nMotion\r\nFrames 2\r\nFrame Time:.0083333\r\n"
      "1 2\r\n3 4 5\r\n6\r\n\r\n 1 2 3 4 5 6\r\n";
  for (const std::string& text : {body, "\xEF\xBB\xBF" + body, body + "\x1A", body.substr(0, body.size() - 2)}) {
    const MeasuredMotion m = read(text);
    ASSERT_EQ(m.joint_count(), 2);
    EXPECT_EQ(m.skeleton.joints[0].name, "Left Hip : main");
    EXPECT_EQ(m.skeleton.joints[1].name, "mixamorig:Spine");
    EXPECT_EQ(m.skeleton.joints[1].offset, (Vec3{2, 1.5, -0.5}));
    EXPECT_EQ(m.skeleton.joints[1].end_sites.size(), 2U);
    EXPECT_EQ(m.frames, 2);
    EXPECT_EQ(m.rate, 120);
    EXPECT_EQ(m.rotations[0], m.rotations[2]);
  }
  std::string old_mac = body;
  std::erase(old_mac, '\n');
  EXPECT_EQ(read(old_mac).frames, 2);
}

TEST(BvhReader, EndSiteWithChildrenOrChannelsBecomesJoint) {
  const std::string text =
      "HIERARCHY\nROOT A\n{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n"
      "End Site\n{\nOFFSET 0 1 0\nCHANNELS 1 Xrotation\nEnd Site\n{\nOFFSET 0 1 0\n}\n}\n"
      "End Site Tail\n{\nOFFSET 0 0 -1\nJOINT TailTip\n{\nOFFSET 0 0 -1\nCHANNELS 1 Yrotation\n}\n}\n"
      "JOINT B\n{\nOFFSET 1 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n}\n}\n"
      "MOTION\nFrames: 1\nFrame Time: 0.04\n0 0 0 90 45 0 0 0\n";
  const MeasuredMotion m = read(text);
  ASSERT_EQ(m.joint_count(), 5);
  EXPECT_EQ(m.skeleton.joints[1].name, "A_end");
  EXPECT_EQ(m.skeleton.joints[2].name, "Tail");
  EXPECT_EQ(m.skeleton.joints[3].name, "TailTip");
  EXPECT_EQ(m.skeleton.joints[3].parent, 2);
  EXPECT_EQ(m.skeleton.joints[4].parent, 0);
  expect_near(tip(m, 1), {1, 0, 1}, 1e-14, "channel of the end site");
}

TEST(BvhReader, ReadsSeveralRoots) {
  const std::string one = " {\nOFFSET 0 0 0\nCHANNELS 3 Xposition Yposition Zposition\n}\n";
  const MeasuredMotion m = read("HIERARCHY\nROOT A" + one + "ROOT B" + one + "MOTION\nFrames: 1\nFrame Time: 0.1\n1 2 3 4 5 6\n");
  ASSERT_EQ(m.joint_count(), 2);
  EXPECT_EQ(m.skeleton.joints[1].parent, -1);
  EXPECT_EQ(m.translations[1], (Vec3{6, 4, 5}));
  EXPECT_LT(max_distance(m, read(write_bvh(m)), 1), 1e-9);
}

TEST(BvhReader, RenamesDuplicateNamesAndNotesIt) {
  const std::string joint = "OFFSET 0 1 0\nCHANNELS 1 Xrotation\n";
  ReadNotes notes;
  const MeasuredMotion m = read("HIERARCHY\nROOT A\n{\n" + joint + "JOINT A_2\n{\n" + joint + "}\nJOINT A\n{\n" + joint + "}\nJOINT\n{\n" +
                                    joint + "}\nJOINT Jos\xE9\n{\n" + joint + "}\n}\nMOTION\nFrames: 1\nFrame Time: 0.1\n1 2 3 4 5\n",
                                {.metres_per_unit = 1}, &notes);
  ASSERT_EQ(m.joint_count(), 5);
  EXPECT_EQ(m.skeleton.joints[1].name, "A_2");
  EXPECT_EQ(m.skeleton.joints[2].name, "A_3");
  EXPECT_EQ(m.skeleton.joints[3].name, "joint4");
  EXPECT_EQ(m.skeleton.joints[4].name, "Jos\xC3\xA9");
  EXPECT_EQ(notes.remarks.size(), 2U);
}

TEST(BvhReader, RecoversRateFromRoundedFrameTime) {
  const std::pair<const char*, double> cases[] = {{"0.0083333", 120},
                                                  {".0083333", 120},
                                                  {"0.008333", 120},
                                                  {"0.00833333333333333", 120},
                                                  {"0.0333333", 30},
                                                  {"0.033", 30},
                                                  {"0.03333", 30},
                                                  {"0.041667", 24},
                                                  {"0.04", 25},
                                                  {"0.016666666666666666", 60},
                                                  {"0.0166667", 60},
                                                  {"0.017", 60},
                                                  {"0.008", 125},
                                                  {"0.0166833", 60000.0 / 1001},
                                                  {"0.0417083750417", 23.976},
                                                  {"1e-2", 100},
                                                  {"8.3333e-3", 120},
                                                  {"0.0123", 81},
                                                  {"0.0123123", 1 / 0.0123123},
                                                  {"1", 1},
                                                  {"0.00390625", 256}};
  for (const auto& [text, rate] : cases) {
    std::string file = arm("CHANNELS 0", "0 0 0 0 0 0");
    file.replace(file.find("0.01\n"), 4, text);
    ReadNotes notes;
    EXPECT_NEAR(read(file, {.metres_per_unit = 1}, &notes).rate, rate, 1e-9 * rate) << text;
    EXPECT_EQ(notes.frame_time, std::strtod(text, nullptr)) << text;
  }
}

TEST(BvhReader, GuessesUnitFromSkeletonSize) {
  const std::pair<double, double> cases[] = {{1.75, 1}, {17, 0.1}, {175, 0.01}, {1700, 0.001}, {68, 0.0254}, {30.5, 0.0254 / 0.45}};
  for (const auto& [height, unit] : cases) {
    std::string file = arm("CHANNELS 0", "0 0 0 0 0 0");
    file.replace(file.find("OFFSET 0 2 0"), 12, "OFFSET 0 " + std::to_string(height - 1) + " 0");
    ReadNotes notes;
    const MeasuredMotion m = read(file, {}, &notes);
    EXPECT_EQ(m.skeleton.unit, unit) << height;
    EXPECT_TRUE(notes.unit_guessed);
    EXPECT_EQ(notes.metres_per_unit, unit);
    EXPECT_EQ(notes.remarks.size(), 1U);
    EXPECT_NEAR(rest_height(m.skeleton), height * unit, 1e-9);
  }
  ReadNotes notes;
  EXPECT_EQ(read(arm("CHANNELS 0", "0 0 0 0 0 0"), {.metres_per_unit = 0.5}, &notes).skeleton.unit, 0.5);
  EXPECT_FALSE(notes.unit_guessed);
}

TEST(BvhReader, ZUpFilesKeepTheirAxes) {
  const MeasuredMotion m = read(arm("CHANNELS 1 Zrotation", "10 20 30 0 0 0 90"), {.metres_per_unit = 1, .z_up = true});
  EXPECT_EQ(m.translations[0], (Vec3{10, 20, 30}));
  expect_near(tip(m, 1), {8, 21, 30}, 1e-13, "arm along y rotated about z");
  EXPECT_LT(max_distance(m, read(write_bvh(m, {.z_up = true}), {.metres_per_unit = 1, .z_up = true}), 1), 1e-7);
  EXPECT_LT(max_distance(m, read(write_bvh(m)), 1), 1e-7);
}

// ---- writing

/// Six joints with different rotation orders and random poses; in two of three frames the middle angle is at the gimbal pole (90 degrees).
MeasuredMotion wild_motion(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-180, 180), near_pole(-1e-9, 1e-9);
  MeasuredMotion m;
  m.name = "wild";
  m.rate = 50;
  m.frames = 40;
  m.skeleton.unit = 0.01;
  const char* orders[] = {"ZXY", "XYZ", "ZXZ", "", "Y", "YZX"};
  for (int i = 0; i < 6; ++i) {
    SkeletonJoint j;
    j.name = "joint " + std::to_string(i);
    j.parent = i == 5 ? 0 : i - 1;
    j.offset = {0.1 * i, 0.3, -0.2};
    j.rotation_order = orders[i];
    j.translates = i == 3;
    j.end_sites = {{0.4, 0.1, 0}, {0, 0, 0.3}};
    m.skeleton.joints.push_back(j);
  }
  for (int f = 0; f < m.frames; ++f)
    for (int i = 0; i < 6; ++i) {
      const auto& j = m.skeleton.joints[static_cast<std::size_t>(i)];
      const bool translates = i == 0 || j.translates;
      m.translations.push_back(translates ? Vec3{any(random) / 100, any(random) / 100, any(random) / 100} : j.offset);
      const double middle = f % 3 == 0 ? 90 + near_pole(random) : f % 3 == 1 ? -90 : any(random);
      m.rotations.push_back(to_quat(from_euler(Vec3{any(random), middle, any(random)} * degree, i % 2 == 0 ? "XYZ" : "YZX")));
    }
  return m;
}

TEST(BvhWriter, RoundTripKeepsPositionsAtGimbalPole) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const MeasuredMotion m = wild_motion(seed);
    EXPECT_LT(max_distance(m, read(write_bvh(m), {.metres_per_unit = 0.01}), 1), 1e-8) << "seed " << seed;
    EXPECT_LT(max_distance(m, read(write_bvh(m, {.metres_per_unit = 0.0254}), {.metres_per_unit = 0.0254}), 1), 1e-8) << "seed " << seed;
  }
}

TEST(BvhWriter, RoundTripKeepsRotationOrdersAndRate) {
  const MeasuredMotion m = wild_motion(1);
  const MeasuredMotion back = read(write_bvh(m), {.metres_per_unit = 0.01});
  EXPECT_EQ(back.rate, 50);
  const auto order = [&](const char* name) {
    for (const SkeletonJoint& j : back.skeleton.joints)
      if (j.name == name) return j.rotation_order;
    return std::string("none");
  };
  EXPECT_EQ(order("joint 0"), "ZXY");
  EXPECT_EQ(order("joint 1"), "XYZ");
  EXPECT_EQ(order("joint 2"), "ZXY") << "ZXZ repeats an axis: replaced by ZXY";
  EXPECT_EQ(order("joint 4"), "YZX") << "an order of one axis is completed";
  EXPECT_EQ(order("joint 5"), "YZX");
  EXPECT_EQ(back.skeleton.joints[0].end_sites.size(), 2U);
}

TEST(BvhWriter, RoundTripKeepsNumbersOfSimpleFile) {
  const std::string text = arm("CHANNELS 3 Zrotation Xrotation Yrotation", "10 20 30 1 2 3 -4.5 5.25 6.125");
  const std::string written = write_bvh(read(text));
  EXPECT_NE(written.find("\n10 20 30 1 2 3 -4.5 5.25 6.125\n"), std::string::npos) << written;
  EXPECT_NE(written.find("Frame Time: 0.01\n"), std::string::npos);
}

TEST(BvhWriter, AnglesContinueBeyond180Degrees) {
  // The arm rotates 400 frames of 3 degrees about its outermost axis; the last angle is 399 * 3 = 1197 degrees.
  MeasuredMotion m = read(arm("CHANNELS 3 Zrotation Xrotation Yrotation", "0 0 0 0 0 0 0 0 0"));
  m.frames = 400;
  m.translations.clear();
  m.rotations.clear();
  for (int f = 0; f < m.frames; ++f)
    for (int i = 0; i < 2; ++i) {
      m.translations.push_back(m.skeleton.joints[static_cast<std::size_t>(i)].offset);
      m.rotations.push_back(i == 0 ? Quat{} : axis_angle({1, 0, 0}, f * 3 * degree) * axis_angle({0, 1, 0}, 0.3));
    }
  const std::string written = write_bvh(m);
  const std::string last = written.substr(written.rfind('\n', written.size() - 2) + 1);
  EXPECT_TRUE(last.starts_with("0 0 0 0 0 0 1197 ")) << last;
}

TEST(BvhWriter, DecimalsSetThePrecision) {
  const MeasuredMotion m = wild_motion(3);
  EXPECT_LT(write_bvh(m, {.decimals = 3}).size(), write_bvh(m).size());
  EXPECT_LT(max_distance(m, read(write_bvh(m, {.decimals = 15}), {.metres_per_unit = 0.01}), 1), 1e-13);
  EXPECT_EQ(write_bvh(m, {.decimals = -7}), write_bvh(m, {.decimals = 1}));
}

}  // namespace
}  // namespace ugoki::formats
