// The MJCF reader on small models with known results: inertia, names, defaults, asset files, actuators, loops, keyframes, notes.

#include "ugoki/robot_formats/mjcf.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "mjcf_data.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/robot_formats/mjcf_mesh.h"

namespace ugoki::robot_formats {
namespace {

RobotModel read(const std::string& body, const RobotOptions& options = {}) {
  auto m = read_mjcf("<mujoco model='m'>" + body + "</mujoco>", "m.xml", options);
  EXPECT_TRUE(m.has_value()) << (m ? std::string() : m.error().text());
  return m ? std::move(*m) : RobotModel{};
}

/// A body on a hinge about y, with the given content.
std::string swing(const std::string& content, const std::string& name = "arm") {
  return "<body name='" + name + "'><joint name='hinge_" + name + "' axis='0 1 0'/>" + content + "</body>";
}
std::string world(const std::string& content) { return "<worldbody>" + content + "</worldbody>"; }

const Link& link(const RobotModel& m, const std::string& name) {
  const int i = m.mechanism->find_link(name);
  EXPECT_GE(i, 0) << "no link " << name;
  return m.mechanism->link(std::max(i, 0));
}

bool has_note(const RobotModel& m, const std::string& part) {
  return std::ranges::any_of(m.notes, [&](const std::string& n) { return n.find(part) != std::string::npos; });
}

/// Options whose file reader finds only these files.
RobotOptions with_files(const std::map<std::string, std::string>& files) {
  RobotOptions options;
  options.read_asset = [files](const std::string& path) -> Result<std::string> {
    const auto it = files.find(path);
    if (it == files.end()) return fail(ErrorCode::io, path, "the file does not exist.", "Copy it there.");
    return it->second;
  };
  return options;
}

void expect_moments(const Sym3& I, double xx, double yy, double zz) {
  EXPECT_NEAR(I.xx, xx, 1e-12 * (1 + xx));
  EXPECT_NEAR(I.yy, yy, 1e-12 * (1 + yy));
  EXPECT_NEAR(I.zz, zz, 1e-12 * (1 + zz));
  EXPECT_NEAR(std::fabs(I.xy) + std::fabs(I.xz) + std::fabs(I.yz), 0, 1e-12);
}

TEST(Mjcf, InertiaOfGeoms) {
  const double r = 0.2, h = 0.3, rho = 500;
  const RobotModel m =
      read(world(swing("<geom type='cylinder' size='0.2 0.3' density='500'/>", "cylinder") +
                 swing("<geom type='ellipsoid' size='0.1 0.2 0.3' mass='2'/>", "ellipsoid") +
                 swing("<geom type='sphere' size='0.2' mass='3' pos='1 0 0'/>", "sphere") +
                 swing("<geom type='capsule' size='0.1' fromto='0 0 0 2 0 0' density='500'/>", "capsule") +
                 swing("<geom type='box' size='0.1 0.2 0.3' mass='6'/><geom type='sphere' size='1' density='0'/>", "box")));
  const Inertia c = link(m, "cylinder").inertia;
  EXPECT_NEAR(c.mass, rho * pi * r * r * 2 * h, 1e-12);
  expect_moments(c.I, c.mass * (3 * r * r + 4 * h * h) / 12, c.mass * (3 * r * r + 4 * h * h) / 12, c.mass * r * r / 2);
  expect_moments(link(m, "ellipsoid").inertia.I, 0.4 * (0.04 + 0.09), 0.4 * (0.01 + 0.09), 0.4 * (0.01 + 0.04));
  expect_moments(link(m, "sphere").inertia.I, 0.4 * 3 * r * r, 0.4 * 3 * r * r + 3, 0.4 * 3 * r * r + 3);
  EXPECT_NEAR(link(m, "capsule").inertia.mass, 500 * (pi * 0.01 * 2 + 4.0 / 3.0 * pi * 0.001), 1e-12);
  EXPECT_NEAR(link(m, "capsule").inertia.centre().x, 1, 1e-14);
  expect_moments(link(m, "box").inertia.I, 2 * (0.04 + 0.09), 2 * (0.01 + 0.09), 2 * (0.01 + 0.04));
  EXPECT_EQ(link(m, "cylinder").shapes.at(0).type, ShapeType::cylinder);
}

TEST(Mjcf, SeveralJointsBecomeAChain) {
  const RobotModel m = read(world(
      "<body name='leg' pos='0 0 1'><joint name='swing' axis='0 1 0' pos='0 0 0.1'/><joint type='slide' axis='1 0 0' range='-0.1 0.2'/>"
      "<joint name='twist' axis='0 0 1' pos='0.1 0 -0.2'/><geom size='0.1' pos='0.3 0 0'/><body name='foot' pos='0 0 -1'><geom "
      "size='0.1'/></body></body>"));
  const Mechanism& k = *m.mechanism;
  ASSERT_EQ(k.link_count(), 4);
  EXPECT_EQ(k.link(0).name, "leg:swing");
  EXPECT_EQ(k.link(1).name, "leg:2");
  EXPECT_EQ(k.link(2).name, "leg");
  EXPECT_EQ(k.link(1).parent, 0);
  EXPECT_EQ(k.link(0).inertia.mass, 0);
  EXPECT_EQ(k.link(1).joint.type, JointType::prismatic);
  EXPECT_EQ(k.link(1).joint.dofs[0].lower, -0.1);
  EXPECT_EQ(k.link(3).joint.type, JointType::fixed);
  ASSERT_EQ(m.joints.size(), 2U);
  EXPECT_EQ(m.joints[0].link, "leg:swing");
  EXPECT_EQ(m.joints[1].link, "leg");
  // The frame of the body `leg` at q = 0, and after quarter turns.
  std::vector<Pose> X(4);
  std::vector<double> q = k.neutral();
  calc_poses(k, q, X);
  EXPECT_NEAR(norm((X[2] * m.X_BF[2]).p - Vec3{0, 0, 1}), 0, 1e-15);
  EXPECT_NEAR(norm((X[3] * m.X_BF[3]).p - Vec3{0, 0, 0}), 0, 1e-15);
  q = {pi / 2, 0.2, pi / 2};
  calc_poses(k, q, X);
  // The last joint (a hinge at (0.1, 0)) moves the body's origin to (0.1, -0.1, 0). The slide moves it to (0.3, -0.1, 0). The first hinge
  // turns z to x, and x down.
  EXPECT_NEAR(norm((X[2] * m.X_BF[2]).p - Vec3{-0.1, -0.1, 0.8}), 0, 1e-15);
  EXPECT_NEAR(norm((X[2] * m.X_BF[2]) * Vec3{0.3, 0, 0} - Vec3{-0.1, 0.2, 0.8}), 0, 1e-15);
}

TEST(Mjcf, CoordinatesAreZeroInThePoseOfTheFile) {
  const RobotModel m =
      read("<compiler angle='degree'/>" +
           world("<body name='base' pos='1 2 3' euler='0 0 90'><freejoint/><geom size='0.1'/><body name='arm'><joint name='j' ref='30' "
                 "range='0 90' "
                 "springref='45' stiffness='1'/><geom size='0.1'/><body name='hand'><joint name='b' type='ball' range='0 60'/><geom "
                 "size='0.1'/></body></body></body>") +
           "<keyframe><key name='home' qpos='1 2 4 0.5 0.5 0.5 0.5 60 0 0 0 1'/><key qpos='1 2 3 1 0 0 1 0 1 0 0 0'/></keyframe>");
  const Dof& f = link(m, "arm").joint.dofs[0];
  EXPECT_NEAR(f.lower, -pi / 6, 1e-15);
  EXPECT_NEAR(f.upper, pi / 3, 1e-15);
  EXPECT_NEAR(f.rest, pi / 12, 1e-15);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(link(m, "hand").joint.dofs[static_cast<std::size_t>(i)].upper, pi / 3, 1e-15);
  EXPECT_EQ(link(m, "base").joint.X_PJ.p, (Vec3{1, 2, 3}));
  ASSERT_EQ(m.positions.size(), 2U);
  EXPECT_EQ(m.positions[0].name, "home");
  EXPECT_EQ(m.positions[1].name, "key_2");
  const std::vector<double>& q = m.positions[0].q;
  ASSERT_EQ(q.size(), 12U);
  const Pose X = link(m, "base").joint.X_PJ * joint_pose(link(m, "base").joint, q.data());
  EXPECT_NEAR(norm(X.p - Vec3{1, 2, 4}), 0, 1e-14);
  EXPECT_NEAR(norm(X.R * Vec3{1, 0, 0} - Vec3{0, 1, 0}), 0, 1e-14) << "a third of a turn about (1, 1, 1)";
  EXPECT_NEAR(q[7], 60 - pi / 6, 1e-14) << "keyframes are in radians, whatever the file's angles are";
  EXPECT_NEAR(q[11], 1, 1e-15);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(m.positions[1].q[i], 0, 1e-14);
  EXPECT_NEAR(m.positions[1].q[3], 1, 1e-14) << "the base has its pose of the file";
}

TEST(Mjcf, DefaultClassesInheritAndOverride) {
  const RobotModel m = read(
      "<default><joint damping='1' armature='2'/><geom size='0.1 0.2 0.3'/><default class='a'><joint damping='3'/><default "
      "class='b'><joint "
      "frictionloss='4'/><geom type='box' size='0.5'/></default></default><default class='c'><joint armature='5'/></default></default>"
      "<default><joint stiffness='6'/></default>" +
      world("<body name='one' childclass='b'><joint/><geom/><body name='two'><joint class='c'/><geom class='main' type='capsule'/></body>"
            "<frame childclass='a'><body name='three'><joint/><geom/></body></frame></body>"));
  const Dof one = link(m, "one").joint.dofs[0], two = link(m, "two").joint.dofs[0], three = link(m, "three").joint.dofs[0];
  EXPECT_EQ(one.damping, 3);
  EXPECT_EQ(one.friction, 4);
  EXPECT_EQ(one.armature, 2);
  EXPECT_EQ(one.stiffness, 6) << "a second <default> adds to the first";
  EXPECT_EQ(two.damping, 1);
  EXPECT_EQ(two.armature, 5);
  EXPECT_EQ(two.friction, 0) << "class='c' replaces the childclass";
  EXPECT_EQ(three.damping, 3);
  EXPECT_EQ(three.friction, 0);
  EXPECT_EQ(link(m, "one").shapes[0].half_extents, (Vec3{0.5, 0.2, 0.3})) << "a shorter size keeps the rest of the inherited one";
  EXPECT_EQ(link(m, "two").shapes[0].half_length, 0.2);
}

TEST(Mjcf, OutermostDefaultClassMayHaveAName) {
  // In exported models the outermost default class often has the robot's name instead of "main". Bodies and elements select the class
  // by this name.
  const std::string tree = world(
      "<body name='one' childclass='ed209'><joint/><geom/><body name='two'><joint class='leg'/><geom/></body>"
      "<body name='three'><joint class='main'/><geom class='ed209'/></body></body>"
      "<body name='four'><joint/><geom/></body>");
  const RobotModel m = read(
      "<default class='ed209'><joint damping='1' armature='2'/><geom size='0.3'/>"
      "<default class='leg'><joint damping='3'/></default></default><default class='ed209'><joint stiffness='6'/>"
      "</default>" +
      tree);
  for (const char* name : {"one", "two", "three", "four"}) {
    const Dof dof = link(m, name).joint.dofs[0];
    EXPECT_EQ(dof.damping, std::string(name) == "two" ? 3 : 1) << name << ": elements without a class use the outermost class";
    EXPECT_EQ(dof.armature, 2) << name;
    EXPECT_EQ(dof.stiffness, 6) << name;
    EXPECT_EQ(link(m, name).shapes[0].radius, 0.3) << name;
  }
  const RobotModel nested = read(
      "<default><default class='ed209'><joint damping='1' armature='2'/><geom size='0.3'/></default>"
      "<default class='leg'><joint damping='3'/></default></default>" +
      world("<body name='one' childclass='ed209'><joint/><geom/></body>"));
  EXPECT_EQ(link(nested, "one").joint.dofs[0].damping, 1);
  EXPECT_EQ(link(nested, "one").shapes[0].radius, 0.3);
}

TEST(Mjcf, Orientations) {
  const auto turned = [](const std::string& compiler, const std::string& attribute) {
    const RobotModel m = read(compiler + world("<body name='b' " + attribute + "><joint/><geom size='0.1'/></body>"));
    return link(m, "b").joint.X_PJ.R;
  };
  const auto expect = [](const Mat3& R, const Vec3& x, const Vec3& z) {
    EXPECT_NEAR(norm(R.column(0) - x), 0, 1e-15);
    EXPECT_NEAR(norm(R.column(2) - z), 0, 1e-15);
  };
  expect(turned("", "quat='2 0 0 2'"), {0, 1, 0}, {0, 0, 1});
  expect(turned("", "axisangle='0 0 5 90'"), {0, 1, 0}, {0, 0, 1});
  expect(turned("<compiler angle='radian'/>", "axisangle='0 0 5 1.5707963267948966'"), {0, 1, 0}, {0, 0, 1});
  expect(turned("", "xyaxes='0 2 0 -1 3 0'"), {0, 1, 0}, {0, 0, 1});
  expect(turned("", "zaxis='0 0 -3'"), {1, 0, 0}, {0, 0, -1});
  expect(turned("", "zaxis='2 0 0'"), {0, 0, -1}, {1, 0, 0});
  expect(turned("", "euler='90 90 0'"), {0, 1, 0}, {1, 0, 0} /* x, then the turned y */);
  expect(turned("<compiler eulerseq='XYZ'/>", "euler='90 90 0'"), {0, 0, -1}, {0, -1, 0} /* x, then the old y */);
  // as in MuJoCo, a class's euler overrides an element's quat
  const RobotModel m = read("<default><geom type='box' euler='0 0 90'/></default>" + world(swing("<geom size='1 2 3' quat='1 0 0 0'/>")));
  EXPECT_NEAR(link(m, "arm").inertia.I.xx, 8000 * 6 * (1 + 9) / 3.0, 1e-6);
}

TEST(Mjcf, FramesAndReplicates) {
  const RobotModel m = read(
      world("<frame pos='1 0 0' euler='0 0 90'><frame pos='1 0 0'><body name='a' pos='1 0 0'><joint axis='1 0 0'/><geom "
            "size='0.1'/></body></frame></frame>"
            "<replicate count='12' offset='1 0 0' sep='_' euler='0 0 90'><body name='r' pos='0 0 1'><freejoint name='f'/><geom size='0.1'/>"
            "<replicate count='2' offset='0 0 1'><site name='s'/></replicate></body></replicate>"));
  EXPECT_NEAR(norm(link(m, "a").joint.X_PJ.p - Vec3{1, 2, 0}), 0, 1e-15);
  EXPECT_EQ(m.mechanism->link_count(), 13);
  EXPECT_NEAR(norm(link(m, "r_00").joint.X_PJ.p - Vec3{0, 0, 1}), 0, 1e-15);
  EXPECT_NEAR(norm(link(m, "r_02").joint.X_PJ.p - Vec3{1, 1, 1}), 0, 1e-15) << "each offset is along the rotated axes";
  EXPECT_NEAR(norm(link(m, "r_11").joint.X_PJ.R * Vec3{1, 0, 0} - Vec3{0, -1, 0}), 0, 1e-14);
  EXPECT_EQ(m.joints[0].joint, "f_00");
}

TEST(Mjcf, NestedReplicatesPutTheInnerSuffixFirst) {
  const RobotModel m =
      read(world("<replicate count='3' offset='10 0 0'><replicate count='2' offset='1 0 0'><body name='n'><freejoint/><geom "
                 "size='0.1'/></body></replicate></replicate>"));
  EXPECT_EQ(m.mechanism->link_count(), 6);
  EXPECT_EQ(link(m, "n10").joint.X_PJ.p.x, 1);
  EXPECT_EQ(link(m, "n01").joint.X_PJ.p.x, 10);
}

TEST(Mjcf, ReferencesToReplicatesAreReplicated) {
  const RobotModel m =
      read(world("<site name='ceiling'/><replicate count='3' offset='1 0 0'><body name='b'><joint name='j' axis='0 1 0'/><joint "
                 "name='k' axis='1 0 0'/><geom size='0.1' pos='0 0 1'/><site name='tip'/></body></replicate>") +
           "<equality><connect name='c' site1='ceiling' site2='tip'/><joint joint1='j' joint2='k'/></equality>"
           "<actuator><motor joint='j' ctrlrange='-2 2'/></actuator>");
  ASSERT_EQ(m.mechanism->loops().size(), 6U);
  EXPECT_EQ(m.mechanism->loops()[2].name, "c2");
  EXPECT_EQ(m.mechanism->loops()[2].link_b, m.mechanism->find_link("b2"));
  EXPECT_EQ(m.mechanism->loops()[3].type, LoopType::gear);
  EXPECT_EQ(m.driven.size(), 3U);
  EXPECT_EQ(link(m, "b1:j1").joint.dofs[0].effort, 2);
}

TEST(Mjcf, IncludesAreSplicedInPlace) {
  const std::string text =
      "<mujoco><include file='defaults.xml'/><worldbody><body name='b'><include file='sub/inside.xml'/></body></worldbody></mujoco>";
  const auto m = read_mjcf(text, "robots/m.xml",
                           with_files({{"robots/defaults.xml", "<mujoco><default><joint damping='7'/></default></mujoco>"},
                                       {"robots/sub/inside.xml", "<anything><joint/><include file='geom.xml'/></anything>"},
                                       {"robots/geom.xml", "<mujocoinclude><geom size='0.1'/></mujocoinclude>"}}));
  ASSERT_TRUE(m.has_value()) << m.error().text();
  EXPECT_EQ(m->mechanism->link(0).joint.dofs[0].damping, 7);
  EXPECT_GT(m->mechanism->mass(), 0);
  EXPECT_EQ(m->mechanism->name(), "m");
}

TEST(Mjcf, AttachedModelsKeepTheirOwnSettings) {
  const std::string hand =
      "<mujoco model='hand'><compiler angle='radian'/><default><joint range='0 1' damping='2'/></default><worldbody><body name='palm' "
      "pos='0 0 1'>"
      "<joint name='wrist' axis='1 0 0'/><geom size='0.1'/><body name='finger'><joint name='knuckle' axis='0 1 0'/><geom size='0.1' pos='0 "
      "0 1'/></body></body>"
      "<body name='other'><joint name='spare'/><geom size='0.1'/></body></worldbody>"
      "<equality><joint name='grip' joint1='knuckle' joint2='wrist'/><joint joint1='spare' joint2='wrist'/></equality>"
      "<actuator><motor joint='knuckle' gear='3' ctrlrange='-1 1'/></actuator></mujoco>";
  const RobotModel m = read("<asset><model file='hand.xml'/></asset><default><joint damping='9'/></default>" +
                                world(swing("<geom size='0.1'/><frame pos='1 0 0'><attach model='hand' body='palm' prefix='left_'/></frame>"
                                            "<attach model='hand' prefix='right_'/>")),
                            with_files({{"hand.xml", hand}}));
  EXPECT_EQ(m.mechanism->link_count(), 6);
  EXPECT_EQ(link(m, "left_palm").joint.dofs[0].damping, 2);
  EXPECT_EQ(link(m, "left_palm").joint.dofs[0].upper, 1) << "radians there, degrees here";
  EXPECT_EQ(link(m, "arm").joint.dofs[0].damping, 9);
  EXPECT_NEAR(norm(link(m, "left_palm").joint.X_PJ.p - Vec3{1, 0, 1}), 0, 1e-15);
  EXPECT_EQ(link(m, "left_finger").joint.dofs[0].effort, 3);
  ASSERT_EQ(m.mechanism->loops().size(), 3U) << "the spare joint is not part of the left hand";
  EXPECT_EQ(m.mechanism->loops()[0].name, "left_grip");
  EXPECT_TRUE(has_note(m, "of an attached model is left out"));
}

TEST(Mjcf, EffortLimitsOfActuators) {
  const auto effort = [](const std::string& actuators, const std::string& joint = "", const std::string& defaults = "") {
    const RobotModel m = read(defaults + world("<body name='b'><joint name='j' " + joint + "/><geom size='0.1'/></body>") + "<actuator>" +
                              actuators + "</actuator>");
    return link(m, "b").joint.dofs[0].effort;
  };
  const double none = std::numeric_limits<double>::infinity();
  EXPECT_EQ(effort(""), none);
  EXPECT_EQ(effort("<motor joint='j' gear='-5' ctrlrange='-2 1'/>"), 10);
  EXPECT_EQ(effort("<motor joint='j' gear='5'/>"), none);
  EXPECT_EQ(effort("<motor joint='j' gear='5' ctrlrange='-1 1' ctrllimited='false'/>"), none);
  EXPECT_EQ(effort("<position joint='j' kp='100' ctrlrange='-1 1'/>"), none) << "ctrlrange of a position servo is not a force";
  EXPECT_EQ(effort("<position joint='j' gear='2' ctrlrange='-1 1' forcerange='-7 7'/>"), 14);
  EXPECT_EQ(effort("<general joint='j' gainprm='4' ctrlrange='-1 2'/>"), 8);
  EXPECT_EQ(effort("<general joint='j' gainprm='4' biastype='affine' biasprm='0 -4' ctrlrange='-1 2'/>"), none);
  EXPECT_EQ(effort("<motor joint='j' ctrlrange='-1 1'/><motor joint='j' gear='2' ctrlrange='-1 1'/>"), 3)
      << "limits of several actuators are added";
  EXPECT_EQ(effort("<motor joint='j' ctrlrange='-9 9'/>", "actuatorfrcrange='-5 4'"), 5);
  EXPECT_EQ(effort("<motor joint='j' class='weak'/>", "",
                   "<default><motor gear='3'/><default class='weak'><general ctrlrange='-1 1'/></default></default>"),
            3)
      << "all kinds of actuators share their defaults";
  EXPECT_EQ(effort("<motor joint='j' ctrlrange='-1 1'/>", "", "<compiler autolimits='false'/>"), none);
}

TEST(Mjcf, Loops) {
  const RobotModel m =
      read("<default><equality active='false'/></default>" +
           world("<body name='a' pos='1 0 0'><joint name='ja' axis='0 1 0' ref='10'/><geom size='0.1' pos='0 0 1'/></body><body name='b' "
                 "pos='0 0 2'><joint name='jb' "
                 "axis='0 1 0'/><geom size='0.1' pos='0 0 1'/></body><body name='c'><joint name='jc' axis='0 1 0'/><geom size='0.1' pos='0 "
                 "0 1'/></body>") +
           "<tendon><fixed name='t'><joint joint='ja' coef='2'/><joint joint='jb' coef='-6'/></fixed><fixed name='t3'><joint joint='ja' "
           "coef='2'/><joint "
           "joint='jb' coef='-6'/><joint joint='jc' coef='1'/></fixed></tendon>"
           "<equality><connect name='pin' body1='a' body2='b' anchor='0 0 1' active='true'/><connect body1='a' anchor='0 0 1'/>"
           "<weld name='soft' body1='a' body2='b' torquescale='0' active='true'/><joint name='gear' joint1='ja' joint2='jb' polycoef='1 2 "
           "3' active='true'/>"
           "<joint joint1='jc' polycoef='0.25' active='true'/><tendon tendon1='t' polycoef='4' active='true'/><tendon "
           "tendon1='t3'/></equality>");
  const auto loops = m.mechanism->loops();
  ASSERT_EQ(loops.size(), 5U);
  EXPECT_EQ(loops[0].type, LoopType::ball);
  EXPECT_EQ(loops[0].X_AJ.p, (Vec3{0, 0, 1}));
  EXPECT_NEAR(norm(loops[0].X_BJ.p - Vec3{1, 0, -1}), 0, 1e-15) << "the anchor in b, in the pose of the file";
  EXPECT_TRUE(loops[0].closed);
  EXPECT_FALSE(loops[1].closed) << "inactive by default";
  EXPECT_EQ(loops[1].link_b, -1);
  EXPECT_EQ(loops[1].name, "connect_2");
  EXPECT_EQ(loops[2].type, LoopType::ball) << "a weld without torques";
  EXPECT_EQ(loops[3].type, LoopType::gear);
  EXPECT_EQ(loops[3].polynomial, (std::array<double, 5>{1, 2, 3, 0, 0}));
  EXPECT_EQ(loops[4].polynomial, (std::array<double, 5>{2, 3, 0, 0, 0})) << "2 (ja - ja0) - 6 jb = 4";
  EXPECT_EQ(link(m, "c").joint.dofs[0].lower, 0.25);
  EXPECT_EQ(link(m, "c").joint.dofs[0].upper, 0.25);
  EXPECT_TRUE(has_note(m, "An equality of tendons is left out"));
}

TEST(Mjcf, ShapesAndTheWorld) {
  const RobotModel m =
      read(world("<geom type='plane' size='1 1 1'/><geom name='wall' type='box' size='1 2 3' pos='5 0 0'/>" +
                 swing("<geom size='0.1' contype='0' conaffinity='0' group='1'/><geom size='0.2' group='3' friction='0.25'/>"
                       "<geom size='0.3' contype='0' conaffinity='0' group='4'/><geom size='0.4' rgba='1 1 1 0'/>")));
  EXPECT_EQ(m.mechanism->link(0).name, "world");
  ASSERT_EQ(m.mechanism->link(0).shapes.size(), 1U);
  EXPECT_EQ(m.mechanism->link(0).shapes[0].X_BS.p.x, 5);
  const std::vector<Shape>& s = link(m, "arm").shapes;
  ASSERT_EQ(s.size(), 4U);
  EXPECT_FALSE(s[0].collides);
  EXPECT_TRUE(s[0].visible);
  EXPECT_TRUE(s[1].collides);
  EXPECT_TRUE(s[1].visible) << "collision shapes are visible";
  EXPECT_EQ(s[1].friction, 0.25);
  EXPECT_FALSE(s[2].visible);
  EXPECT_FALSE(s[3].visible);
  EXPECT_TRUE(has_note(m, "ground plane z = 0 is left out"));
}

TEST(Mjcf, CollisionFilters) {
  const RobotModel m =
      read(world(swing("<geom size='0.1' contype='2' conaffinity='-1' condim='1'/>", "a") +
                 swing("<geom size='0.1' contype='4' conaffinity='8' condim='6'/>", "b") + swing("<geom size='0.1'/>", "c")) +
           "<contact><exclude body1='c' body2='a'/><pair geom1='x' geom2='y'/></contact>");
  const Shape &a = link(m, "a").shapes[0], &b = link(m, "b").shapes[0], &c = link(m, "c").shapes[0];
  EXPECT_EQ(a.groups, 2U);
  EXPECT_EQ(a.partners, 0xffffffffU);
  EXPECT_TRUE(a.smooth);
  EXPECT_FALSE(b.smooth);
  EXPECT_TRUE(can_collide(a, b));
  EXPECT_FALSE(can_collide(b, c));
  ASSERT_EQ(m.mechanism->exclusions().size(), 1U);
  EXPECT_EQ(m.mechanism->exclusions()[0], (std::array{m.mechanism->find_link("a"), m.mechanism->find_link("c")}));
  EXPECT_TRUE(has_note(m, "<pair>"));
  EXPECT_TRUE(has_note(m, "The ground collides with this shape"));
  EXPECT_TRUE(has_note(m, "condim 4 and 6"));
  const auto unknown = read_mjcf(
      "<mujoco>" + world(swing("<geom size='0.1'/>", "a")) + "<contact><exclude body1='a' body2='z'/></contact></mujoco>", "m.xml");
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.error().text().find("no body is named 'z'"), std::string::npos) << unknown.error().text();
}

TEST(Mjcf, BaseOption) {
  const std::string text = world("<body name='free'><freejoint/><geom size='0.1'/></body><body name='still'><geom size='0.1'/>" +
                                 swing("<geom size='0.1' pos='1 0 0'/>") + "</body><body name='box'><geom size='0.1'/></body>");
  RobotOptions options;
  EXPECT_EQ(read(text, options).mechanism->nv(), 7);
  options.base = Base::fixed;
  EXPECT_EQ(read(text, options).mechanism->nv(), 1);
  options.base = Base::floating;
  EXPECT_EQ(read(text, options).mechanism->nv(), 13) << "a body without movable descendants stays fixed";
}

TEST(Mjcf, SpringAndDamperFromATimeConstant) {
  // a small sphere of 2 kg at 0.5 m, and armature: I = 0.4 * 2 * 0.01 + 2 * 0.25 + 0.1
  const RobotModel m =
      read(world("<body name='b'><joint axis='0 1 0' armature='0.1' springdamper='0.2 0.5' stiffness='7'/><geom size='0.1' mass='2' pos='0 "
                 "0 0.5'/></body>"));
  const double I = 0.4 * 2 * 0.01 + 2 * 0.25 + 0.1;
  const Dof& f = link(m, "b").joint.dofs[0];
  EXPECT_NEAR(f.stiffness, I / (0.04 * 0.25), 1e-12);
  EXPECT_NEAR(f.damping, 2 * I / 0.2, 1e-12);
}

// ---- meshes

std::vector<Vec3> cube(double a, const Vec3& centre) {
  std::vector<Vec3> out;
  for (int i = 0; i < 8; ++i) out.push_back(centre + Vec3{i & 1 ? a : -a, i & 2 ? a : -a, i & 4 ? a : -a});
  return out;
}
const std::vector<MeshTriangle> cube_faces = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                              {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};

TEST(MjcfMesh, InertiaOfACube) {
  const Vec3 c{1, 2, 3};
  const std::vector<Vec3> points = cube(0.5, c);
  const Sym3 solid{1.0 / 6, 1.0 / 6, 1.0 / 6, 0, 0, 0};
  for (const MeshInertia kind : {MeshInertia::exact, MeshInertia::legacy}) {
    const Inertia I = mesh_inertia(points, cube_faces, kind);
    EXPECT_NEAR(I.mass, 1, 1e-14);
    EXPECT_NEAR(norm(I.centre() - c), 0, 1e-14);
    expect_moments(I.about_centre(), solid.xx, solid.yy, solid.zz);
  }
  const Inertia shell = mesh_inertia(points, cube_faces, MeshInertia::shell);
  EXPECT_NEAR(shell.mass, 6, 1e-14);
  expect_moments(shell.about_centre(), 5.0 / 3, 5.0 / 3, 5.0 / 3);  // hollow cube: 5/18 m a^2 with m = 6, a = 1
  // One triangle with reversed orientation changes the result of the mode `exact`, but not of the mode `legacy`.
  std::vector<MeshTriangle> wrong = cube_faces;
  std::swap(wrong[3][0], wrong[3][1]);
  EXPECT_NEAR(mesh_inertia(points, wrong, MeshInertia::legacy).mass, 1, 1e-14);
  EXPECT_NEAR(mesh_inertia(points, wrong, MeshInertia::exact).mass, 1 - 2.0 / 12, 1e-14);
}

TEST(MjcfMesh, HullOfPoints) {
  std::vector<Vec3> points = cube(0.5, {});
  for (int i = 0; i < 200; ++i) {  // adds points inside, on faces, on edges, and duplicates
    const double t = -0.5 + i / 200.0;
    points.push_back({t * 0.9, t * t - 0.1, 0.3 * t});
    points.push_back({0.5, t, -t});
    points.push_back({0.5, 0.5, t});
    points.push_back({-0.5, -0.5, -0.5});
  }
  const Inertia I = mesh_inertia(points, convex_hull(points), MeshInertia::convex);
  EXPECT_NEAR(I.mass, 1, 1e-12);
  expect_moments(I.about_centre(), 1.0 / 6, 1.0 / 6, 1.0 / 6);
  EXPECT_TRUE(convex_hull(std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0.5, 0.5, 0}}).empty()) << "flat";
  // the hull of 1000 points on a sphere: its volume is slightly less than the sphere's
  points.clear();
  for (int i = 0; i < 1000; ++i) {
    const double z = -1 + 2 * (i + 0.5) / 1000, turn = 2.399963229728653 * i, r = std::sqrt(1 - z * z);
    points.push_back({r * cos(turn), r * sin(turn), z});
  }
  const double v = mesh_inertia(points, convex_hull(points), MeshInertia::exact).mass;
  EXPECT_LT(v, 4.0 / 3.0 * pi);
  EXPECT_GT(v, 0.99 * 4.0 / 3.0 * pi);
}

