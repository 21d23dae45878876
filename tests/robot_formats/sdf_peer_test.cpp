// Compares our SDF reader with MuJoCo: the test parses the SDF independently with MuJoCo's rotation functions, and writes it as MJCF.

#include <gtest/gtest.h>

#include <map>
#include <pugixml.hpp>
#include <sstream>

#include "named_peer.h"
#include "robot_data.h"
#include "ugoki/base/number.h"
#include "ugoki/robot_formats/sdf.h"
#include "ugoki/robot_formats/symmetric_eigen.h"

namespace ugoki::robot_formats {
namespace {

#ifndef UGOKI_HAVE_MUJOCO
TEST(SdfPeer, SharedFiles) { GTEST_SKIP() << "MuJoCo (libmujoco-dev) is not installed"; }
#else

/// A pose in MuJoCo's representation: position and quaternion.
struct Placed {
  mjtNum p[3] = {0, 0, 0}, q[4] = {1, 0, 0, 0};
};
Placed operator*(const Placed& a, const Placed& b) {
  Placed out;
  mju_rotVecQuat(out.p, b.p, a.q);
  mju_addTo3(out.p, a.p);
  mju_mulQuat(out.q, a.q, b.q);
  return out;
}
Placed inverse(const Placed& a) {
  Placed out;
  mju_negQuat(out.q, a.q);
  mju_rotVecQuat(out.p, a.p, out.q);
  mju_scl3(out.p, out.p, -1);
  return out;
}

std::string text_of(const mjtNum* v, int n) {
  std::string out;
  for (int i = 0; i < n; ++i) out += ugoki::to_text(v[i]) + " ";
  return out;
}
std::string attributes(const Placed& X) { return " pos='" + text_of(X.p, 3) + "' quat='" + text_of(X.q, 4) + "'"; }

Placed pose_of(pugi::xml_node node) {
  Placed out;
  std::istringstream in(node.child_value("pose"));
  mjtNum a[3] = {0, 0, 0};
  in >> out.p[0] >> out.p[1] >> out.p[2] >> a[0] >> a[1] >> a[2];
  for (int i = 2; i >= 0; --i) {  // yaw, pitch, roll
    mjtNum axis[3] = {0, 0, 0}, turn[4], all[4];
    axis[i] = 1;
    mju_axisAngle2Quat(turn, axis, a[i]);
    mju_mulQuat(all, out.q, turn);
    mju_copy4(out.q, all);
  }
  return out;
}

/// An independent reader of the SDF features that the shared files use.
class PlainSdf {
 public:
  explicit PlainSdf(const std::string& text) {
    document_.load_string(text.c_str());
    model_ = document_.child("sdf").child("model");
  }

  /// Pose of a link, joint or frame in the world, with all joints at zero.
  Placed at(const std::string& name) const {
    if (name == "world" || name == "__model__") return {};
    const pugi::xml_node node = find(name);
    std::string base = node.child("pose").attribute("relative_to").value();
    if (base.empty()) base = node.attribute("attached_to").value();
    if (base.empty()) base = std::string(node.name()) == "joint" ? node.child_value("child") : "__model__";
    return at(base) * pose_of(node);
  }
  pugi::xml_node find(const std::string& name) const { return model_.find_child_by_attribute("name", name.c_str()); }
  std::string link_of(const std::string& name) const {
    const pugi::xml_node node = find(name);
    return node && node.attribute("attached_to") ? link_of(node.attribute("attached_to").value()) : name;
  }

  /// The bodies of our tree as MJCF. @param joint_of joints of the file, by the link that they carry
  std::string mjcf(const Mechanism& m, const std::map<std::string, std::string>& joint_of) const {
    std::string out = "<mujoco><compiler angle='radian' balanceinertia='false' boundmass='0' boundinertia='0'/><worldbody>";
    for (int i = 0; i < m.link_count(); ++i)
      if (m.link(i).parent < 0) write(m, i, joint_of, out);
    return out + "</worldbody></mujoco>";
  }

