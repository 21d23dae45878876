// Meaning of URDF files: each element on a small robot with results computed by hand, and the shared files compared with a plain text scan.
#include "ugoki/robot_formats/urdf.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <iostream>

#include "robot_data.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::robot_formats {
namespace {

constexpr const char* a_mass = "<inertial><mass value='2'/><inertia ixx='1' iyy='1' izz='1'/></inertial>";

std::string robot(const std::string& inside) { return "<robot name='r'>\n" + inside + "\n</robot>"; }
std::string link(const std::string& name, const std::string& inside = a_mass) {
  return "<link name='" + name + "'>" + inside + "</link>\n";
}
std::string joint(const std::string& name, const std::string& type, const std::string& parent, const std::string& child,
                  const std::string& inside = "") {
  return "<joint name='" + name + "' type='" + type + "'><parent link='" + parent + "'/><child link='" + child + "'/>" + inside +
         "</joint>\n";
}

RobotModel read(const std::string& text, const RobotOptions& options = {.base = Base::fixed}) {
  Result<RobotModel> model = read_urdf(text, "r.urdf", options);
  EXPECT_TRUE(model.has_value()) << model.error().text();
  return model ? *model : RobotModel{};
}
/// Two links `a` and `b` with a joint between them.
RobotModel read_joint(const std::string& type, const std::string& inside) {
  return read(robot(link("a") + link("b") + joint("j", type, "a", "b", inside)));
}

bool has_note(const RobotModel& model, const std::string& part) {
  return std::ranges::any_of(model.notes, [&](const std::string& n) { return n.find(part) != std::string::npos; });
}

void expect_near(const Vec3& a, const Vec3& b, double tolerance = 1e-15) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], tolerance) << "component " << i;
}

TEST(Urdf, OriginUsesRollPitchYawAboutFixedAxes) {
  const RobotModel m = read_joint("revolute", "<origin xyz='1 2 3' rpy='0.1 0.2 0.3'/><axis xyz='0 0 2'/>");
  const Joint& j = m.mechanism->link(1).joint;
  expect_near(j.X_PJ.p, {1, 2, 3});
  const double cr = std::cos(0.1), sr = std::sin(0.1), cp = std::cos(0.2), sp = std::sin(0.2), cy = std::cos(0.3), sy = std::sin(0.3);
  expect_near(j.X_PJ.R.row(0), {cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr});
  expect_near(j.X_PJ.R.row(2), {-sp, cp * sr, cp * cr});
  expect_near(j.axis, {0, 0, 1});
  EXPECT_EQ(m.mechanism->link(1).name, "b");
  ASSERT_EQ(m.joints.size(), 1u);
  EXPECT_EQ(m.joints[0].joint, "j");
  EXPECT_EQ(m.joints[0].link, "b");
}

TEST(Urdf, JointTypes) {
  const std::pair<const char*, JointType> types[] = {{"fixed", JointType::fixed},         {"revolute", JointType::revolute},
                                                     {"continuous", JointType::revolute}, {"prismatic", JointType::prismatic},
                                                     {"floating", JointType::floating},   {"spherical", JointType::spherical}};
  for (const auto& [name, type] : types) EXPECT_EQ(read_joint(name, "").mechanism->link(1).joint.type, type) << name;
  expect_near(read_joint("revolute", "").mechanism->link(1).joint.axis, {1, 0, 0});  // the default of the format
  EXPECT_FALSE(read_urdf(robot(link("a") + link("b") + joint("j", "hinge", "a", "b")), "r.urdf"));
}

TEST(Urdf, LimitsAndDynamics) {
  const RobotModel m =
      read_joint("revolute", "<limit lower='-1' upper='2' effort='30' velocity='5'/><dynamics damping='0.5' friction='0.25'/>");
  const Dof& f = m.mechanism->link(1).joint.dofs[0];
  EXPECT_EQ(f.lower, -1);
  EXPECT_EQ(f.upper, 2);
  EXPECT_EQ(f.effort, 30);
  EXPECT_EQ(f.damping, 0.5);
  EXPECT_EQ(f.friction, 0.25);
  EXPECT_TRUE(has_note(m, "velocities"));
  // If only one limit is given, the other is 0, the default of the format. Joints without limits, and continuous joints, are unlimited.
  EXPECT_EQ(read_joint("revolute", "<limit upper='2'/>").mechanism->link(1).joint.dofs[0].lower, 0);
  EXPECT_EQ(read_joint("prismatic", "<limit effort='1'/>").mechanism->link(1).joint.dofs[0].upper, INFINITY);
  EXPECT_EQ(read_joint("continuous", "<limit lower='0' upper='0'/>").mechanism->link(1).joint.dofs[0].upper, INFINITY);
  EXPECT_EQ(read_joint("revolute", "<limit lower='-inf' upper='1e16'/>").mechanism->link(1).joint.dofs[0].upper, INFINITY);
}