const std::string brick =  // a box of 2 x 4 x 6 with its centre at (1, 0, 0)
    "v 0 -2 -3\nv 2 -2 -3\nv 0 2 -3\nv 2 2 -3\nv 0 -2 3\nv 2 -2 3\nv 0 2 3\nv 2 2 3\n"
    "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";

TEST(MjcfMesh, MeshesFromFilesAndInline) {
  const RobotModel m = read(
      "<compiler meshdir='parts'/><asset><mesh file='brick.obj' scale='0.1 0.1 -0.1'/><mesh name='moved' file='brick.obj' refpos='1 0 0' "
      "refquat='1 0 0 1'/><mesh name='hull' vertex='0 0 0 1 0 0 0 1 0 0 0 1'/></asset>" +
          world(swing("<geom type='mesh' mesh='brick' pos='0 0 1' mass='3'/>", "a") + swing("<geom type='mesh' mesh='moved'/>", "b") +
                swing("<geom type='mesh' mesh='hull' density='6'/>", "c") + swing("<geom type='box' mesh='brick' density='1000'/>", "d") +
                swing("<geom type='mesh' mesh='brick' mass='1' contype='0' conaffinity='0'/>", "e")),
      with_files({{"parts/brick.obj", brick}}));
  const Inertia a = link(m, "a").inertia;
  EXPECT_EQ(a.mass, 3);
  EXPECT_NEAR(norm(a.centre() - Vec3{0.1, 0, 1}), 0, 1e-15);
  expect_moments(a.about_centre(), 3 * (0.16 + 0.36) / 12, 3 * (0.04 + 0.36) / 12, 3 * (0.04 + 0.16) / 12);
  const Inertia b = link(m, "b").inertia;
  EXPECT_NEAR(b.mass, 48000, 1e-8);
  EXPECT_NEAR(norm(b.centre()), 0, 1e-12);
  EXPECT_NEAR(b.I.xx, 48000 * (4 + 36) / 12.0, 1e-8) << "a quarter turn about z";
  EXPECT_NEAR(link(m, "c").inertia.mass, 1, 1e-14) << "a sixth of a cubic metre";
  const Inertia d = link(m, "d").inertia;
  EXPECT_NEAR(d.mass, 48, 1e-9) << "the box of the same moments is the brick itself";
  EXPECT_NEAR(norm(d.centre() - Vec3{0.1, 0, 0}), 0, 1e-14);
  expect_moments(d.about_centre(), 48 * (0.16 + 0.36) / 12, 48 * (0.04 + 0.36) / 12, 48 * (0.04 + 0.16) / 12);
  ASSERT_EQ(link(m, "a").shapes.size(), 1U);
  const Shape brick_shape = link(m, "a").shapes[0];
  ASSERT_EQ(brick_shape.type, ShapeType::mesh);
  EXPECT_EQ(brick_shape.geometry->vertices.size(), 8U);
  EXPECT_NEAR(volume(brick_shape), 8 * 0.1 * 0.2 * 0.3, 1e-15);
  EXPECT_TRUE(link(m, "e").shapes.empty()) << "shapes for display only are left out";
}

