// Meaning of SDF files: frames, joints, tree and loops on small models with results computed by hand.
#include "ugoki/robot_formats/sdf.h"

#include <gtest/gtest.h>

#include <cmath>

#include "robot_data.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/dynamics/loop_rows.h"

namespace ugoki::robot_formats {
namespace {

std::string model(const std::string& inside, const std::string& version = "1.7") {
  return "<sdf version='" + version + "'><model name='m'>\n" + inside + "\n</model></sdf>";
}
std::string link(const std::string& name, const std::string& pose = "", const std::string& inside = "") {
  return "<link name='" + name + "'>" +
         (pose.empty()            ? ""
          : pose.starts_with("<") ? pose
                                  : "<pose>" + pose + "</pose>") +
         "<inertial><mass>2</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>" + inside + "</link>\n";
}
std::string joint(const std::string& name, const std::string& type, const std::string& parent, const std::string& child,
                  const std::string& inside = "<axis><xyz>0 0 1</xyz></axis>") {
  return "<joint name='" + name + "' type='" + type + "'><parent>" + parent + "</parent><child>" + child + "</child>" + inside +
         "</joint>\n";
}

RobotModel read(const std::string& text, const RobotOptions& options = {}) {
  Result<RobotModel> m = read_sdf(text, "m.sdf", options);
  EXPECT_TRUE(m.has_value()) << m.error().text();
  return m ? *m : RobotModel{};
}

void expect_near(const Vec3& a, const Vec3& b, double tolerance = 1e-14) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], tolerance) << "component " << i;
}

/// World pose, at q, of the link frame that the file defines.
Pose file_pose(const RobotModel& m, const std::string& name, const std::vector<double>& q) {
  dynamics::Workspace ws(*m.mechanism);
  dynamics::update_kinematics(*m.mechanism, q, std::vector<double>(static_cast<std::size_t>(m.mechanism->nv())), ws);
  const auto i = static_cast<std::size_t>(m.mechanism->find_link(name));
  return ws.X_WB[i] * m.X_BF[i];
}

/// Maximum gap of the loops in the neutral position.
double neutral_gap(const Mechanism& m) {
  dynamics::Workspace ws(m);
  const std::vector<double> q = m.neutral(), v(static_cast<std::size_t>(m.nv()));
  dynamics::update_kinematics(m, q, v, ws);
  dynamics::LoopRows rows(m.loops());
  dynamics::update_loop_rows(m, ws, m.loops(), q, v, rows);
  double worst = 0;
  for (const double gap : rows.gap) worst = std::max(worst, std::fabs(gap));
  return worst;
}

TEST(Sdf, FramesAreResolvedRelativeToEachOther) {
  const RobotModel m = read(model("<pose>0 0 10 0 0 0</pose>" + link("a", "1 0 0 0 0 1.5707963267948966") +
                                  link("b", "<pose relative_to='f'>1 0 0 0 0 0</pose>") +
                                  "<frame name='f' attached_to='a'><pose relative_to='g'>0 2 0 0 0 0</pose></frame>"
                                  "<frame name='g' attached_to='a'/>" +
                                  joint("j", "revolute", "a", "b")));
  // g is at a = (1, 0, 10), rotated a quarter turn about z; f is 2 m along g's y, at (-1, 0, 10); b is 1 m along f's x.
  expect_near(file_pose(m, "b", m.mechanism->neutral()).p, {-1, 1, 10});
  expect_near(file_pose(m, "a", m.mechanism->neutral()).p, {1, 0, 10});
}

TEST(Sdf, JointRotatesLinkAboutItsOwnFrame) {
  // The joint is 1 m from the child's origin, at -1 m along the child's x, and rotated by 90 degrees about z.
  RobotOptions fixed;
  fixed.base = Base::fixed;
  const RobotModel m = read(model(link("a") + link("b", "3 0 0 0 0 0") +
                                  joint("j", "revolute", "a", "b", "<pose>-1 0 0 0 0 0</pose><axis><xyz>0 0 1</xyz></axis>")),
                            fixed);
  const Pose X = file_pose(m, "b", {pi / 2});
  expect_near(X.p, {2, 1, 0});
  expect_near(X.R.column(0), {0, 1, 0});
  expect_near(m.mechanism->link(1).inertia.centre(), {1, 0, 0});
}

