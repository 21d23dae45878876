// Mechanisms written as URDF and MJCF: they read back equal, MuJoCo opens them, and notes list what is lost.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>
#include <ranges>
#include <set>
#include <sstream>

#include "named_peer.h"
#include "robot_data.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/robot_formats/mjcf.h"
#include "ugoki/robot_formats/robot_file.h"
#include "ugoki/robot_formats/robot_writer.h"
#include "ugoki/robot_formats/urdf.h"

namespace ugoki::robot_formats {
namespace {

/// Random numbers for the test robots.
class Dice {
 public:
  explicit Dice(unsigned seed) : engine_(seed) {}
  double in(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  Vec3 vec(double size) { return {in(-size, size), in(-size, size), in(-size, size)}; }
  Mat3 rotation() { return to_matrix(exp_map(vec(3))); }

 private:
  std::mt19937_64 engine_;
};

/// A random tree of joints of these types, with limits, damping, shapes and everything else that both formats can store.
MechanismSpec random_robot(unsigned seed, const std::vector<JointType>& types, int links = 9) {
  Dice dice(seed);
  MechanismSpec spec;
  spec.name = "robot <" + std::to_string(seed) + "> & \"co\"";
  for (int i = 0; i < links; ++i) {
    LinkSpec l;
    l.name = "link " + std::to_string(i);
    if (i > 0) l.parent = "link " + std::to_string(i / 2);
    l.joint.type = i == 0 ? JointType::floating : types[static_cast<std::size_t>(dice.in(0, 0.999) * static_cast<double>(types.size()))];
    if (i > 0) l.joint.X_PJ = {dice.rotation(), dice.vec(0.5)};
    if (l.joint.type != JointType::planar) l.joint.axis = normalized(dice.vec(1));
    l.joint.axis2 = normalized(cross(l.joint.axis, dice.vec(1)));
    l.joint.pitch = 0.1;
    if (l.joint.type == JointType::revolute || l.joint.type == JointType::prismatic) {
      Dof& f = l.joint.dofs[0];
      f.lower = dice.in(-2, 0);
      f.upper = dice.in(0, 2);
      f.damping = dice.in(0, 1);
      f.friction = dice.in(0, 1);
      f.effort = dice.in(1, 100);
    }
    const Shape body = Shape::box({dice.in(0.05, 0.2), dice.in(0.05, 0.2), dice.in(0.05, 0.2)}, {dice.rotation(), dice.vec(0.2)});
    l.inertia = solid_inertia(body, 900);
    l.shapes = {body, Shape::sphere(dice.in(0.01, 0.1), {Mat3::identity(), dice.vec(0.2)}),
                Shape::cylinder(0.1, 0.3, {dice.rotation(), dice.vec(1)}), Shape::capsule(0.05, dice.vec(0.3), dice.vec(0.3))};
    l.shapes[2].collides = i % 2 == 0;
    if (!l.shapes[2].collides) l.shapes = {l.shapes[0], l.shapes[1], l.shapes[3]};
    spec.links.push_back(std::move(l));
  }
  return spec;
}

double distance(const Pose& a, const Pose& b) {
  double worst = norm(a.p - b.p);
  for (int i = 0; i < 3; ++i) worst = std::max(worst, norm(a.R.row(i) - b.R.row(i)));
  return worst;
}

double difference(const Inertia& a, const Inertia& b) {
  const double x[] = {a.mass, a.h.x, a.h.y, a.h.z, a.I.xx, a.I.yy, a.I.zz, a.I.xy, a.I.xz, a.I.yz};
  const double y[] = {b.mass, b.h.x, b.h.y, b.h.z, b.I.xx, b.I.yy, b.I.zz, b.I.xy, b.I.xz, b.I.yz};
  double size = 1e-300, error = 0;
  for (int i = 0; i < 10; ++i) {
    size = std::max(size, std::fabs(x[i]));
    error = std::max(error, std::fabs(x[i] - y[i]));
  }
  return error / size;
}

/// Properties that expect_equal() compares in addition to the common ones.
enum Compared { common = 0, springs = 1, friction_of_surfaces = 2, filters = 4 };

/// Names of the links of each exclusion, in alphabetical order.
std::set<std::pair<std::string, std::string>> exclusions_of(const Mechanism& m) {
  std::set<std::pair<std::string, std::string>> out;
  for (const auto& [a, b] : m.exclusions()) out.insert(std::minmax(m.link(a).name, m.link(b).name));
  return out;
}

void expect_equal(const Mechanism& a, const Mechanism& b, int compared) {
  for (const Link& l : a.links()) {
    SCOPED_TRACE(l.name);
    const int at = b.find_link(l.name);
    ASSERT_GE(at, 0);
    const Link& o = b.link(at);
    EXPECT_EQ(o.joint.type, l.joint.type);
    EXPECT_LT(distance(o.joint.X_PJ, l.joint.X_PJ), 1e-12);
    if (l.joint.type == JointType::revolute || l.joint.type == JointType::prismatic) EXPECT_LT(norm(o.joint.axis - l.joint.axis), 1e-15);
    EXPECT_LT(difference(l.inertia, o.inertia), 1e-12);
    for (int k = 0; k < l.joint.nv(); ++k) {
      Dof f = l.joint.dofs[static_cast<std::size_t>(k)];
      if ((compared & springs) == 0) f.stiffness = f.rest = f.armature = 0;
      EXPECT_EQ(o.joint.dofs[static_cast<std::size_t>(k)], f);
    }
    ASSERT_EQ(o.shapes.size(), l.shapes.size());
    for (std::size_t k = 0; k < l.shapes.size(); ++k) {
      const Shape &s = l.shapes[k], &t = o.shapes[k];
      EXPECT_EQ(s.type, t.type);
      EXPECT_LT(distance(s.X_BS, t.X_BS), s.type == ShapeType::mesh ? 1e-9 : 1e-12);
      EXPECT_EQ(s.radius, t.radius);
      EXPECT_NEAR(s.half_length, t.half_length, 1e-15);
      EXPECT_LT(norm(s.half_extents - t.half_extents), 1e-15);
      EXPECT_EQ(s.collides, t.collides);
      if ((compared & friction_of_surfaces) != 0 && s.collides) EXPECT_EQ(s.friction, t.friction);
      if (s.geometry) EXPECT_NEAR(s.geometry->solid.mass, t.geometry->solid.mass, 1e-12);
      if ((compared & filters) == 0 || !s.collides) continue;
      EXPECT_EQ(s.groups, t.groups);
      EXPECT_EQ(s.partners, t.partners);
      EXPECT_EQ(s.smooth, t.smooth);
    }
  }
  if ((compared & filters) != 0) EXPECT_EQ(exclusions_of(a), exclusions_of(b));
}

RobotOptions read_options(const RobotText& text) {
  RobotOptions options;
  options.meshes = Meshes::exact;
  for (const SideFile& f : text.files)
    if (f.name.ends_with(".yaml")) options.loops = f;
  options.read_asset = [files = text.files](const std::string& path) -> Result<std::string> {
    for (const SideFile& f : files)
      if (path.ends_with(f.name)) return f.text;
    return fail(ErrorCode::io, path, "The file does not exist.");
  };
  return options;
}

bool reports(const std::vector<std::string>& notes, std::string_view text) {
  return std::ranges::any_of(notes, [&](const std::string& n) { return n.find(text) != std::string::npos; });
}

MechanismPtr made(MechanismSpec spec) {
  Result<MechanismPtr> m = Mechanism::make(std::move(spec));
  EXPECT_TRUE(m.has_value()) << (m ? std::string() : m.error().text());
  return *m;
}

TEST(UrdfWriter, ReadsBackEqual) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    MechanismSpec spec = random_robot(
        seed, {JointType::revolute, JointType::prismatic, JointType::fixed, JointType::spherical, JointType::planar, JointType::floating});
    const Vec3 corners[] = {{0, 0, 0}, {0.3, 0, 0}, {0, 0.2, 0}, {0, 0, 0.1}};
    const Triangle faces[] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    spec.links[3].shapes.push_back(Shape::mesh(*make_geometry(corners, faces, false, "mesh"), spec.links[3].shapes[0].X_BS));
    const MechanismPtr m = made(spec);
    const RobotText text = write_urdf(*m, "robot");
    const auto back = read_urdf(text.text, "robot.urdf", read_options(text));
    ASSERT_TRUE(back.has_value()) << back.error().text() << text.text;
    EXPECT_EQ(back->mechanism->name(), m->name());
    EXPECT_EQ(back->mechanism->link_count(), m->link_count());
    expect_equal(*m, *back->mechanism, common);
  }
}

TEST(UrdfWriter, JointsOfTwoDofsMoveEqually) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    const MechanismPtr m = made(random_robot(seed, {JointType::universal, JointType::cylindrical, JointType::revolute}));
    for (const bool mjcf : {false, true}) {
      const RobotText text = mjcf ? write_mjcf(*m) : write_urdf(*m, "robot");
      const auto back =
          mjcf ? read_mjcf(text.text, "robot.xml", read_options(text)) : read_urdf(text.text, "robot.urdf", read_options(text));
      ASSERT_TRUE(back.has_value()) << back.error().text();
      EXPECT_TRUE(reports(text.notes, "became"));
      ASSERT_EQ(back->mechanism->nq(), m->nq());
      // Links are matched by name; within a link the coordinates have the same order.
      Dice dice(seed + 7);
      State s(*m), t(*back->mechanism);
      std::vector<double> a(s.v.size()), b(s.v.size()), tau(s.v.size());
      for (const Link& l : m->links()) {
        const int at = back->mechanism->find_link(l.name);
        ASSERT_GE(at, 0);
        const int count = l.joint.nv(), first = back->mechanism->link(at).v_index + back->mechanism->link(at).joint.nv() - count;
        const bool many = l.joint.type == JointType::universal || l.joint.type == JointType::cylindrical;
        for (int k = 0; k < count; ++k) {
          const std::size_t i = static_cast<std::size_t>(l.v_index + k);
          const std::size_t j = static_cast<std::size_t>(many ? first + k : back->mechanism->link(at).v_index + k);
          t.v[j] = s.v[i] = dice.in(-1, 1);
          if (l.joint.type != JointType::floating) {
            const std::size_t qi = static_cast<std::size_t>(l.q_index + k);
            const std::size_t qj =
                static_cast<std::size_t>(back->mechanism->link(at).q_index + back->mechanism->link(at).joint.nq() - count + k);
            t.q[qj] = s.q[qi] = dice.in(-1, 1);
          }
        }
      }
      dynamics::Workspace ws(*m), wt(*back->mechanism);
      dynamics::update_kinematics(*m, s.q, s.v, ws);
      dynamics::update_kinematics(*back->mechanism, t.q, t.v, wt);
      EXPECT_NEAR(dynamics::kinetic_energy(*m, ws), dynamics::kinetic_energy(*back->mechanism, wt),
                  1e-9 * dynamics::kinetic_energy(*m, ws));
      for (const Link& l : m->links())
        EXPECT_LT(distance(ws.X_WB[static_cast<std::size_t>(m->find_link(l.name))],
                           wt.X_WB[static_cast<std::size_t>(back->mechanism->find_link(l.name))]),
                  1e-11)
            << l.name;
    }
  }
}