TEST(MjcfShapes, PlanesAndHeightFields) {
  const RobotModel m = read("<asset><hfield name='hill' nrow='2' ncol='3' size='3 2 0.5 1' elevation='0 4 8  0 0 2'/></asset>" +
                            world("<geom type='plane' size='0 0 1'/><geom type='plane' size='2 3 1' pos='0 0 0.25' euler='0 30 0'/>"
                                  "<geom type='hfield' hfield='hill' pos='1 0 0'/>" +
                                  swing("<geom type='cylinder' size='0.2 0.3'/>", "c")));
  const std::vector<Shape>& shapes = link(m, "world").shapes;
  ASSERT_EQ(shapes.size(), 2U) << "the ground belongs to the scene";
  EXPECT_EQ(shapes[0].type, ShapeType::box);
  const Pose top = shapes[0].X_BS * Pose{Mat3::identity(), {0, 0, shapes[0].half_extents.z}};
  EXPECT_NEAR(top.p.z, 0.25, 1e-12);
  EXPECT_NEAR(top.R.zz, std::cos(pi / 6), 1e-12);
  ASSERT_EQ(shapes[1].type, ShapeType::height_field);
  const HeightField& f = *shapes[1].field;
  EXPECT_EQ(f.columns, 3);
  EXPECT_EQ(f.rows, 2);
  EXPECT_EQ(f.base, 1);
  EXPECT_NEAR(norm(f.point(2, 1) - Vec3{3, 2, 0.5}), 0, 1e-15) << "the first row of the text has the maximum y";
  EXPECT_NEAR(norm(f.point(1, 1) - Vec3{0, 2, 0.25}), 0, 1e-15);
  EXPECT_NEAR(f.point(2, 0).z, 0.125, 1e-15);
}

