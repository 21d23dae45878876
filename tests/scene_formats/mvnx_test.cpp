// MVNX: world poses against those that were written, the file's variants, and faults.
#include "ugoki/scene_formats/mvnx.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "ugoki/base/number.h"

namespace ugoki::scene_formats {
namespace {

std::string text_of(const Vec3& v) { return to_text(v.x) + " " + to_text(v.y) + " " + to_text(v.z) + " "; }
std::string text_of(const Quat& q) { return to_text(q.w) + " " + text_of(Vec3{q.x, q.y, q.z}); }

/// World poses of a leg, written independently of the reader: Foot, Shank, Pelvis (children before parents).
struct Leg {
  Quat foot, shank, pelvis;
  Vec3 p_foot, p_shank, p_pelvis;
};
Leg leg_at(int frame) {
  Leg l;
  const double a = 0.2 * frame;
  l.pelvis = axis_angle({0, 0, 1}, a);
  l.shank = l.pelvis * axis_angle({0, 1, 0}, 0.5 * a);
  l.foot = l.shank * axis_angle({1, 0, 0}, 0.3);
  l.p_pelvis = {0.1 * frame, 0.2, 0.9};
  l.p_shank = l.p_pelvis + rotate(l.pelvis, {0, 0.1, -0.4});
  l.p_foot = l.p_shank + rotate(l.shank, {0.02, 0, -0.4});
  return l;
}

std::string file(int frames, const std::string& joints) {
  std::string out = R"(<?xml version="1.0"?><mvnx version="4"><subject label="A" frameRate="240" segmentCount="3"><segments>
<segment label="Foot" id="1"><points><point label="toe"><pos_b>0.2 0 -0.05</pos_b></point><point label="heel"><pos_b>-0.05 0 -0.05</pos_b></point></points></segment>
<segment label="Shank" id="2"/><segment label="Pelvis" id="3"/></segments>)" +
                    joints + "<frames>";
  const auto frame = [&](const char* type, int f) {
    const Leg l = leg_at(f);
    out += "<frame type=\"" + std::string(type) + "\"><orientation>" + text_of(l.foot) + text_of(l.shank) + text_of(l.pelvis) +
           "</orientation><position>" + text_of(l.p_foot) + text_of(l.p_shank) + text_of(l.p_pelvis) + "</position></frame>\n";
  };
  frame("identity", 30);
  frame("tpose", 31);
  for (int f = 0; f < frames; ++f) frame("normal", f);
  return out + "</frames></subject></mvnx>";
}

const std::string joints =
    "<joints><joint label=\"knee\"><connector1>Pelvis/knee</connector1><connector2>Shank/knee</connector2></joint>"
    "<joint label=\"ankle\"><connector1>Shank/ankle</connector1><connector2>Foot/ankle</connector2></joint></joints>";

TEST(Mvnx, WorldPosesAreThoseOfTheFile) {
  formats::ReadNotes notes;
  const auto m = read_mvnx(file(12, joints), "folder/walk.mvnx", &notes);
  ASSERT_TRUE(m.has_value()) << m.error().text();
  EXPECT_EQ(m->name, "walk");
  EXPECT_EQ(m->frames, 12);
  EXPECT_EQ(m->rate, 240);
  EXPECT_TRUE(notes.z_up);
  ASSERT_EQ(m->joint_count(), 3);
  EXPECT_EQ(m->skeleton.joints[0].name, "Pelvis");
  EXPECT_EQ(m->skeleton.joints[2].name, "Foot");
  ASSERT_EQ(m->skeleton.joints[2].end_sites.size(), 1U);
  EXPECT_EQ(m->skeleton.joints[2].end_sites[0], (Vec3{0.2, 0, -0.05}));
  EXPECT_FALSE(m->skeleton.joints[1].translates);
  std::vector<Pose> X;
  for (int f = 0; f < m->frames; ++f) {
    m->calc_joint_poses(f, X);
    const Leg l = leg_at(f);
    EXPECT_LT(norm(X[0].p - l.p_pelvis), 1e-12) << f;
    EXPECT_LT(norm(X[1].p - l.p_shank), 1e-12) << f;
    EXPECT_LT(norm(X[2].p - l.p_foot), 1e-12) << f;
    for (const Vec3& e : {Vec3{1, 0, 0}, Vec3{0, 1, 0}}) EXPECT_LT(norm(X[2].R * e - rotate(l.foot, e)), 1e-12) << f;
  }
  EXPECT_TRUE(std::ranges::any_of(notes.remarks, [](const std::string& r) { return r.starts_with("2 frames with calibration poses"); }));
}

TEST(Mvnx, FilesWithoutJointsHaveTheUsualTree) {
  std::string text = file(3, "");
  const auto rename = [&](const std::string& from, const std::string& to) {
    for (std::size_t at; (at = text.find("\"" + from + "\"")) != std::string::npos;) text.replace(at, from.size() + 2, "\"" + to + "\"");
  };
  rename("Foot", "LeftLowerLeg");
  rename("Shank", "LeftUpperLeg");
  const auto m = read_mvnx(text, "walk.mvnx");
  ASSERT_TRUE(m.has_value()) << m.error().text();
  EXPECT_EQ(m->skeleton.joints[1].name, "LeftUpperLeg");
  EXPECT_EQ(m->skeleton.joints[1].parent, 0);
  EXPECT_EQ(m->skeleton.joints[2].parent, 1);
}

TEST(Mvnx, FaultsAreReportedWithLineAndRemedy) {
  const auto with = [](std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  };
  const std::string good = file(3, joints);
  for (const auto& [text, message] : {std::pair{std::string("<html></html>"), "not <mvnx>"},
                                      {with(good, "Pelvis/knee", "Hip/knee"), "no such segment"},
                                      {with(good, "Pelvis/knee", "Foot/knee"), "loop"},
                                      {with(good, "\"normal\"><orientation>", "\"normal\"><orientation>7 "), "orientation"},
                                      {file(0, joints), "no frames"},
                                      {with(good, "label=\"Shank\"", "label=\"Foot\""), "Two segments"},
                                      {good.substr(0, good.size() / 2), ""}}) {
    const auto m = read_mvnx(text, "walk.mvnx");
    ASSERT_FALSE(m.has_value()) << message;
    EXPECT_NE(m.error().text().find(message), std::string::npos) << m.error().text();
    for (const Problem& p : m.error().problems) {
      EXPECT_TRUE(p.location.starts_with("walk.mvnx")) << p.location;
      EXPECT_FALSE(p.remedy.empty());
    }
  }
}

}  // namespace
}  // namespace ugoki::scene_formats