/// Every loop type that the YAML file can store, and gears as <mimic>, keep their loop conditions.
TEST(UrdfWriter, LoopsReadBackEqual) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Dice dice(seed);
    MechanismSpec spec = random_robot(seed, {JointType::revolute});
    int number = 0;
    for (const LoopType type : {LoopType::weld, LoopType::ball, LoopType::revolute, LoopType::prismatic, LoopType::cylindrical,
                                LoopType::planar, LoopType::universal}) {
      LoopSpec loop{.name = "loop " + std::to_string(++number),
                    .type = type,
                    .link_a = "link " + std::to_string(number),
                    .link_b = "link " + std::to_string(8 - number / 2),
                    .X_AJ = {dice.rotation(), dice.vec(1)},
                    .X_BJ = {dice.rotation(), dice.vec(1)},
                    .axis = normalized(dice.vec(1))};
      loop.axis2 = normalized(cross(loop.axis, dice.vec(1)));
      if (loop.link_a == loop.link_b) loop.link_b = "link 0";
      spec.loops.push_back(loop);
    }
    spec.loops.push_back(
        {.name = "gear", .type = LoopType::gear, .link_a = "link 5", .link_b = "link 6", .polynomial = {0.3, -2, 0, 0, 0}});
    spec.loops.push_back({.name = "rope", .type = LoopType::distance, .link_a = "link 5", .link_b = "link 6", .length = 1});
    const MechanismPtr m = made(spec);
    const RobotText text = write_urdf(*m, "robot");
    EXPECT_TRUE(reports(text.notes, "rope"));
    const auto back = read_urdf(text.text, "robot.urdf", read_options(text));
    ASSERT_TRUE(back.has_value()) << back.error().text();
    ASSERT_EQ(back->mechanism->loops().size(), 8u);
    std::vector<Pose> X(9), Y(static_cast<std::size_t>(back->mechanism->link_count()));
    calc_poses(*m, m->neutral(), X);
    calc_poses(*back->mechanism, back->mechanism->neutral(), Y);
    for (const Loop& loop : m->loops()) {
      if (loop.type == LoopType::distance) continue;
      const Loop* same = nullptr;
      for (const Loop& o : back->mechanism->loops())
        if (o.type == loop.type) same = &o;
      ASSERT_NE(same, nullptr);
      if (loop.type == LoopType::gear) {
        EXPECT_EQ(same->polynomial, loop.polynomial);
        continue;
      }
      const Pose A = X[static_cast<std::size_t>(loop.link_a)] * loop.X_AJ, B = X[static_cast<std::size_t>(loop.link_b)] * loop.X_BJ;
      const Pose C = Y[static_cast<std::size_t>(same->link_a)] * same->X_AJ, D = Y[static_cast<std::size_t>(same->link_b)] * same->X_BJ;
      EXPECT_LT(norm(A.p - C.p), 1e-11);
      EXPECT_LT(norm(B.p - D.p), 1e-11);
      EXPECT_LT(norm(A.R * loop.axis - C.R * same->axis), 1e-11);
      if (loop.type == LoopType::universal)
        EXPECT_LT(norm(B.R * loop.axis2 - D.R * same->axis2), 1e-11);
      else
        EXPECT_LT(norm(B.R * loop.axis - D.R * same->axis), 1e-11);
      if (loop.type == LoopType::weld || loop.type == LoopType::prismatic)
        EXPECT_LT(distance({A.R * B.R.transposed(), {}}, {C.R * D.R.transposed(), {}}), 1e-11);
    }
  }
}