TEST(Urdf, InertiaIsTransformedToTheLinkFrame) {
  // A rod along x of the inertial frame, which is rotated a quarter turn about z and is 1 m along x of the link.
  const RobotModel m = read(robot(link("a",
                                       "<inertial><origin xyz='1 0 0' rpy='0 0 1.5707963267948966'/><mass value='3'/>"
                                       "<inertia ixx='0' iyy='0.25' izz='0.25' ixy='0' ixz='0' iyz='0'/></inertial>")));
  const Inertia& i = m.mechanism->link(0).inertia;
  EXPECT_EQ(i.mass, 3);
  expect_near(i.centre(), {1, 0, 0});
  const Sym3 c = i.about_centre();
  expect_near({c.xx, c.yy, c.zz}, {0.25, 0, 0.25});
  expect_near({c.xy, c.xz, c.yz}, {0, 0, 0});
  // Products of inertia keep their sign.
  const Inertia o = read(robot(link("a",
                                    "<inertial><mass value='1'/><inertia ixx='1' iyy='2' izz='2.5' ixy='-0.3' ixz='0.1' iyz='0.2'/>"
                                    "</inertial>")))
                        .mechanism->link(0)
                        .inertia;
  EXPECT_EQ(o.I.xy, -0.3);
  EXPECT_EQ(o.I.xz, 0.1);
  EXPECT_EQ(o.I.yz, 0.2);
}

TEST(Urdf, ImpossibleInertiaIsRepairedOrRefused) {
  const std::string text = robot(link("fine") + link("flat", "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='3'/></inertial>") +
                                 joint("j", "revolute", "fine", "flat"));
  const RobotModel m = read(text);
  EXPECT_TRUE(has_note(m, "The moments of inertia of flat are not physically possible"));
  // The second moments tr(I) / 2 - I = (1.5, 1.5, -0.5) must not be negative. They become (1.5, 1.5, 0), so that I = (1.5, 1.5, 3).
  const Sym3 I = m.mechanism->link(1).inertia.about_centre();
  expect_near({I.xx, I.yy, I.zz}, {1.5, 1.5, 3}, 1e-14);
  const Result<RobotModel> strict = read_urdf(text, "r.urdf", {.base = Base::fixed, .inertias = Inertias::strict});
  ASSERT_FALSE(strict);
  EXPECT_NE(strict.error().text().find("r.urdf:3: The moments of inertia of the link 'flat' are not physically possible"),
            std::string::npos)
      << strict.error().text();
}

TEST(Urdf, MasslessLinksOfMovableJointsGetArmature) {
  const std::string text = robot(link("a") + link("tip", "") + joint("j", "revolute", "a", "tip"));
  const RobotModel m = read(text);
  EXPECT_EQ(m.mechanism->link(1).joint.dofs[0].armature, 1e-6);
  EXPECT_TRUE(has_note(m, "No link beyond the joints of tip has mass"));
  const Result<RobotModel> strict = read_urdf(text, "r.urdf", {.inertias = Inertias::strict});
  ASSERT_FALSE(strict);
  EXPECT_NE(strict.error().text().find("r.urdf:3"), std::string::npos) << strict.error().text();
}

TEST(Urdf, BaseFollowsTheFileByDefault) {
  const std::string tail = link("arm") + joint("j", "fixed", "base", "arm");
  const auto type = [](const std::string& text, Base base) { return read(text, {.base = base}).mechanism->link(0).joint.type; };
  EXPECT_EQ(type(robot(link("base") + tail), Base::by_file), JointType::floating);
  EXPECT_EQ(type(robot(link("base", "") + tail), Base::by_file), JointType::floating);  // the child on a fixed joint has mass
  EXPECT_EQ(type(robot(link("base") + tail), Base::fixed), JointType::fixed);
  const std::string fixed = robot(link("base", "") + link("arm") + joint("j", "revolute", "base", "arm"));
  EXPECT_EQ(type(fixed, Base::by_file), JointType::fixed);
  EXPECT_FALSE(read_urdf(fixed, "r.urdf", {.base = Base::floating}));  // the base has no mass
  const std::string world = robot(link("world") + link("arm") + joint("j", "revolute", "world", "arm"));
  EXPECT_EQ(type(world, Base::by_file), JointType::fixed);
}