TEST(Sdf, OldVersionsExpressAxesInTheModelFrame) {
  const std::string inside = link("a") + link("b", "0 0 0 0 0 1.5707963267948966");
  RobotOptions fixed;
  fixed.base = Base::fixed;
  const auto axis_W = [&](const std::string& text) {
    const RobotModel m = read(text, fixed);
    return m.mechanism->link(1).joint.X_PJ.R * m.mechanism->link(1).joint.axis;
  };
  const std::string plain = joint("j", "revolute", "a", "b", "<axis><xyz>1 0 0</xyz></axis>");
  expect_near(axis_W(model(inside + plain, "1.4")), {1, 0, 0});
  expect_near(axis_W(model(inside + plain, "1.6")), {0, 1, 0});
  expect_near(axis_W(model(inside + joint("j", "revolute", "a", "b",
                                          "<axis><xyz>1 0 0</xyz><use_parent_model_frame>1</use_parent_model_frame></axis>"),
                           "1.6")),
              {1, 0, 0});
  expect_near(axis_W(model(inside + joint("j", "revolute", "a", "b", "<axis><xyz expressed_in='a'>1 0 0</xyz></axis>"))), {1, 0, 0});
}

TEST(Sdf, JointTypes) {
  const std::string axes = "<axis><xyz>0 0 1</xyz></axis><axis2><xyz>1 0 0</xyz></axis2>";
  const std::pair<const char*, JointType> types[] = {{"fixed", JointType::fixed},         {"revolute", JointType::revolute},
                                                     {"continuous", JointType::revolute}, {"prismatic", JointType::prismatic},
                                                     {"ball", JointType::spherical},      {"universal", JointType::universal},
                                                     {"revolute2", JointType::universal}};
  for (const auto& [name, type] : types)
    EXPECT_EQ(read(model(link("a") + link("b") + joint("j", name, "a", "b", axes))).mechanism->link(1).joint.type, type) << name;
  const auto pitch = [&](const std::string& word) {
    return read(model(link("a") + link("b") + joint("j", "screw", "a", "b", "<axis><xyz>0 0 1</xyz></axis>" + word)))
        .mechanism->link(1)
        .joint.pitch;
  };
  EXPECT_NEAR(pitch("<screw_thread_pitch>0.01</screw_thread_pitch>"), 0.01 / (2 * pi), 1e-18);
  EXPECT_EQ(pitch("<thread_pitch>-4</thread_pitch>"), 0.25);
}

TEST(Sdf, LimitsSpringsAndDampers) {
  const RobotModel m =
      read(model(link("a") + link("b") +
                 joint("j", "revolute", "a", "b",
                       "<axis><xyz>0 0 1</xyz><limit><lower>-1</lower><upper>1e16</upper><effort>-1</effort></limit><dynamics>"
                       "<damping>2</damping><friction>3</friction><spring_stiffness>4</spring_stiffness><spring_reference>0.5"
                       "</spring_reference></dynamics></axis>")));
  const Dof& f = m.mechanism->link(1).joint.dofs[0];
  EXPECT_EQ(f.lower, -1);
  EXPECT_EQ(f.upper, INFINITY);
  EXPECT_EQ(f.effort, INFINITY);
  EXPECT_EQ(f.damping, 2);
  EXPECT_EQ(f.friction, 3);
  EXPECT_EQ(f.stiffness, 4);
  EXPECT_EQ(f.rest, 0.5);
}

TEST(Sdf, TreeIsCutAtTheJointWithMostDofs) {
  // A square a-b-c-d whose joint b-c is a ball: this joint must be cut. The loop is closed in the pose of the file.
  const std::string text = model(link("a", "0 0 0 0 0 0") + link("b", "1 0 0 0 0 0") + link("c", "1 1 0 0 0 0") + link("d", "0 1 0 0 0 0") +
                                 joint("ab", "revolute", "a", "b") + joint("bc", "ball", "b", "c", "") + joint("cd", "revolute", "d", "c") +
                                 joint("da", "revolute", "a", "d"));
  const RobotModel m = read(text);
  ASSERT_EQ(m.mechanism->loops().size(), 1u);
  EXPECT_EQ(m.mechanism->loops()[0].name, "bc");
  EXPECT_EQ(m.mechanism->loops()[0].type, LoopType::ball);
  EXPECT_LT(neutral_gap(*m.mechanism), 1e-15);
}