TEST(MjcfWriter, ReadsBackEqual) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    MechanismSpec spec = random_robot(seed, {JointType::revolute, JointType::prismatic, JointType::fixed, JointType::spherical});
    spec.links[4].joint.dofs[0].stiffness = 3;
    spec.links[4].joint.dofs[0].armature = 0.2;
    if (spec.links[4].joint.type == JointType::spherical)
      for (std::size_t k = 1; k < 3; ++k) spec.links[4].joint.dofs[k] = spec.links[4].joint.dofs[0];
    if (spec.links[4].joint.type == JointType::fixed) spec.links[4].joint.dofs[0] = {};
    spec.links[5].shapes.push_back(Shape::ellipsoid({0.1, 0.2, 0.3}, spec.links[5].shapes[0].X_BS));
    spec.links[5].shapes[0].friction = 0.3;
    spec.links[5].shapes[0].groups = 0x80000001U;
    spec.links[5].shapes[1].partners = 6;
    spec.links[5].shapes[1].smooth = true;
    spec.exclusions = {{"link 1", "link 8"}, {"link 7", "link 3"}};
    const MechanismPtr m = made(spec);
    const RobotText text = write_mjcf(*m);
    const auto back = read_mjcf(text.text, "robot.xml", read_options(text));
    ASSERT_TRUE(back.has_value()) << back.error().text() << text.text;
    EXPECT_EQ(back->mechanism->name(), m->name());
    EXPECT_EQ(back->mechanism->link_count(), m->link_count());
    expect_equal(*m, *back->mechanism, springs | friction_of_surfaces | filters);
  }
}

