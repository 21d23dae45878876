// Motions of OpenSim and DeepMimic: world positions against closed forms, uneven times, and faults.
#include "ugoki/scene_formats/opensim.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "ugoki/base/number.h"
#include "ugoki/scene_formats/deepmimic.h"

namespace ugoki::scene_formats {
namespace {

constexpr const char* model = R"(<OpenSimDocument Version="40000"><Model name="leg"><BodySet><objects>
<Body name="pelvis"><mass>10</mass><mass_center>0 0 0</mass_center><inertia>1 1 1 0 0 0</inertia></Body>
<Body name="femur_r"><mass>8</mass><mass_center>0 -0.2 0</mass_center><inertia>0.1 0.1 0.1 0 0 0</inertia></Body></objects></BodySet>
<JointSet><objects><PlanarJoint name="ground_pelvis"><socket_parent_frame>/ground</socket_parent_frame><socket_child_frame>pelvis</socket_child_frame>
<coordinates><Coordinate name="pelvis_tilt"/><Coordinate name="pelvis_tx"/><Coordinate name="pelvis_ty"/></coordinates></PlanarJoint>
<PinJoint name="hip"><socket_parent_frame>at</socket_parent_frame><socket_child_frame>femur_r</socket_child_frame><coordinates>
<Coordinate name="hip_flexion_r"/></coordinates><frames><PhysicalOffsetFrame name="at"><socket_parent>/bodyset/pelvis</socket_parent>
<translation>0.05 -0.1 0.08</translation></PhysicalOffsetFrame></frames></PinJoint></objects></JointSet></Model></OpenSimDocument>)";

double tilt_at(double t) { return 0.3 * t; }
double hip_at(double t) { return 0.2 + 0.5 * t; }

std::string table(bool degrees, bool even, const std::string& prefix = "") {
  std::string out = "walk\nversion=1\nnRows=21\nnColumns=5\ninDegrees=" + std::string(degrees ? "yes" : "no") + "\nendheader\ntime\t" +
                    (prefix.empty() ? "pelvis_tilt\tpelvis_tx\tpelvis_ty\thip_flexion_r"
                                    : "/jointset/a/pelvis_tilt/value\t/jointset/a/pelvis_tx/value\t/jointset/a/pelvis_ty/value\t"
                                      "/jointset/hip/hip_flexion_r/value") +
                    "\n";
  const double unit = degrees ? 57.29577951308232 : 1;
  for (int i = 0; i <= 20; ++i) {
    const double t = even || i % 2 == 0 ? 0.01 * i : 0.01 * i + 0.003;
    for (const double v : {0.5 + t, unit * tilt_at(t), 1.5 * t, 0.9, unit * hip_at(t)}) out += to_text(v) + "\t";
    out += "\n";
  }
  return out;
}

void expect_leg(const MeasuredMotion& m, double tolerance) {
  ASSERT_EQ(m.joint_count(), 2);
  EXPECT_EQ(m.frames, 21);
  EXPECT_EQ(m.rate, 100);
  EXPECT_NEAR(m.skeleton.mass, 18, 1e-12);
  std::vector<Pose> X;
  for (int f = 0; f < m.frames; ++f) {
    const double t = 0.01 * f, a = tilt_at(t), b = a + hip_at(t);
    m.calc_joint_poses(f, X);
    EXPECT_NEAR(norm(X[0].p - Vec3{1.5 * t, 0, 0.9}), 0, tolerance);
    EXPECT_NEAR(norm(X[1].p - Vec3{1.5 * t + 0.05 * std::cos(a) + 0.1 * std::sin(a), -0.08, 0.9 + 0.05 * std::sin(a) - 0.1 * std::cos(a)}),
                0, tolerance);
    EXPECT_NEAR(norm(X[1].R * Vec3{0, 0, -1} - Vec3{std::sin(b), 0, -std::cos(b)}), 0, tolerance);
  }
}

TEST(OpenSimMotion, GivesTheWorldPositionsOfTheModel) {
  for (const bool degrees : {false, true}) {
    const auto m = read_opensim(table(degrees, true), "walk.mot", model, "leg.osim");
    ASSERT_TRUE(m.has_value()) << m.error().text();
    expect_leg(*m, 1e-10);
  }
  const auto states = read_opensim(table(false, true, "states"), "walk.sto", model, "leg.osim");
  ASSERT_TRUE(states.has_value()) << states.error().text();
  expect_leg(*states, 1e-10);
}

TEST(OpenSimMotion, InterpolatesUnevenTimes) {
  formats::ReadNotes notes;
  const auto m = read_opensim(table(false, false), "walk.sto", model, "leg.osim", &notes);
  ASSERT_TRUE(m.has_value()) << m.error().text();
  expect_leg(*m, 1e-10);  // all coordinates are linear in time
  ASSERT_FALSE(notes.remarks.empty());
  EXPECT_NE(notes.remarks[0].find("not steady"), std::string::npos);
}

TEST(OpenSimMotion, NamesFaults) {
  const auto refused = [](const std::string& text, const std::string& what) {
    const auto m = read_opensim(text, "bad.mot", model, "leg.osim");
    ASSERT_FALSE(m.has_value());
    EXPECT_NE(m.error().text().find(what), std::string::npos) << m.error().text();
  };
  refused("time\tpelvis_tilt\n0\t0\n", "endheader");
  refused("endheader\ntime\tground_force_vx\n0\t1\n1\t1\n", "No column names a coordinate");
  refused("endheader\ntime\tpelvis_tilt\n0\t0\n0\t1\n", "times do not rise");
  refused("endheader\ntime\tpelvis_tilt\n0\t0\n1\n", "has 1 numbers");
  refused("endheader\ntime\tpelvis_tilt\n0\tx\n", "bad.mot:3");
  EXPECT_FALSE(read_opensim(table(false, true), "walk.mot", "<Model/>", "leg.osim").has_value());
}

/// A frame of the humanoid: all joints straight except one knee, and the root turned about the vertical.
std::string humanoid_frame(double duration, double x, double yaw, double knee) {
  std::string out =
      "[" + to_text(duration) + "," + to_text(x) + ",0.9,0.1," + to_text(std::cos(yaw / 2)) + ",0," + to_text(std::sin(yaw / 2)) + ",0";
  const std::string straight = ",1,0,0,0";
  out += straight + straight + straight + "," + to_text(knee) + straight + straight + ",0";  // chest, neck, right leg, right arm
  return out + straight + ",0" + straight + straight + ",0]";
}

TEST(DeepMimic, GivesTheWorldPositionsOfTheHumanoid) {
  std::string text = "{\"Loop\": \"wrap\", \"Frames\": [";
  for (int f = 0; f < 10; ++f) text += (f > 0 ? "," : "") + humanoid_frame(f == 9 ? 0 : 0.02, 0.03 * f, 0.1 * f, -0.2 * f);
  const auto m = read_deepmimic(text + "]}", "walk.txt");
  ASSERT_TRUE(m.has_value()) << m.error().text();
  EXPECT_EQ(m->frames, 10);
  EXPECT_EQ(m->rate, 50);
  int ankle = -1, knee = -1;
  for (int i = 0; i < m->joint_count(); ++i) {
    if (m->skeleton.joints[static_cast<std::size_t>(i)].name == "right_ankle") ankle = i;
    if (m->skeleton.joints[static_cast<std::size_t>(i)].name == "right_knee") knee = i;
  }
  ASSERT_TRUE(ankle >= 0 && knee >= 0);
  std::vector<Pose> X;
  for (int f = 0; f < 10; ++f) {
    m->calc_joint_poses(f, X);
    // Before the yaw: the hip is 0.084887 to the right, the knee below it; a negative angle about z (to the right) swings the shank back.
    const double yaw = 0.1 * f, bend = -0.2 * f;
    const auto world = [&](double forward, double right, double up) {
      return Vec3{0.03 * f + std::cos(yaw) * forward + std::sin(yaw) * right, -0.1 - (-std::sin(yaw) * forward + std::cos(yaw) * right),
                  0.9 + up};
    };
    EXPECT_NEAR(norm(X[static_cast<std::size_t>(knee)].p - world(0, 0.084887, -0.421546)), 0, 1e-9);
    EXPECT_NEAR(
        norm(X[static_cast<std::size_t>(ankle)].p - world(0.40987 * std::sin(bend), 0.084887, -0.421546 - 0.40987 * std::cos(bend))), 0,
        1e-9);
  }
}

TEST(DeepMimic, ReadsTheJointsOfACharacterFile) {
  const std::string character =
      R"({"Skeleton": {"Joints": [{"Name": "root", "Type": "none", "Parent": -1}, {"Name": "tail", "Type": "revolute", "Parent": 0, "AttachX": -0.3}]},
         "BodyDefs": [{"AttachX": 0}, {"AttachX": -0.1}]})";
  const std::string text = R"({"Frames": [[0.1, 0,0.5,0, 1,0,0,0, 0.2], [0.05, 0,0.6,0, 1,0,0,0, 0.2], [0, 0,0.65,0, 1,0,0,0, 0.2]]})";
  formats::ReadNotes notes;
  const auto m = read_deepmimic(text, "wag.txt", character, "dog.txt", &notes);
  ASSERT_TRUE(m.has_value()) << m.error().text();
  EXPECT_EQ(m->rate, 60);  // the frames have different durations
  EXPECT_EQ(m->frames, 10);
  std::vector<Pose> X;
  m->calc_joint_poses(9, X);
  EXPECT_NEAR(X[0].p.z, 0.65, 1e-9);
  EXPECT_NEAR(norm(X[1].p - Vec3{-0.3, 0, 0.65}), 0, 1e-9);
  ASSERT_EQ(m->skeleton.joints[1].end_sites.size(), 1u);
  EXPECT_NEAR(m->skeleton.joints[1].end_sites[0].x, -0.2, 1e-12);
}

TEST(DeepMimic, NamesFaults) {
  const auto refused = [](const std::string& text, const std::string& what) {
    const auto m = read_deepmimic(text, "bad.txt");
    ASSERT_FALSE(m.has_value());
    EXPECT_NE(m.error().text().find(what), std::string::npos) << m.error().text();
  };
  refused("hello", "bad.txt");
  refused("{\"Frames\": []}", "no list 'Frames'");
  refused("{\"Frames\": [[0.1, 1, 2]]}", "has 3 numbers, but the character needs 44");
  refused("{\"Frames\": [" + humanoid_frame(0, 0, 0, 0) + "," + humanoid_frame(0, 0, 0, 0) + "]}", "duration");
}

}  // namespace
}  // namespace ugoki::scene_formats