 private:
  void write(const Mechanism& m, int i, const std::map<std::string, std::string>& joint_of, std::string& out) const {
    const std::string& name = m.link(i).name;
    const std::string parent = m.link(i).parent < 0 ? "world" : m.link(m.link(i).parent).name;
    Placed X_PC = inverse(at(parent)) * at(name);
    std::string joint_text = m.link(i).joint.type == JointType::floating ? "<freejoint/>" : "";
    if (const auto it = joint_of.find(name); it != joint_of.end()) {
      const pugi::xml_node joint = find(it->second);
      const Placed X_CJ = inverse(at(name)) * at(it->second);
      const std::string location = joint.child_value("parent");
      if (!find(name).child("pose") && find(location).attribute("attached_to")) X_PC = inverse(at(parent)) * at(location) * inverse(X_CJ);
      std::istringstream in(joint.child("axis").child_value("xyz"));
      mjtNum axis[3] = {0, 0, 1}, turned[3];
      in >> axis[0] >> axis[1] >> axis[2];
      mju_rotVecQuat(turned, axis,
                     X_CJ.q);  // also for axes in the model frame, because in such files model and joint frame are parallel
      joint_text = std::string("<joint type='") + (std::string(joint.attribute("type").value()) == "ball" ? "ball" : "hinge") + "' pos='" +
                   text_of(X_CJ.p, 3) + "' axis='" + text_of(turned, 3) + "'/>";
    }
    out += "<body name='" + name + "'" + attributes(X_PC) + ">" + joint_text;
    const pugi::xml_node inertial = find(name).child("inertial"), inertia = inertial.child("inertia");
    const auto I = [&](const char* moment) { return std::strtod(inertia.child_value(moment), nullptr); };
    const SymmetricEigen e = symmetric_eigen({I("ixx"), I("iyy"), I("izz"), I("ixy"), I("ixz"), I("iyz")});
    Placed principal;
    const mjtNum R[9] = {e.V.xx, e.V.xy, e.V.xz, e.V.yx, e.V.yy, e.V.yz, e.V.zx, e.V.zy, e.V.zz};
    mju_mat2Quat(principal.q, R);
    const mjtNum moments[3] = {e.values.x, e.values.y, e.values.z};
    out += "<inertial mass='" + std::string(inertial.child_value("mass")) + "' diaginertia='" + text_of(moments, 3) + "'" +
           attributes(pose_of(inertial) * principal) + "/>";
    for (int k = m.link(i).child; k >= 0; k = m.link(k).sibling) write(m, k, joint_of, out);
    out += "</body>";
  }

  pugi::xml_document document_;
  pugi::xml_node model_;
};

/// MuJoCo refuses rods without thickness: zero moments become 0.001 kg m^2 for both readers.
std::string with_thickness(std::string text) {
  for (const char* moment : {"ixx", "iyy", "izz"}) {
    const std::string nothing = "<" + std::string(moment) + ">0</";
    for (std::size_t at; (at = text.find(nothing)) != std::string::npos;)
      text.replace(at, nothing.size(), "<" + std::string(moment) + ">0.001</");
  }
  return text;
}

void compare(const std::string& path, Base base, int states, bool print) {
  SCOPED_TRACE(path);
  const std::string text = with_thickness(load_robot(path));
  RobotOptions options;
  options.base = base;
  const Result<RobotModel> model = read_sdf(text, path, options);
  ASSERT_TRUE(model.has_value()) << model.error().text();
  std::map<std::string, std::string> joint_of;
  for (const JointName& j : model->joints) joint_of[j.link] = j.joint;
  std::string why;
  const MujocoModel theirs = open_in_mujoco(PlainSdf(text).mjcf(*model->mechanism, joint_of), why);
  ASSERT_NE(theirs, nullptr) << why;
  NamedPeer peer(*model, *theirs);
  ASSERT_EQ(peer.mismatch(), "");
  EXPECT_NEAR(model->mechanism->mass(), mj_getTotalmass(theirs.get()), 1e-12 * model->mechanism->mass());
  Disagreement worst;
  std::mt19937 random(11);
  for (int i = 0; i < states; ++i) peer.compare(random, worst);
  EXPECT_LT(worst.pose, 1e-9);
  EXPECT_LT(worst.inertia, 1e-8);
  EXPECT_LT(worst.inverse, 1e-8);
  EXPECT_LT(worst.forward, 1e-8);
  EXPECT_LT(worst.methods, 1e-9);
  if (print)
    std::printf("%-35s %-8s nv %3d  pose %.1e  M %.1e  inverse %.1e  forward %.1e  three methods %.1e\n", short_path(path).c_str(),
                base == Base::fixed ? "fixed" : "by file", model->mechanism->nv(), worst.pose, worst.inertia, worst.inverse, worst.forward,
                worst.methods);
}

TEST(SdfPeer, SharedFiles) {
  NEEDS_ROBOT_DATA();
  for (const std::string& path : robot_files(".sdf"))
    for (const Base base : {Base::by_file, Base::fixed}) compare(path, base, 3, false);
}

TEST(SlowSdfPeer, SharedFilesInAHundredStates) {
  NEEDS_ROBOT_DATA();
  for (const std::string& path : robot_files(".sdf"))
    for (const Base base : {Base::by_file, Base::fixed}) compare(path, base, 100, true);
}
#endif

}  // namespace
}  // namespace ugoki::robot_formats