TEST(MjcfWriter, EqualitiesReadBackEqual) {
  MechanismSpec spec = random_robot(4, {JointType::revolute});
  for (LinkSpec& l : spec.links) l.joint.X_PJ.R = Mat3::identity();
  const MechanismPtr tree = made(spec);
  std::vector<Pose> X(9);
  calc_poses(*tree, tree->neutral(), X);
  Dice dice(4);
  const auto at = [&](int link, const Pose& X_W) { return X[static_cast<std::size_t>(link)].inverse() * X_W; };
  const Pose location{dice.rotation(), dice.vec(1)};
  spec.loops = {{.name = "weld",
                 .type = LoopType::weld,
                 .link_a = "link 3",
                 .link_b = "link 6",
                 .X_AJ = {dice.rotation(), dice.vec(1)},
                 .X_BJ = {dice.rotation(), dice.vec(1)}},
                {.name = "ball",
                 .type = LoopType::ball,
                 .link_a = "link 3",
                 .link_b = "link 7",
                 .X_AJ = at(3, location),
                 .X_BJ = at(7, location),
                 .closed = false},
                {.name = "hinge",
                 .type = LoopType::revolute,
                 .link_a = "link 4",
                 .link_b = "link 8",
                 .X_AJ = at(4, location),
                 .X_BJ = at(8, location),
                 .axis = {1, 0, 0}},
                {.name = "gear", .type = LoopType::gear, .link_a = "link 5", .link_b = "link 6", .polynomial = {0.1, 2, 0.3, 0, 0}},
                {.name = "rail", .type = LoopType::prismatic, .link_a = "link 5", .link_b = "link 6"},
                {.name = "open", .type = LoopType::ball, .link_a = "link 5", .link_b = "link 6", .X_AJ = {Mat3::identity(), {9, 9, 9}}}};
  const MechanismPtr m = made(spec);
  const RobotText text = write_mjcf(*m);
  EXPECT_TRUE(reports(text.notes, "rail"));
  EXPECT_TRUE(reports(text.notes, "open"));
  EXPECT_TRUE(reports(text.notes, "hinge"));
  const auto back = read_mjcf(text.text, "robot.xml", read_options(text));
  ASSERT_TRUE(back.has_value()) << back.error().text();
  const auto loops = back->mechanism->loops();
  ASSERT_EQ(loops.size(), 5u);
  const Loop &weld = loops[static_cast<std::size_t>(back->mechanism->find_loop("weld"))], &was = m->loops()[0];
  EXPECT_LT(distance(weld.X_AJ * weld.X_BJ.inverse(), was.X_AJ * was.X_BJ.inverse()), 1e-12);
  const Loop& ball = loops[static_cast<std::size_t>(back->mechanism->find_loop("ball"))];
  EXPECT_FALSE(ball.closed);
  EXPECT_LT(norm(ball.X_AJ.p - m->loops()[1].X_AJ.p), 1e-12);
  EXPECT_LT(norm(ball.X_BJ.p - m->loops()[1].X_BJ.p), 1e-12);
  EXPECT_EQ(loops[static_cast<std::size_t>(back->mechanism->find_loop("gear"))].polynomial, m->loops()[3].polynomial);
}