TEST(Urdf, MimicBecomesAGear) {
  const RobotModel m = read(robot(link("a") + link("b") + link("c") + joint("lead", "revolute", "a", "b") +
                                  joint("follow", "prismatic", "b", "c", "<mimic joint='lead' multiplier='-0.5' offset='0.1'/>")));
  ASSERT_EQ(m.mechanism->loops().size(), 1u);
  const Loop& l = m.mechanism->loops()[0];
  EXPECT_EQ(l.type, LoopType::gear);
  EXPECT_EQ(l.dof_a, m.mechanism->link(2).v_index);
  EXPECT_EQ(l.dof_b, m.mechanism->link(1).v_index);
  EXPECT_EQ(l.polynomial, (std::array<double, 5>{0.1, -0.5, 0, 0, 0}));
}

TEST(Urdf, PlanarJointMovesPerpendicularToItsAxis) {
  const RobotModel m = read_joint("planar", "<origin xyz='0 0 1'/><axis xyz='0 1 0'/>");
  ASSERT_EQ(m.mechanism->link_count(), 3);
  const int b = m.mechanism->find_link("b");
  dynamics::Workspace ws(*m.mechanism);
  std::vector<double> v(3);
  dynamics::update_kinematics(*m.mechanism, std::vector<double>{0, 0, 0}, v, ws);
  expect_near(ws.X_WB[static_cast<std::size_t>(b)].p, {0, 0, 1});
  expect_near(ws.X_WB[static_cast<std::size_t>(b)].R.row(0), {1, 0, 0});
  dynamics::update_kinematics(*m.mechanism, std::vector<double>{0.3, 0.4, 0.5}, v, ws);
  const Pose X = ws.X_WB[static_cast<std::size_t>(b)];
  EXPECT_NEAR(X.p.y, 0, 1e-15);
  EXPECT_NEAR(norm(X.p - Vec3{0, 0, 1}), 0.5, 1e-15);
  expect_near(X.R.column(1), {0, 1, 0});
  EXPECT_NEAR(X.R.xx, std::cos(0.5), 1e-15);
  EXPECT_NEAR(X.R.zx, -std::sin(0.5), 1e-15);  // right-handed about y
  EXPECT_EQ(read_joint("planar", "<axis xyz='0 0 1'/>").mechanism->link_count(), 2);
}

TEST(Urdf, Shapes) {
  const auto shape = [](const std::string& geometry) {
    return read(robot(link("a", std::string(a_mass) + "<collision><origin xyz='1 0 0'/><geometry>" + geometry + "</geometry></collision>")))
        .mechanism->link(0)
        .shapes.at(0);
  };
  const Shape box = shape("<box size='2 4 6'/>");
  EXPECT_EQ(box.type, ShapeType::box);
  expect_near(box.half_extents, {1, 2, 3});
  expect_near(box.X_BS.p, {1, 0, 0});
  EXPECT_TRUE(box.collides && box.visible);
  EXPECT_EQ(shape("<sphere radius='0.5'/>").radius, 0.5);
  const Shape rod = shape("<cylinder radius='0.1' length='1'/>");
  EXPECT_EQ(rod.type, ShapeType::cylinder);
  EXPECT_EQ(rod.radius, 0.1);
  EXPECT_EQ(rod.half_length, 0.5);
  // Without <collision> elements, <visual> elements give shapes for display only.
  const RobotModel seen = read(robot(link("a", std::string(a_mass) + "<visual><geometry><box size='1 1 1'/></geometry></visual>")));
  EXPECT_FALSE(seen.mechanism->link(0).shapes.at(0).collides);
}

