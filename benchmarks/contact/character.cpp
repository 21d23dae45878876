#include "character.h"

#include <string>

#include "ugoki/base/check.h"

namespace ugoki::benchmarks {
namespace {

/// Makes a link with a box of `size` [m]. The joint is at `at` [m] in the parent's frame; the box's centre is at `along` [m] in the link's
/// frame.
LinkSpec make_link(const std::string& name, const std::string& parent, JointType type, const Vec3& at, const Vec3& size,
                   const Vec3& along) {
  LinkSpec link;
  link.name = name;
  link.parent = parent;
  link.joint.type = type;
  link.joint.X_PJ = {Mat3::identity(), at};
  link.joint.axis = {0, 1, 0};
  const Shape box = Shape::box(size * 0.5, {Mat3::identity(), along});
  link.shapes = {box};
  link.inertia = solid_inertia(box, 1000);
  for (Dof& f : link.joint.dofs) f.armature = type == JointType::floating ? 0 : 0.01;
  return link;
}

void add_limbs(MechanismSpec& spec, const std::string& side, double y) {
  const JointType ball = JointType::spherical, hinge = JointType::revolute;
  const auto link = [&](const char* name, const std::string& parent, JointType type, const Vec3& at, const Vec3& size, const Vec3& along) {
    spec.links.push_back(make_link(name + side, parent, type, at, size, along));
  };
  link("thigh", "pelvis", ball, {0, 0.09 * y, -0.05}, {0.14, 0.14, 0.40}, {0, 0, -0.20});
  link("shank", "thigh" + side, hinge, {0, 0, -0.42}, {0.10, 0.10, 0.38}, {0, 0, -0.20});
  link("foot", "shank" + side, ball, {0, 0, -0.42}, {0.20, 0.09, 0.06}, {0.05, 0, -0.05});
  link("toes", "foot" + side, hinge, {0.15, 0, -0.05}, {0.07, 0.09, 0.06}, {0.035, 0, 0});
  link("shoulder", "chest", hinge, {0, 0.05 * y, 0.20}, {0.08, 0.14, 0.08}, {0, 0.07 * y, 0});
  link("upper arm", "shoulder" + side, ball, {0, 0.15 * y, 0}, {0.08, 0.08, 0.28}, {0, 0, -0.14});
  link("forearm", "upper arm" + side, hinge, {0, 0, -0.29}, {0.07, 0.07, 0.25}, {0, 0, -0.13});
  link("hand", "forearm" + side, hinge, {0, 0, -0.26}, {0.08, 0.03, 0.17}, {0, 0, -0.08});
}

}  // namespace

MechanismPtr make_character() {
  MechanismSpec spec;
  spec.name = "character";
  spec.links.push_back(make_link("pelvis", "", JointType::floating, {}, {0.18, 0.28, 0.16}, {0, 0, 0.03}));
  spec.links.push_back(make_link("abdomen", "pelvis", JointType::spherical, {0, 0, 0.12}, {0.18, 0.26, 0.16}, {0, 0, 0.08}));
  spec.links.push_back(make_link("loin", "abdomen", JointType::revolute, {0, 0, 0.16}, {0.18, 0.26, 0.08}, {0, 0, 0.04}));
  spec.links.push_back(make_link("chest", "loin", JointType::spherical, {0, 0, 0.08}, {0.20, 0.30, 0.24}, {0, 0, 0.12}));
  spec.links.push_back(make_link("neck", "chest", JointType::spherical, {0, 0, 0.25}, {0.10, 0.10, 0.10}, {0, 0, 0.05}));
  spec.links.push_back(make_link("head", "neck", JointType::revolute, {0, 0, 0.10}, {0.18, 0.15, 0.23}, {0, 0, 0.12}));
  add_limbs(spec, " left", 1);
  add_limbs(spec, " right", -1);
  Result<MechanismPtr> made = Mechanism::make(std::move(spec));
  UGOKI_CHECK(made.has_value());
  return *made;
}

State lively_state(const Mechanism& character) {
  State state(character);
  std::vector<double> bend(static_cast<std::size_t>(character.nv()));
  for (std::size_t i = 0; i < bend.size(); ++i) {
    bend[i] = 0.05 * static_cast<double>(static_cast<int>(i * 7 % 13) - 6);
    state.v[i] = 0.3 * static_cast<double>(static_cast<int>(i * 5 % 11) - 5);
    state.tau[i] = 4.0 * static_cast<double>(static_cast<int>(i * 3 % 7) - 3);
  }
  integrate(character, character.neutral(), bend, 1.0, state.q);
  return state;
}

State standing_state(const Mechanism& character) {
  State state(character);
  state.q[2] = 0.05 + 0.42 + 0.42 + 0.05 + 0.03;
  return state;
}

}  // namespace ugoki::benchmarks