/// Returns random position coordinates of a mechanism, [frames * nq].
std::vector<double> random_motion(const Mechanism& m, int frames, unsigned seed) {
  Dice dice(seed);
  std::vector<double> out, q(static_cast<std::size_t>(m.nq())), v(static_cast<std::size_t>(m.nv()));
  for (int f = 0; f < frames; ++f) {
    for (double& x : v) x = dice.in(-1, 1);
    integrate(m, m.neutral(), v, 1, q);
    out.insert(out.end(), q.begin(), q.end());
  }
  return out;
}

const std::vector<JointType> all_joint_types = {JointType::revolute,  JointType::prismatic,   JointType::spherical, JointType::planar,
                                                JointType::universal, JointType::cylindrical, JointType::helical,   JointType::fixed};

/// The poses of the links, computed from the URDF and the motion table beside it, equal the poses of the motion.
TEST(UrdfWriter, MotionGivesThePosesOfTheLinks) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE(seed);
    const MechanismPtr m = made(random_robot(seed, all_joint_types));
    const std::vector<double> motion = random_motion(*m, 3, seed);
    const RobotText text = write_urdf(*m, "robot", {50, motion});
    const auto back = read_urdf(text.text, "robot.urdf", read_options(text));
    ASSERT_TRUE(back.has_value()) << back.error().text();
    const Mechanism& read = *back->mechanism;
    const auto table = std::ranges::find(text.files, std::string("robot-motion.csv"), &SideFile::name);
    ASSERT_NE(table, text.files.end());
    std::istringstream lines(table->text);
    const auto cells = [&] {
      std::string line, cell;
      std::getline(lines, line);
      std::vector<std::string> out;
      for (std::istringstream in(line); std::getline(in, cell, ',');) out.push_back(cell);
      return out;
    };
    const std::vector<std::string> head = cells();
    for (std::size_t f = 0; f < 3; ++f) {
      const std::vector<std::string> row = cells();
      ASSERT_EQ(row.size(), head.size());
      EXPECT_EQ(std::stod(row[0]), 0.02 * static_cast<double>(f));
      std::vector<double> q = read.neutral();
      for (const Link& l : read.links()) {
        const std::string joint = l.name + (l.parent < 0 && l.joint.type == JointType::floating ? "" : "_joint");
        int k = 0;
        for (std::size_t c = 1; c < head.size(); ++c)
          if (head[c] == joint || head[c].starts_with(joint + ".")) q[static_cast<std::size_t>(l.q_index + k++)] = std::stod(row[c]);
        EXPECT_EQ(k, l.joint.nq()) << l.name;
      }
      std::vector<Pose> X(m->links().size()), Y(read.links().size());
      calc_poses(*m, std::span(motion).subspan(f * static_cast<std::size_t>(m->nq()), static_cast<std::size_t>(m->nq())), X);
      calc_poses(read, q, Y);
      for (std::size_t l = 0; l < X.size(); ++l) {
        const int at = read.find_link(m->link(static_cast<int>(l)).name);
        ASSERT_GE(at, 0);
        EXPECT_LT(distance(X[l], Y[static_cast<std::size_t>(at)]), 1e-9) << m->link(static_cast<int>(l)).name;
      }
    }
  }
}