TEST(Sdf, JointsCanBeReversed) {
  // The base is a, but the file defines b as the parent of a.
  RobotOptions fixed;
  fixed.base = Base::fixed;
  const std::string pose = "<pose>0.5 0 0 0.3 0 0</pose>";
  for (const char* type : {"revolute", "prismatic", "screw"}) {
    const std::string words = pose + "<axis><xyz>0 0.6 0.8</xyz></axis><screw_thread_pitch>0.5</screw_thread_pitch>";
    const RobotModel back = read(model(link("a") + link("b", "2 0 0 0 0 0.2") + joint("j", type, "b", "a", words)), fixed);
    // The same joint without reversal: b is the base and the parent of a.
    const RobotModel forth = read(model(link("b", "2 0 0 0 0 0.2") + link("a") + joint("j", type, "b", "a", words)), fixed);
    ASSERT_EQ(back.mechanism->link(1).name, "b");
    ASSERT_EQ(forth.mechanism->link(1).name, "a");
    const Pose X_ab = file_pose(back, "a", {0.7}).inverse() * file_pose(back, "b", {0.7});
    const Pose Y_ab = file_pose(forth, "a", {0.7}).inverse() * file_pose(forth, "b", {0.7});
    expect_near(X_ab.p, Y_ab.p);
    for (int i = 0; i < 3; ++i) expect_near(X_ab.R.row(i), Y_ab.R.row(i));
  }
  // A reversed universal joint exchanges its two axes and their signs.
  const std::string words = pose + "<axis><xyz>0 0.6 0.8</xyz></axis><axis2><xyz>1 0 0</xyz></axis2>";
  const RobotModel back = read(model(link("a") + link("b", "2 0 0 0 0 0.2") + joint("j", "universal", "b", "a", words)), fixed);
  const RobotModel forth = read(model(link("b", "2 0 0 0 0 0.2") + link("a") + joint("j", "universal", "b", "a", words)), fixed);
  const Pose X_ab = file_pose(back, "a", {0.4, 0.7}).inverse() * file_pose(back, "b", {0.4, 0.7});
  const Pose Y_ab = file_pose(forth, "a", {0.7, 0.4}).inverse() * file_pose(forth, "b", {0.7, 0.4});
  expect_near(X_ab.p, Y_ab.p);
  for (int i = 0; i < 3; ++i) expect_near(X_ab.R.row(i), Y_ab.R.row(i));
}

TEST(Sdf, FixedStaticAndFloatingBases) {
  EXPECT_EQ(read(model(link("a"))).mechanism->link(0).joint.type, JointType::floating);
  EXPECT_EQ(read(model("<static>1</static>" + link("a"))).mechanism->link(0).joint.type, JointType::fixed);
  const RobotModel m = read(model(link("a", "0 0 3 0 0 0") + joint("j", "fixed", "world", "a")));
  EXPECT_EQ(m.mechanism->link(0).joint.type, JointType::fixed);
  expect_near(file_pose(m, "a", {}).p, {0, 0, 3});
  // Two parts that no joint connects are two floating bases.
  EXPECT_EQ(read(model(link("a") + link("b"))).mechanism->nv(), 12);
}

TEST(Sdf, NestedModelsAreScoped) {
  const RobotModel m = read(model(link("a", "0 0 1 0 0 0") + "<model name='arm'><pose relative_to='a'>0 1 0 0 0 0</pose>" +
                                  link("b", "1 0 0 0 0 0") + link("c", "<pose relative_to='b'>0 0 5 0 0 0</pose>") +
                                  joint("bc", "revolute", "b", "c") + "</model>" + joint("j", "revolute", "a", "arm::b")));
  EXPECT_EQ(m.mechanism->link_count(), 3);
  expect_near(file_pose(m, "arm::c", m.mechanism->neutral()).p, {1, 1, 6});
  ASSERT_EQ(m.joints.size(), 2u);
  EXPECT_EQ(m.joints[1].joint, "arm::bc");
}

