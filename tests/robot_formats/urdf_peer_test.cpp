// Compares our URDF reader with MuJoCo's, in random states: poses, inertia matrix, inverse and forward dynamics.

#include <gtest/gtest.h>

#include <pugixml.hpp>
#include <sstream>

#include "named_peer.h"
#include "robot_data.h"
#include "ugoki/base/number.h"
#include "ugoki/robot_formats/symmetric_eigen.h"
#include "ugoki/robot_formats/urdf.h"

namespace ugoki::robot_formats {
namespace {

#ifndef UGOKI_HAVE_MUJOCO
TEST(UrdfPeer, SharedFiles) { GTEST_SKIP() << "MuJoCo (libmujoco-dev) is not installed"; }
#else

std::string text_of(const pugi::xml_document& document) {
  std::ostringstream out;
  document.save(out);
  return out.str();
}

/// Changes parts of a URDF that MuJoCo cannot read: shapes are removed, massless bodies get a mass, physically impossible inertias become
/// those of a sphere. Both readers get the changed URDF.
void make_readable(pugi::xml_node robot) {
  for (pugi::xml_node link : robot.children("link")) {
    while (link.remove_child("visual") || link.remove_child("collision")) {
    }
    pugi::xml_node inertial = link.child("inertial");
    if (!inertial) continue;
    pugi::xml_node inertia = inertial.child("inertia");
    const auto I = [&](const char* name) { return inertia.attribute(name).as_double(); };
    const double a = I("ixx"), b = I("iyy"), c = I("izz");
    const bool weightless = inertial.child("mass").attribute("value").as_double() < 1e-6;
    // The matrix tr(I)/2 E - I (E: identity) must be positive definite. Sylvester's criterion.
    const double t = 0.5 * (a + b + c), p = t - a, q = t - b, r = t - c, xy = -I("ixy"), xz = -I("ixz"), yz = -I("iyz");
    const double det = p * (q * r - yz * yz) - xy * (xy * r - yz * xz) + xz * (xy * yz - q * xz);
    const bool impossible = p <= 0 || p * q - xy * xy <= 0 || det <= 0;
    if (weightless) inertial.child("mass").attribute("value").set_value(0.02);
    if (!weightless && !impossible) continue;
    for (const char* name : {"ixy", "ixz", "iyz"}) inertia.attribute(name).set_value(0.0);
    const double ball = weightless ? 2e-5 : std::max({a, b, c});
    for (const char* name : {"ixx", "iyy", "izz"}) inertia.attribute(name).set_value(ball);
  }
}

/// Rewrites every inertia along its principal axes, because MuJoCo computes these only to about 1e-8.
void use_principal_axes(pugi::xml_node robot) {
  for (const pugi::xml_node link : robot.children("link")) {
    pugi::xml_node inertial = link.child("inertial");
    if (!inertial) continue;
    pugi::xml_node inertia = inertial.child("inertia"), origin = inertial.child("origin");
    if (!origin) origin = inertial.append_child("origin");
    const auto I = [&](const char* name) { return inertia.attribute(name).as_double(); };
    const SymmetricEigen e = symmetric_eigen({I("ixx"), I("iyy"), I("izz"), I("ixy"), I("ixz"), I("iyz")});
    std::istringstream rpy(origin.attribute("rpy").as_string("0 0 0"));
    Vec3 a;
    rpy >> a.x >> a.y >> a.z;
    const Vec3 turned = to_euler(from_euler({a.z, a.y, a.x}, "ZYX") * e.V, "ZYX");
    origin.remove_attribute("rpy");
    origin.append_attribute("rpy").set_value((to_text(turned.z) + " " + to_text(turned.y) + " " + to_text(turned.x)).c_str());
    for (const char* name : {"ixy", "ixz", "iyz"}) inertia.attribute(name).set_value(0.0);
    for (const auto& [name, value] : {std::pair{"ixx", e.values.x}, {"iyy", e.values.y}, {"izz", e.values.z}})
      inertia.attribute(name).set_value(to_text(value).c_str());
  }
}

/// Adds MuJoCo's compiler options and, for a floating base, a link "world": MuJoCo fixes the root link unless its parent has this name.
std::string for_mujoco(const std::string& text, bool floating) {
  pugi::xml_document document;
  document.load_string(text.c_str());
  pugi::xml_node robot = document.document_element();
  pugi::xml_node compiler = robot.append_child("mujoco").append_child("compiler");
  for (const auto& [name, value] :
       {std::pair{"fusestatic", "false"}, {"balanceinertia", "false"}, {"boundmass", "0"}, {"boundinertia", "0"}})
    compiler.append_attribute(name).set_value(value);
  if (floating) {
    std::string root;
    for (const pugi::xml_node link : robot.children("link")) {
      bool child = false;
      for (const pugi::xml_node joint : robot.children("joint"))
        child = child || std::string(joint.child("child").attribute("link").value()) == link.attribute("name").value();
      if (!child) root = link.attribute("name").value();
    }
    robot.append_child("link").append_attribute("name").set_value("world");
    pugi::xml_node joint = robot.append_child("joint");
    joint.append_attribute("name").set_value("peer_base");
    joint.append_attribute("type").set_value("floating");
    joint.append_child("parent").append_attribute("link").set_value("world");
    joint.append_child("child").append_attribute("link").set_value(root.c_str());
  }
  return text_of(document);
}

/// @param principal true: inertias are written along their principal axes, so that the results can be compared up to rounding
void compare(const std::string& path, int states, bool principal, bool print) {
  SCOPED_TRACE(path);
  pugi::xml_document document;
  ASSERT_TRUE(document.load_file(path.c_str()));
  make_readable(document.document_element());
  if (principal) use_principal_axes(document.document_element());
  const std::string text = text_of(document);
  for (const Base base : {Base::fixed, Base::floating}) {
    if (short_path(path) == "urdf_only/ur5_robot.urdf" && base == Base::floating) continue;  // its base has no mass
    RobotOptions options;
    options.base = base;
    const Result<RobotModel> model = read_urdf(text, path, options);
    ASSERT_TRUE(model.has_value()) << model.error().text();
    std::string why;
    const MujocoModel theirs = open_in_mujoco(for_mujoco(text, base == Base::floating), why);
    ASSERT_NE(theirs, nullptr) << why;
    NamedPeer peer(*model, *theirs);
    ASSERT_EQ(peer.mismatch(), "");
    Disagreement worst;
    std::mt19937 random(7);
    for (int i = 0; i < states; ++i) peer.compare(random, worst);
    EXPECT_LT(worst.pose, 1e-9);
    EXPECT_LT(worst.inertia, principal ? 1e-8 : 1e-6);
    EXPECT_LT(worst.inverse, principal ? 1e-8 : 1e-6);
    EXPECT_LT(worst.forward, principal ? 1e-8 : 1e-4);
    // The methods lose accuracy with the condition number of M, which is 1e9 for a sphere of 654 t on rods of 25 kg.
    EXPECT_LT(worst.methods, short_path(path) == "5bar_linkage/robot.urdf" ? 1e-8 : 1e-9);
    if (print)
      std::printf("%-45s %-8s nv %3d  pose %.1e  M %.1e  inverse %.1e  forward %.1e  three methods %.1e\n", short_path(path).c_str(),
                  base == Base::fixed ? "fixed" : "floating", model->mechanism->nv(), worst.pose, worst.inertia, worst.inverse,
                  worst.forward, worst.methods);
  }
}

TEST(UrdfPeer, SharedFiles) {
  NEEDS_ROBOT_DATA();
  for (const std::string& path : robot_files(".urdf"))
    for (const bool principal : {true, false}) compare(path, 3, principal, false);
}

TEST(SlowUrdfPeer, SharedFilesInAHundredStates) {
  NEEDS_ROBOT_DATA();
  for (const std::string& path : robot_files(".urdf"))
    for (const bool principal : {true, false}) compare(path, 100, principal, principal);
}
#endif

}  // namespace
}  // namespace ugoki::robot_formats