#ifdef UGOKI_HAVE_MUJOCO
/// In every keyframe, MuJoCo computes the same poses of the bodies as in the motion.
TEST(WriterPeer, MujocoReadsTheMotionOfEveryJointType) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE(seed);
    MechanismSpec spec = random_robot(seed, all_joint_types);
    spec.links[0].joint.X_PJ = {to_matrix(exp_map({0.3, 0.2, -0.5})), {1, 2, 3}};  // MuJoCo has no such frame for a free joint
    const MechanismPtr m = made(spec);
    const std::vector<double> motion = random_motion(*m, 4, seed);
    std::string why;
    const MujocoModel peer = open_in_mujoco(write_mjcf(*m, {50, motion}).text, why);
    ASSERT_TRUE(peer) << why;
    ASSERT_EQ(peer->nkey, 4);
    const std::unique_ptr<mjData, void (*)(mjData*)> data(mj_makeData(peer.get()), mj_deleteData);
    for (int f = 0; f < 4; ++f) {
      EXPECT_EQ(peer->key_time[f], 0.02 * f);
      mj_resetDataKeyframe(peer.get(), data.get(), f);
      mj_kinematics(peer.get(), data.get());
      std::vector<Pose> X(m->links().size());
      const auto nq = static_cast<std::size_t>(m->nq());
      calc_poses(*m, std::span(motion).subspan(static_cast<std::size_t>(f) * nq, nq), X);
      for (std::size_t l = 0; l < X.size(); ++l) {
        const std::string& name = m->link(static_cast<int>(l)).name;
        const int body = mj_name2id(peer.get(), mjOBJ_BODY, name.c_str());
        ASSERT_GE(body, 0) << name;
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(data->xpos[3 * body + k], X[l].p[k], 1e-9) << name << " in frame " << f;
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 3; ++c) EXPECT_NEAR(data->xmat[9 * body + 3 * r + c], X[l].R.column(c)[r], 1e-9) << name << " in frame " << f;
      }
    }
  }
}