TEST(MjcfMesh, MissingMeshFiles) {
  const std::string not_needed = "<asset><mesh name='m' file='m.stl'/></asset>" +
                                 world(swing("<inertial pos='0 0 1' mass='1' diaginertia='1 1 1'/><geom type='mesh' mesh='m'/>"));
  const RobotModel m = read(not_needed);
  EXPECT_EQ(m.mechanism->mass(), 1);
  EXPECT_TRUE(has_note(m, "mesh file was not found"));
  RobotOptions strict;
  strict.require_meshes = true;
  EXPECT_FALSE(read_mjcf("<mujoco>" + not_needed + "</mujoco>", "m.xml", strict).has_value());

  const std::string gives_mass =
      "<mujoco><asset><mesh name='m' file='m.stl'/></asset>" + world(swing("<geom size='0.1'/><geom type='mesh' mesh='m'/>")) + "</mujoco>";
  const auto refused = read_mjcf(gives_mass, "m.xml");
  ASSERT_FALSE(refused.has_value());
  EXPECT_NE(refused.error().text().find("'m.stl'"), std::string::npos) << refused.error().text();
  RobotOptions weightless;
  weightless.meshes = Meshes::none;
  const auto without_meshes = read_mjcf(gives_mass, "m.xml", weightless);
  ASSERT_TRUE(without_meshes.has_value()) << without_meshes.error().text();
  EXPECT_NEAR(without_meshes->mechanism->mass(), 4.0 / 3.0 * pi, 1e-12);
  EXPECT_TRUE(has_note(*without_meshes, "their mass with them"));
}

