#include "ugoki/formats/csv.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "ugoki/formats/asf.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::formats {
namespace {

MarkerMotion markers() {
  std::mt19937_64 engine(5);
  std::uniform_real_distribution<double> in(-2, 2);
  MarkerMotion m;
  m.name = "hop";
  m.labels = {"LASI", "a, \"odd\" one", "head"};
  m.rate = 120;
  m.frames = 30;
  m.first_frame = 7;
  for (int i = 0; i < 90; ++i) {
    const bool seen = i % 11 != 3;
    m.positions.push_back(seen ? Vec3{in(engine), in(engine), in(engine)} : Vec3{});
    m.residuals.push_back(seen ? 0.0f : -1.0f);
  }
  return m;
}

TEST(Csv, MarkerRoundTripKeepsBits) {
  const MarkerMotion m = markers();
  const auto back = read_csv(write_csv(m), "hop.csv");
  ASSERT_TRUE(back.has_value()) << back.error().text();
  EXPECT_EQ(back->labels, m.labels);
  EXPECT_EQ(back->rate, 120);
  EXPECT_EQ(back->first_frame, 7);
  EXPECT_EQ(back->positions, m.positions);
  EXPECT_EQ(back->residuals, m.residuals);
  const auto rounded = read_csv(write_csv(m, {.decimals = 4}), "hop.csv");
  for (std::size_t i = 0; i < m.positions.size(); ++i) EXPECT_LT(norm(rounded->positions[i] - m.positions[i]), 1e-4);
}

TEST(Csv, SemicolonFilesWithUnitsAreRead) {
  const auto back = read_csv(
      "# made elsewhere\r\nframe;time;LASI_X [mm];LASI_Y [mm];LASI_Z "
      "[mm];note\r\n1;0.00;100;200;900;1\r\n2;0.01;110;;900;1\r\n3;0.02;120;200;905;0\r\n",
      "x.csv", {.up = UpAxis::z});
  ASSERT_TRUE(back.has_value()) << back.error().text();
  EXPECT_EQ(back->labels, (std::vector<std::string>{"LASI"}));
  EXPECT_EQ(back->rate, 100);
  EXPECT_LT(norm(back->at(0, 0) - Vec3{0.1, 0.2, 0.9}), 1e-15);
  EXPECT_FALSE(back->seen(1, 0));
}

/// A mechanism with one link of every joint type.
MechanismPtr one_of_every_joint() {
  MechanismSpec spec{.name = "everything", .links = {}};
  for (int i = 0; i < 9; ++i) {
    LinkSpec l;
    l.name = i == 4 ? "left, \"odd\"" : "link" + std::to_string(i);
    l.joint.type = static_cast<JointType>(i);
    l.inertia = solid_inertia(Shape::sphere(0.1), 1000);
    spec.links.push_back(l);
  }
  return *Mechanism::make(spec);
}

TEST(Csv, CoordinateRoundTripKeepsValues) {
  const MechanismPtr m = one_of_every_joint();
  std::mt19937_64 engine(3);
  std::uniform_real_distribution<double> in(-2, 2);
  Motion motion;
  motion.name = "dance";
  motion.rate = 60;
  motion.frames = 20;
  motion.nq = m->nq();
  std::vector<double> q = m->neutral(), v(static_cast<std::size_t>(m->nv()));
  for (int f = 0; f < 20; ++f) {
    for (double& x : v) x = in(engine);
    integrate(*m, q, v, 0.3, q);
    motion.q.insert(motion.q.end(), q.begin(), q.end());
  }
  motion.contacts = {{"link1", std::vector<std::uint8_t>(20, 1)}};
  motion.contacts[0].on[7] = 0;
  for (const bool degrees : {true, false}) {
    const std::string text = write_csv(motion, *m, {.degrees = degrees});
    EXPECT_EQ(csv_kind(text), CsvKind::coordinates);
    const auto back = read_csv(text, "dance.csv", *m);
    ASSERT_TRUE(back.has_value()) << back.error().text();
    EXPECT_EQ(back->frames, 20);
    EXPECT_EQ(back->rate, 60);
    ASSERT_EQ(back->q.size(), motion.q.size());
    for (std::size_t i = 0; i < motion.q.size(); ++i) EXPECT_NEAR(back->q[i], motion.q[i], 1e-14);
    ASSERT_EQ(back->contacts.size(), 1u);
    EXPECT_EQ(back->contacts[0].on, motion.contacts[0].on);
    EXPECT_TRUE(check_motion(*back, *m).empty());
  }
  EXPECT_EQ(csv_kind(write_csv(markers())), CsvKind::points);
}

TEST(Csv, ErrorsHaveLocationAndRemedy) {
  const MechanismPtr m = one_of_every_joint();
  const auto refuse = [](const std::string& text) {
    const auto r = read_csv(text, "x.csv");
    EXPECT_FALSE(r.has_value()) << text;
    if (r) return std::string();
    for (const Problem& p : r.error().problems) EXPECT_FALSE(p.location.empty() || p.message.empty() || p.remedy.empty());
    return r.error().text();
  };
  EXPECT_NE(refuse("").find("empty"), std::string::npos);
  EXPECT_NE(refuse("time,a.x,a.y,a.z\n").find("no rows"), std::string::npos);
  EXPECT_NE(refuse("time,a.x,a.y\n0,1,2\n").find("'a'"), std::string::npos);
  EXPECT_NE(refuse("time,a.x,a.y,a.z\n0,1,2\n").find("x.csv:2"), std::string::npos);
  EXPECT_NE(refuse("time,a.x,a.y,a.z\n0,1,2,q\n").find("'q'"), std::string::npos);
  EXPECT_NE(refuse("time,a.x,a.y,a.z\n0,1,2,1e300\n").find("x.csv:2"), std::string::npos);
  EXPECT_NE(refuse("time,a.x,a.y,a.z\n0,1,2,3\n1,1,2,3\n5,1,2,3\n").find("evenly"), std::string::npos);
  EXPECT_NE(refuse("time,a.x,a.x,a.y,a.z\n0,1,1,2,3\n").find("Two columns"), std::string::npos);
  EXPECT_NE(refuse("time,\"a.x,a.y,a.z\n0,1,2,3\n").find("quotes"), std::string::npos);
  EXPECT_NE(refuse("knee[deg]\n3\n").find("NAME.x"), std::string::npos);
  EXPECT_FALSE(read_csv("time,nose[deg]\n0,1\n", "x.csv", *m).has_value());
  EXPECT_FALSE(read_csv("time,link1[deg]\n0,\n", "x.csv", *m).has_value());
  EXPECT_FALSE(read_csv("time,link7.qw,link7.qx\n0,3,0\n", "x.csv", *m).has_value());
}

/// A random motion of nine joints in a binary tree, with end sites, two translating joints and one that does not rotate.
MeasuredMotion tree() {
  std::mt19937_64 engine(9);
  std::uniform_real_distribution<double> in(-1, 1);
  MeasuredMotion m;
  m.name = "tree of joints";
  m.skeleton.unit = 0.01;
  for (int i = 0; i < 9; ++i) {
    SkeletonJoint j;
    j.name = i == 2 ? "left arm" : "joint" + std::to_string(i);
    j.parent = i == 0 ? -1 : (i - 1) / 2;
    j.offset = {in(engine), in(engine), in(engine)};
    j.translates = i == 3;
    if (i >= 4) j.end_sites = {{in(engine), in(engine), 0.2}};
    if (i == 8) j.end_sites.push_back({0, 0, 0.5});
    m.skeleton.joints.push_back(j);
  }
  m.frames = 25;
  for (int f = 0; f < m.frames; ++f)
    for (int i = 0; i < 9; ++i) {
      Vec3 t = m.skeleton.joints[static_cast<std::size_t>(i)].offset;
      if (i == 0 || i == 3) t += Vec3{in(engine), in(engine), in(engine)};
      m.translations.push_back(t);
      m.rotations.push_back(i == 5 ? Quat{} : exp_map({3 * in(engine), 2 * in(engine), in(engine)}));
    }
  return m;
}

TEST(AmcWriter, RoundTripKeepsPositionsAndRotations) {
  for (const bool two_roots : {false, true}) {
    MeasuredMotion m = tree();
    if (two_roots) m.skeleton.joints[2].parent = -1;
    const AmcText text = write_amc(m, {.decimals = 15});
    const auto asf = read_asf(text.asf, "tree.asf");
    ASSERT_TRUE(asf.has_value()) << asf.error().text() << text.asf;
    const auto back = read_amc(text.amc, "tree.amc", *asf, {.rate = m.rate});
    ASSERT_TRUE(back.has_value()) << back.error().text();
    EXPECT_EQ(back->frames, m.frames);
    EXPECT_NEAR(back->skeleton.unit, 0.01, 1e-15);
    std::vector<Pose> X(9), Y(static_cast<std::size_t>(back->joint_count()));
    for (int f = 0; f < m.frames; ++f) {
      m.calc_joint_poses(f, X);
      back->calc_joint_poses(f, Y);
      for (std::size_t i = 0; i < 9; ++i) {
        std::string name = m.skeleton.joints[i].name;
        if (i == 0 && !two_roots) name = "root";
        if (i == 2) name = "left_arm";
        std::size_t at = 0;
        while (at < Y.size() && back->skeleton.joints[at].name != name) ++at;
        ASSERT_LT(at, Y.size()) << name;
        EXPECT_LT(norm(Y[at].p - X[i].p), 1e-12) << name;
        for (int r = 0; r < 3; ++r) EXPECT_LT(norm(Y[at].R.row(r) - X[i].R.row(r)), 1e-12) << name;
      }
    }
    EXPECT_FALSE(text.notes.empty());
  }
}

}  // namespace
}  // namespace ugoki::formats