/// MuJoCo opens the written files and computes the same poses, inertia matrix and accelerations.
TEST(WriterPeer, MujocoAgrees) {
  for (unsigned seed = 1; seed <= 12; ++seed)
    for (const bool mjcf : {true, false}) {
      SCOPED_TRACE(std::string(mjcf ? "MJCF " : "URDF ") + std::to_string(seed));
      MechanismSpec spec =
          random_robot(seed, mjcf ? std::vector{JointType::revolute, JointType::prismatic, JointType::spherical, JointType::fixed}
                                  : std::vector{JointType::revolute, JointType::prismatic, JointType::fixed});
      for (LinkSpec& l : spec.links) {
        if (!mjcf) l.shapes.clear();  // MuJoCo's URDF reader does not support capsules
        for (Dof& f : l.joint.dofs) f.damping = f.friction = 0;
      }
      RobotModel model;
      model.mechanism = made(spec);
      model.X_BF.resize(9);
      std::string text = mjcf ? write_mjcf(*model.mechanism).text : write_urdf(*model.mechanism, "robot").text;
      if (!mjcf) {
        text.insert(text.find("<link"),
                    "<mujoco><compiler fusestatic=\"false\" balanceinertia=\"false\" boundmass=\"0\" boundinertia=\"0\"/></mujoco>");
        // MuJoCo fixes the root link of a URDF, so a link "world" with a floating joint is added.
        text.insert(
            text.find("</robot>"),
            "<link name=\"world\"/><joint name=\"base\" type=\"floating\"><parent link=\"world\"/><child link=\"link 0\"/></joint>");
      }
      std::string why;
      const MujocoModel theirs = open_in_mujoco(text, why);
      ASSERT_TRUE(theirs) << why;
      NamedPeer peer(model, *theirs);
      ASSERT_EQ(peer.mismatch(), "");
      std::mt19937 random(seed);
      Disagreement worst;
      for (int k = 0; k < 5; ++k) peer.compare(random, worst);
      EXPECT_LT(worst.pose, 1e-9);
      EXPECT_LT(worst.inertia, 1e-6);  // MuJoCo's principal axes are accurate to about 1e-6
      EXPECT_LT(worst.inverse, 1e-6);
      EXPECT_LT(worst.forward, 1e-5);
    }
}
#endif

/// Whether the format can store this shape.
bool can_store(const Shape& s, bool mjcf) { return s.type != ShapeType::height_field && (mjcf || s.type != ShapeType::ellipsoid); }

/// Equality of shape poses. Round shapes may be rotated about their own axis, and flipped end to end.
bool same_pose(const Shape& a, const Shape& b) {
  if (a.type == ShapeType::box || a.type == ShapeType::ellipsoid) return distance(a.X_BS, b.X_BS) < 1e-9;
  const bool axis = a.type == ShapeType::sphere || std::fabs(dot(a.X_BS.R.column(2), b.X_BS.R.column(2))) > 1 - 1e-12;
  return axis && norm(a.X_BS.p - b.X_BS.p) < 1e-9;
}