TEST(Mjcf, NotesListWhatIsLeftOut) {
  const RobotModel m = read("<option gravity='0 0 -981' timestep='0.001' density='2'><flag gravity='disable'/></option><extension/>" +
                            world("<body name='b' gravcomp='1'><joint name='j'/><geom type='ellipsoid' size='1 2 "
                                  "3'/><flexcomp/><plugin/></body>"
                                  "<body mocap='true'><geom size='0.1' contype='3'/></body>") +
                            "<tendon><spatial/><fixed/></tendon><actuator><muscle tendon='t'/></actuator><deformable/>"
                            "<keyframe><key qpos='1 2 3 4'/></keyframe>");
  for (const char* part :
       {"specifies gravity: 0 0 -981", "time step", "density, viscosity", "switches gravity off", "<extension>", "gravcomp", "<flexcomp>",
        "A plugin", "mocap", "A spatial tendon", "A fixed tendon", "does not act on a joint", "<deformable>", "Keyframes are left out"})
    EXPECT_TRUE(has_note(m, part)) << part;
}

// ---- real files

TEST(MjcfData, SharedFilesAreReadOrRefusedWithReason) {
  NEEDS_MJCF_DATA();
  const std::map<std::string, std::string> refused = {
      {"model__humanoid__humanoid100.xml", "humanoid.xml' cannot be read"},  // the attached model was saved under another name
      {"model__hammock__hammock.xml", "cannot be read"},
      {"dog.xml", "comes from a mesh, but the mesh file"},
      {"fruitfly.xml", "comes from a mesh, but the mesh file"},
      {"materials.xml", "no body"},  // fragments that other files include
      {"skybox.xml", "no body"},
      {"visual.xml", "no body"}};
  int opened = 0, not_opened = 0;
  for (const auto& e : std::filesystem::recursive_directory_iterator(data_folder())) {
    if (e.path().extension() != ".xml") continue;
    const std::string path = std::filesystem::relative(e.path(), data_folder()).string(), file = e.path().filename().string();
    const std::string text = load_data(path);
    if (text.find("<mujoco") == std::string::npos) continue;
    SCOPED_TRACE(path);
    const auto m = read_mjcf(text, path, data_options());
    if (const auto it = refused.find(file); it != refused.end()) {
      ++not_opened;
      ASSERT_FALSE(m.has_value());
      EXPECT_NE(m.error().text().find(it->second), std::string::npos) << m.error().text();
    } else {
      ++opened;
      EXPECT_TRUE(m.has_value()) << (m ? std::string() : m.error().text());
    }
  }
  EXPECT_EQ(opened, 25);
  EXPECT_EQ(not_opened, 10);
}

TEST(MjcfData, HammockReadsHumanoidAndLeavesOutNet) {
  NEEDS_MJCF_DATA();
  const std::string folder = "mechanism/open_chain/mujoco/", name = folder + "model__hammock__hammock.xml";
  RobotOptions options;
  options.read_asset = [&](const std::string&) { return files::read_file(data_folder() + folder + "model__humanoid__humanoid.xml"); };
  const auto m = read_mjcf(load_data(name), name, options);
  ASSERT_TRUE(m.has_value()) << m.error().text();
  EXPECT_EQ(m->mechanism->nv(), 27);
  EXPECT_TRUE(has_note(*m, "<flexcomp>"));
}

}  // namespace
}  // namespace ugoki::robot_formats