TEST(Urdf, MeshOptions) {
  const std::string text = robot(
      link("a", std::string(a_mass) + "<collision><geometry><mesh filename='package://p/m.obj' scale='2 2 -2'/></geometry></collision>"));
  RobotOptions options{.base = Base::fixed};
  options.read_asset = [](const std::string& path) -> Result<std::string> {
    if (path == "p/m.obj") return "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\n";
    return fail(ErrorCode::io, path, "The file does not exist.");
  };
  const Shape hull = read(text, options).mechanism->link(0).shapes.at(0);
  ASSERT_EQ(hull.type, ShapeType::mesh);
  EXPECT_TRUE(hull.geometry->convex && hull.geometry->prepared != nullptr);
  EXPECT_EQ(hull.geometry->triangles.size(), 4u);
  EXPECT_NEAR(volume(hull), 2 * 4 * 6 / 6.0, 1e-12);  // mirrored, but with outward triangles
  options.meshes = Meshes::box;
  const RobotModel m = read(text, options);
  expect_near(m.mechanism->link(0).shapes.at(0).half_extents, {1, 2, 3});
  expect_near(m.mechanism->link(0).shapes.at(0).X_BS.p, {1, 2, -3});
  options.meshes = Meshes::exact;  // the mesh has points without faces: the hull is used
  EXPECT_TRUE(read(text, options).mechanism->link(0).shapes.at(0).geometry->convex);
  options.meshes = Meshes::none;
  EXPECT_TRUE(read(text, options).mechanism->link(0).shapes.empty());
  options.read_asset = {};
  options.meshes = Meshes::box;
  EXPECT_TRUE(has_note(read(text, options), "were not found"));
  options.require_meshes = true;
  const Result<RobotModel> required = read_urdf(text, "r.urdf", options);
  ASSERT_FALSE(required);
  EXPECT_NE(required.error().text().find("r.urdf:2: The mesh file 'package://p/m.obj' was not found"), std::string::npos);
}

/// Number of occurrences of a word outside comments, and sum of the numbers that follow `value`.
struct Scan {
  int count = 0;
  double sum = 0;
};
Scan scan(std::string text, const std::string& word, const std::string& value = "") {
  for (std::size_t at; (at = text.find("<!--")) != std::string::npos;) text.erase(at, text.find("-->", at) + 3 - at);
  std::string line;  // white space replaced by single spaces
  for (const char c : text)
    if (const bool space = c == ' ' || c == '\n' || c == '\r' || c == '\t'; !space || !line.ends_with(' ')) line += space ? ' ' : c;
  text = line;
  Scan out;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
    ++out.count;
    if (!value.empty()) out.sum += std::strtod(text.c_str() + text.find(value, at) + value.size(), nullptr);
  }
  return out;
}

TEST(UrdfShared, CountsAndMassMatchAPlainScan) {
  NEEDS_ROBOT_DATA();
  const std::vector<std::string> files = robot_files(".urdf");
  EXPECT_GE(files.size(), 19u);
  for (const std::string& path : files) {
    SCOPED_TRACE(path);
    const std::string text = load_robot(path);
    RobotOptions options = options_for(path, false);
    options.base = Base::fixed;
    const Result<RobotModel> model = read_urdf(text, path, options);
    ASSERT_TRUE(model.has_value()) << model.error().text();
    const Mechanism& m = *model->mechanism;
    const int revolute = scan(text, "type=\"revolute\"").count + scan(text, "type=\"continuous\"").count;
    const int prismatic = scan(text, "type=\"prismatic\"").count;
    EXPECT_EQ(m.link_count(), scan(text, "<link name").count);
    EXPECT_EQ(static_cast<int>(model->joints.size()), scan(text, "<joint name").count - scan(text, "<transmission").count);
    EXPECT_EQ(m.nv(), revolute + prismatic);
    EXPECT_NEAR(m.mass(), scan(text, "<mass", "value=\"").sum, 1e-12 * m.mass());
    EXPECT_EQ(static_cast<int>(m.loops().size()), scan(text, "<mimic").count);
    const Result<RobotModel> floating = read_urdf(text, path, options_for(path));
    ASSERT_TRUE(floating.has_value()) << floating.error().text();
    std::cout << short_path(path) << ": " << m.link_count() << " links, " << m.nv() << " degrees of freedom, " << m.mass() << " kg, "
              << floating->mechanism->loops().size() << " loops; with the base of the file " << floating->mechanism->nv()
              << " degrees of freedom\n";
  }
}

}  // namespace
}  // namespace ugoki::robot_formats