/// Compares the properties of real mechanisms that the formats can store: poses, axes, masses, limits, damping, friction, effort limits
/// and shapes.
void expect_kept(const Mechanism& m, const Mechanism& back, bool mjcf) {
  std::vector<Pose> X(static_cast<std::size_t>(m.link_count())), Y(static_cast<std::size_t>(back.link_count()));
  calc_poses(m, m.neutral(), X);
  calc_poses(back, back.neutral(), Y);
  for (const Link& l : m.links()) {
    SCOPED_TRACE(l.name);
    const int at = back.find_link(l.name);
    if (at < 0 && l.name == "world" && l.joint.type == JointType::fixed && l.inertia.mass == 0) continue;
    ASSERT_GE(at, 0);
    const Link& o = back.link(at);
    EXPECT_LT(distance(X[static_cast<std::size_t>(m.find_link(l.name))], Y[static_cast<std::size_t>(at)]), 1e-9);
    EXPECT_LT(difference(l.inertia, o.inertia), 1e-9);
    if (l.joint.type == JointType::revolute || l.joint.type == JointType::prismatic) {
      ASSERT_EQ(o.joint.type, l.joint.type);
      EXPECT_LT(norm(o.joint.axis - l.joint.axis), 1e-12);
      const Dof &f = l.joint.dofs[0], &g = o.joint.dofs[0];
      EXPECT_EQ(g.lower, f.lower);
      EXPECT_EQ(g.upper, f.upper);
      EXPECT_EQ(g.damping, f.damping);
      EXPECT_EQ(g.friction, f.friction);
      EXPECT_EQ(g.effort, f.effort);
      if (mjcf) {
        EXPECT_EQ(g.stiffness, f.stiffness);
        EXPECT_EQ(g.rest, f.rest);
        EXPECT_EQ(g.armature, f.armature);
      }
    }
    for (const Shape& h : l.shapes) {  // URDF stores collision and visual shapes separately; only the former are compared
      if (!can_store(h, mjcf) || !h.collides) continue;
      EXPECT_TRUE(std::ranges::any_of(o.shapes, [&](const Shape& s) {
        return s.collides && s.type == h.type && s.radius == h.radius && std::fabs(s.half_length - h.half_length) < 1e-12 &&
               norm(s.half_extents - h.half_extents) < 1e-12 && same_pose(s, h);
      }));
    }
  }
}

std::filesystem::recursive_directory_iterator folder_of(const std::string& name) {
  std::error_code absent;
  return std::filesystem::recursive_directory_iterator(std::string(UGOKI_SHARED_DATA) + name, absent);
}

/// Every shared description is written in both formats and reads back equal, except for what the format cannot store.
TEST(Writers, SharedDescriptions) {
  int count = 0;
  for (const std::filesystem::directory_entry& e : folder_of("/mechanism")) {
    const std::string ending = e.path().extension().string();
    if (ending != ".urdf" && ending != ".xml" && ending != ".sdf") continue;
    SCOPED_TRACE(e.path());
    RobotOptions options = options_for(e.path().string());
    options.meshes = Meshes::none;
    const std::string text = load_robot(e.path().string());
    if (!robot_format_of(text)) continue;
    const auto model = read_robot_file(text, e.path().string(), options);
    if (!model) continue;  // refused; the tests of the readers check this
    const Mechanism& m = *model->mechanism;
    for (const bool mjcf : {true, false}) {
      SCOPED_TRACE(mjcf ? "as MJCF" : "as URDF");
      const RobotText written = mjcf ? write_mjcf(m) : write_urdf(m, "robot");
      const auto back =
          mjcf ? read_mjcf(written.text, "robot.xml", read_options(written)) : read_urdf(written.text, "robot.urdf", read_options(written));
      ASSERT_TRUE(back.has_value()) << back.error().text();
      EXPECT_NEAR(back->mechanism->mass(), m.mass(), 1e-9 * m.mass());
      int helical = 0;
      for (const Link& l : m.links()) helical += l.joint.type == JointType::helical;
      EXPECT_EQ(back->mechanism->nv(), m.nv() + helical);
      expect_kept(m, *back->mechanism, mjcf);
      ++count;
    }
  }
  RecordProperty("written_and_read", count);
  if (count == 0) GTEST_SKIP() << "the shared data are missing";
}

}  // namespace
}  // namespace ugoki::robot_formats