TEST(Sdf, GearboxBecomesAGear) {
  const std::string axes = "<axis><xyz>0 0 1</xyz></axis>";
  const RobotModel m = read(model(link("box") + link("in") + link("out") + joint("ji", "revolute", "box", "in", axes) +
                                  joint("jo", "revolute", "box", "out", "<axis><xyz>0 0 -1</xyz></axis>") +
                                  joint("gear", "gearbox", "in", "out",
                                        axes + "<axis2><xyz>0 0 1</xyz></axis2><gearbox_ratio>3</gearbox_ratio>"
                                               "<gearbox_reference_body>box</gearbox_reference_body>")));
  ASSERT_EQ(m.mechanism->loops().size(), 1u);
  const Loop& l = m.mechanism->loops()[0];
  EXPECT_EQ(l.type, LoopType::gear);
  // theta_2 = -3 theta_1 about z; the joint of `out` rotates about -z, so q_out = +3 q_in.
  EXPECT_EQ(m.mechanism->link(m.mechanism->link_of_dof(l.dof_a)).name, "out");
  EXPECT_EQ(l.polynomial[1], 3);
}

TEST(Sdf, DrakesClosures) {
  const std::string two = link("a") + link("b") + joint("ja", "revolute", "world", "a") + joint("jb", "revolute", "world", "b");
  const RobotModel ball = read(model(two + "<drake:ball_constraint><drake:ball_constraint_body_A>a</drake:ball_constraint_body_A>"
                                           "<drake:ball_constraint_body_B>b</drake:ball_constraint_body_B><drake:ball_constraint_p_AP>1 2 3"
                                           "</drake:ball_constraint_p_AP></drake:ball_constraint>"));
  ASSERT_EQ(ball.mechanism->loops().size(), 1u);
  EXPECT_EQ(ball.mechanism->loops()[0].type, LoopType::ball);
  expect_near(ball.mechanism->loops()[0].X_AJ.p, {1, 2, 3});
  const RobotModel hinge =
      read(model(two + "<drake:linear_bushing_rpy><drake:bushing_frameA>a</drake:bushing_frameA><drake:bushing_frameC>b"
                       "</drake:bushing_frameC><drake:bushing_torque_stiffness>9 9 0</drake:bushing_torque_stiffness>"
                       "<drake:bushing_force_stiffness>9 9 9</drake:bushing_force_stiffness></drake:linear_bushing_rpy>"));
  EXPECT_EQ(hinge.mechanism->loops()[0].type, LoopType::revolute);
}

TEST(Sdf, LoopsFileMayReferToFrames) {
  RobotOptions options;
  options.loops = SideFile{"m.yaml", "closed_loop: [[fa, fb]]\ntype: [revolute]\nname_mot: [ja]\n"};
  const RobotModel m = read(model(link("a") + link("b") + joint("ja", "revolute", "world", "a") + joint("jb", "revolute", "world", "b") +
                                  "<frame name='fa' attached_to='a'><pose>1 0 0 0 0 0</pose></frame>"
                                  "<frame name='fb' attached_to='b'><pose>0 1 0 0 0 0</pose></frame>"),
                            options);
  ASSERT_EQ(m.mechanism->loops().size(), 1u);
  EXPECT_EQ(m.mechanism->loops()[0].type, LoopType::revolute);
  expect_near(m.mechanism->loops()[0].X_BJ.p, {0, 1, 0});
  EXPECT_EQ(m.driven, std::vector<std::string>{"a"});
}

TEST(SdfShared, CountsMassAndClosedLoops) {
  NEEDS_ROBOT_DATA();
  struct Expected {
    const char* file;
    int links, dofs, loops;
    double mass;
    bool assembled;  ///< loops are closed in the pose of the file
  };
  // Cassie: 23 links, 26 joints, of which 4 balls close loops.
  const Expected all[] = {{"cassie_sdf/cassie_v2.sdf", 23, 28, 4, 32.94, true},
                          {"drake/four_bar.sdf", 3, 3, 0, 60, true},
                          {"drake/four_bar_loop.sdf", 3, 3, 1, 4, false},
                          {"drake/four_bar_weld.sdf", 4, 4, 1, 4, false}};
  for (const Expected& e : all) {
    SCOPED_TRACE(e.file);
    const std::string path = robot_folder() + "closed_loop/" + e.file;
    const RobotModel m = read(load_robot(path));
    EXPECT_EQ(m.mechanism->link_count(), e.links);
    EXPECT_EQ(m.mechanism->nv(), e.dofs);
    EXPECT_EQ(static_cast<int>(m.mechanism->loops().size()), e.loops);
    EXPECT_NEAR(m.mechanism->mass(), e.mass, 1e-9);
    if (e.assembled) {
      EXPECT_LE(neutral_gap(*m.mechanism), 1e-9) << "joints match the poses of the links in the file";
    }
  }
}

}  // namespace
}  // namespace ugoki::robot_formats
