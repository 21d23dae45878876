// OpenSim models: masses, frames, joint types and functions on small models with results computed by hand.
#include "ugoki/robot_formats/osim.h"

#include <gtest/gtest.h>

#include <cmath>

#include "ugoki/mechanism/state.h"
#include "ugoki/robot_formats/osim_model.h"

namespace ugoki::robot_formats {
namespace {

std::string body(const std::string& name, const std::string& mass = "2", const std::string& centre = "0 -0.2 0") {
  return "<Body name='" + name + "'><mass>" + mass + "</mass><mass_center>" + centre +
         "</mass_center><inertia>0.02 0.01 0.02 0 0 0</inertia></Body>\n";
}
std::string coordinate(const std::string& name, const std::string& range = "-2 2", const std::string& more = "") {
  return "<Coordinate name='" + name + "'><default_value>0</default_value><range>" + range + "</range>" + more + "</Coordinate>";
}
std::string frame(const std::string& name, const std::string& parent, const std::string& p, const std::string& r = "0 0 0") {
  return "<PhysicalOffsetFrame name='" + name + "'><socket_parent>/bodyset/" + parent + "</socket_parent><translation>" + p +
         "</translation><orientation>" + r + "</orientation></PhysicalOffsetFrame>";
}
std::string axis(const std::string& name, const std::string& coordinates, const std::string& direction, const std::string& function) {
  return "<TransformAxis name='" + name + "'><coordinates>" + coordinates + "</coordinates><axis>" + direction + "</axis>" + function +
         "</TransformAxis>";
}
const std::string linear = "<LinearFunction name='function'><coefficients> 1 0</coefficients></LinearFunction>";
const std::string zero = "<Constant name='function'><value>0</value></Constant>";

std::string model(const std::string& bodies, const std::string& joints, const std::string& more = "") {
  return "<?xml version='1.0'?><OpenSimDocument Version='40000'><Model name='m'><gravity>0 -9.81 0</gravity><BodySet><objects>" + bodies +
         "</objects></BodySet><JointSet><objects>" + joints + "</objects></JointSet>" + more + "</Model></OpenSimDocument>";
}
/// A body that moves freely in the plane, and a shank with the given knee.
std::string leg(const std::string& knee) {
  const std::string planar =
      "<PlanarJoint name='root'><socket_parent_frame>/ground</socket_parent_frame><socket_child_frame>thigh"
      "</socket_child_frame><coordinates>" +
      coordinate("tilt") + coordinate("tx", "-5 5") + coordinate("ty", "-1 3") + "</coordinates></PlanarJoint>";
  return model(body("thigh", "7") + body("shank", "3.5"), planar + knee);
}
const std::string pin =
    "<PinJoint name='knee'><socket_parent_frame>at_thigh</socket_parent_frame><socket_child_frame>at_shank"
    "</socket_child_frame><coordinates>" +
    coordinate("bend", "-2.4 0.1") + "</coordinates><frames>" + frame("at_thigh", "thigh", "0 -0.4 0", "0 0 0.5") +
    frame("at_shank", "shank", "0 0.05 0") + "</frames></PinJoint>";

TEST(Osim, PlacesBodiesByTheEquationsOfTheirJoints) {
  const auto robot = read_osim(leg(pin), "leg.osim");
  ASSERT_TRUE(robot.has_value()) << robot.error().text();
  const Mechanism& m = *robot->mechanism;
  EXPECT_NEAR(m.mass(), 10.5, 1e-12);
  ASSERT_EQ(m.link_count(), 2);
  EXPECT_EQ(m.link(0).joint.type, JointType::planar);
  EXPECT_EQ(m.link(1).joint.type, JointType::revolute);
  EXPECT_NEAR(m.dof(3).lower, -2.4, 1e-12);
  // In the plane: the shank's origin = thigh + R(tilt) (0, -0.4) - R(tilt + 0.5 + bend) (0, 0.05). World: (x, y) is (x, z).
  const double tilt = 0.3, bend = -0.7, tx = 1.2, ty = 0.9;
  std::vector<double> q = m.neutral();
  q[0] = tx, q[1] = ty, q[2] = tilt, q[3] = bend;
  std::vector<Pose> X(2);
  calc_poses(m, q, X);
  const Pose thigh = X[0] * robot->X_BF[0], shank = X[1] * robot->X_BF[1];
  const double a = tilt + 0.5 + bend;
  EXPECT_NEAR(norm(thigh.p - Vec3{tx, 0, ty}), 0, 1e-12);
  EXPECT_NEAR(norm(shank.p - Vec3{tx + 0.4 * std::sin(tilt) + 0.05 * std::sin(a), 0, ty - 0.4 * std::cos(tilt) - 0.05 * std::cos(a)}), 0,
              1e-12);
  // The centre of mass follows the body's frame.
  const Vec3 centre = X[1] * m.link(1).inertia.centre();
  EXPECT_NEAR(norm(centre - (shank.p + Vec3{0.2 * std::sin(a), 0, -0.2 * std::cos(a)})), 0, 1e-12);
}

TEST(Osim, OldFilesGiveTheSameMechanism) {
  const std::string joint =
      "<location_in_parent>0 -0.4 0</location_in_parent><orientation_in_parent>0 0 0.5</orientation_in_parent>"
      "<location>0 0.05 0</location><orientation>0 0 0</orientation>";
  const std::string old =
      "<OpenSimDocument Version='30000'><Model name='m'><BodySet><objects><Body name='ground'><mass>0</mass></Body>"
      "<Body name='thigh'><mass>7</mass><mass_center>0 -0.2 0</mass_center><inertia_xx>0.02</inertia_xx><inertia_yy>0.01</inertia_yy>"
      "<inertia_zz>0.02</inertia_zz><Joint><PlanarJoint name='root'><parent_body>ground</parent_body><CoordinateSet><objects>" +
      coordinate("tilt") + coordinate("tx", "-5 5") + coordinate("ty", "-1 3") +
      "</objects></CoordinateSet></PlanarJoint></Joint></Body><Body name='shank'><mass>3.5</mass><mass_center>0 -0.2 0</mass_center>"
      "<inertia_xx>0.02</inertia_xx><inertia_yy>0.01</inertia_yy><inertia_zz>0.02</inertia_zz><Joint><PinJoint name='knee'>"
      "<parent_body>thigh</parent_body>" +
      joint + "<CoordinateSet><objects>" + coordinate("bend", "-2.4 0.1") +
      "</objects></CoordinateSet></PinJoint></Joint></Body></objects></BodySet></Model></OpenSimDocument>";
  const auto a = read_osim(leg(pin), "a.osim"), b = read_osim(old, "b.osim");
  ASSERT_TRUE(a.has_value() && b.has_value()) << (b ? a.error().text() : b.error().text());
  for (int i = 0; i < 2; ++i) {
    const Link &p = a->mechanism->link(i), &q = b->mechanism->link(i);
    EXPECT_EQ(p.name, q.name);
    EXPECT_EQ(p.joint.type, q.joint.type);
    EXPECT_NEAR(norm(p.joint.X_PJ.p - q.joint.X_PJ.p), 0, 1e-15);
    EXPECT_NEAR(norm(p.inertia.h - q.inertia.h), 0, 1e-15);
  }
}

/// A spline whose end conditions are those of the cubic through the outer points reproduces every cubic.
TEST(Osim, SplineThroughACubicIsTheCubic) {
  const auto cubic = [](double x) { return 0.3 - x + 2 * x * x - 0.7 * x * x * x; };
  std::string x, y;
  for (const double k : {-1.0, -0.4, 0.1, 0.5, 1.3, 2.0}) {
    x += std::to_string(k) + " ";
    char text[40];
    std::snprintf(text, sizeof text, "%.17g ", cubic(k));
    y += text;
  }
  const std::string knee =
      "<CustomJoint name='knee'><socket_parent_frame>thigh</socket_parent_frame><socket_child_frame>shank"
      "</socket_child_frame><coordinates>" +
      coordinate("bend", "-1 2") + "</coordinates><SpatialTransform>" + axis("rotation1", "bend", "0 0 1", linear) +
      axis("translation1", "bend", "1 0 0", "<SimmSpline name='function'><x>" + x + "</x><y>" + y + "</y></SimmSpline>") +
      "</SpatialTransform></CustomJoint>";
  XmlFields xml("m.osim", "OpenSim");
  ASSERT_TRUE(xml.parse(leg(knee)));
  OsimModel m;
  ASSERT_TRUE(read_osim_model(xml, m));
  for (double u = -1; u <= 2; u += 0.05) {
    const double at[1] = {u};
    EXPECT_NEAR(m.bodies[1].motion[3].function(at), cubic(u), 1e-12) << u;
  }
  // Beyond the last knot the spline continues along its tangent.
  const double beyond[1] = {2.5};
  EXPECT_NEAR(m.bodies[1].motion[3].function(beyond), cubic(2) + 0.5 * (-1 + 8 - 8.4), 1e-12);
}

/// Translations that are those of a hinge beside the frames' origins: the fitted hinge is exact.
TEST(Osim, FindsTheHingeOfAJointThatFollowsCurves) {
  std::string x, tx, ty;
  for (int k = 0; k <= 40; ++k) {
    const double a = -2 + 0.1 * k;
    char text[3][40];
    std::snprintf(text[0], 40, "%.17g ", a);
    std::snprintf(text[1], 40, "%.17g ", 0.03 - 0.02 * std::cos(a) - 0.05 * std::sin(a));
    std::snprintf(text[2], 40, "%.17g ", -0.4 - 0.02 * std::sin(a) + 0.05 * std::cos(a));
    x += text[0], tx += text[1], ty += text[2];
  }
  const auto spline = [&](const std::string& y) { return "<SimmSpline name='f'><x>" + x + "</x><y>" + y + "</y></SimmSpline>"; };
  const std::string knee =
      "<CustomJoint name='knee'><socket_parent_frame>thigh</socket_parent_frame><socket_child_frame>shank"
      "</socket_child_frame><coordinates>" +
      coordinate("bend", "-2 2") + "</coordinates><SpatialTransform>" + axis("rotation1", "bend", "0 0 1", linear) +
      axis("translation1", "bend", "1 0 0", spline(tx)) + axis("translation2", "bend", "0 1 0", spline(ty)) +
      "</SpatialTransform></CustomJoint>";
  XmlFields xml("m.osim", "OpenSim");
  ASSERT_TRUE(xml.parse(leg(knee)));
  OsimModel m;
  ASSERT_TRUE(read_osim_model(xml, m));
  const OsimJointFit fit = fit_joint(m, m.bodies[1]);
  ASSERT_EQ(fit.chain.size(), 1u);
  EXPECT_EQ(fit.chain[0].joint.type, JointType::revolute);
  EXPECT_LT(fit.deviation, 2e-5);
  EXPECT_NEAR(fit.chain[0].joint.X_PJ.p.x, 0.03, 1e-5);
  EXPECT_NEAR(fit.chain[0].joint.X_PJ.p.y, -0.4, 1e-5);
}

TEST(Osim, ChoosesTheJointTypesOfTheirAxes) {
  const auto type = [](const std::string& joint) {
    const auto robot = read_osim(model(body("a"), joint), "a.osim");
    EXPECT_TRUE(robot.has_value()) << robot.error().text();
    if (!robot) return std::string("none");
    std::string out;
    for (const Link& l : robot->mechanism->links()) out += std::string(out.empty() ? "" : " ") + std::string(name_of(l.joint.type));
    return out;
  };
  const auto make = [](const std::string& kind, int count, const std::string& inside = "") {
    std::string c;
    for (int i = 0; i < count; ++i) c += coordinate("q" + std::to_string(i));
    return "<" + kind +
           " name='j'><socket_parent_frame>/ground</socket_parent_frame><socket_child_frame>a</socket_child_frame><coordinates>" + c +
           "</coordinates>" + inside + "</" + kind + ">";
  };
  EXPECT_EQ(type(make("WeldJoint", 0)), "fixed");
  EXPECT_EQ(type(make("SliderJoint", 1)), "prismatic");
  EXPECT_EQ(type(make("UniversalJoint", 2)), "universal");
  EXPECT_EQ(type(make("BallJoint", 3)), "spherical");
  EXPECT_EQ(type(make("FreeJoint", 6)), "floating");
  EXPECT_EQ(type(make("CustomJoint", 2,
                      "<SpatialTransform>" + axis("rotation1", "q0", "0 0 1", linear) + axis("translation3", "q1", "0 0 1", linear) +
                          axis("rotation2", "", "1 0 0", zero) + "</SpatialTransform>")),
            "prismatic revolute");
}

TEST(Osim, NamesFaults) {
  const auto refused = [](const std::string& text, const std::string& what) {
    const auto robot = read_osim(text, "bad.osim");
    ASSERT_FALSE(robot.has_value());
    EXPECT_NE(robot.error().text().find(what), std::string::npos) << robot.error().text();
  };
  refused("<robot/>", "not an OpenSim model");
  refused(model("", ""), "no <Body>");
  refused(model(body("a") + body("a"), ""), "Two bodies are named 'a'");
  refused(
      model(body("a"),
            "<PinJoint name='j'><socket_parent_frame>/ground</socket_parent_frame><socket_child_frame>b</socket_child_frame></PinJoint>"),
      "child frame");
  refused(
      model(body("a"),
            "<PinJoint name='j'><socket_parent_frame>/ground</socket_parent_frame><socket_child_frame>a</socket_child_frame></PinJoint>"),
      "needs 1");
}

}  // namespace
}  // namespace ugoki::robot_formats
