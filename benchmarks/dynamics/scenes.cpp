#include "scenes.h"

#include <cmath>
#include <fstream>
#include <iterator>
#include <stdexcept>

#ifdef UGOKI_HAVE_ROBOT_FORMATS
#include "ugoki/robot_formats/urdf.h"
#endif

namespace ugoki::benchmarks {
namespace {

void add(MechanismSpec& spec, const std::string& name, const std::string& parent, char axis, const Vec3& at, double mass,
         const Vec3& centre) {
  LinkSpec link;
  link.name = name;
  link.parent = parent;
  link.joint.type = axis == 'f' ? JointType::floating : JointType::revolute;
  link.joint.axis = axis == 'x' ? Vec3{1, 0, 0} : axis == 'y' ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
  link.joint.X_PJ.p = at;
  link.inertia = Inertia::from_centre(mass, centre, {1, 1, 1, 0, 0, 0});
  spec.links.push_back(link);
}

/// A humanoid with joints, masses and sizes similar to those of the URDF file.
MechanismSpec humanoid_like() {
  MechanismSpec spec;
  spec.name = "humanoid";
  add(spec, "body", "", 'f', {}, 25, {0, 0, 0.04});
  for (const double side : {-1.0, 1.0}) {
    const std::string s = side < 0 ? "right " : "left ";
    add(spec, s + "hip x", "body", 'x', {0, 0.1 * side, 0}, 2.5, {0, 0.1 * side, 0});
    add(spec, s + "hip y", s + "hip x", 'y', {}, 2, {0, 0, -0.15});
    add(spec, s + "thigh", s + "hip y", 'z', {0, 0, -0.35}, 5, {0, 0.04 * side, 0});
    add(spec, s + "shank", s + "thigh", 'y', {}, 7, {0, 0, -0.3});
    add(spec, s + "ankle", s + "shank", 'y', {0, 0, -0.3}, 2.5, {-0.15, 0, 0});
    add(spec, s + "foot", s + "ankle", 'x', {}, 2, {0.28, 0, -0.2});
  }
  add(spec, "waist y", "body", 'y', {0, 0, 0.18}, 6, {0, 0, -0.1});
  add(spec, "waist x", "waist y", 'x', {}, 30, {0.1, 0, 0.25});
  add(spec, "chest", "waist x", 'z', {0, 0, 0.35}, 13, {});
  for (const double side : {-1.0, 1.0}) {
    const std::string s = side < 0 ? "right " : "left ";
    add(spec, s + "shoulder y", "chest", 'y', {0, 0.2 * side, 0}, 3, {0.1, 0, 0});
    add(spec, s + "shoulder x", s + "shoulder y", 'x', {}, 0.6, {0, 0, -0.1});
    add(spec, s + "upper arm", s + "shoulder x", 'z', {0, 0, -0.26}, 1, {});
    add(spec, s + "elbow", s + "upper arm", 'y', {}, 0.6, {0, 0, -0.3});
    add(spec, s + "forearm", s + "elbow", 'z', {0, 0, -0.25}, 0.4, {0, 0, 0.1});
    add(spec, s + "wrist", s + "forearm", 'y', {}, 0.4, {-0.1, 0, 0});
    add(spec, s + "hand", s + "wrist", 'x', {}, 0.4, {0, 0, -0.1});
  }
  return spec;
}

MechanismPtr made(MechanismSpec spec) {
  Result<MechanismPtr> m = Mechanism::make(std::move(spec));
  if (!m) throw std::runtime_error(m.error().text());
  return *m;
}

}  // namespace

MechanismPtr make_humanoid() {
#ifdef UGOKI_HAVE_ROBOT_FORMATS
  std::ifstream file(UGOKI_SHARED_DATA "/mechanism/open_chain/urdf/simple_humanoid_description/urdf/simple_humanoid.urdf");
  if (file) {
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    Result<robot_formats::RobotModel> model = robot_formats::read_urdf(
        text, "simple_humanoid.urdf", {.base = robot_formats::Base::floating, .meshes = robot_formats::Meshes::none});
    if (!model) throw std::runtime_error(model.error().text());
    return model->mechanism;
  }
#endif
  return made(humanoid_like());
}

MechanismPtr make_chain(int links) {
  MechanismSpec spec;
  spec.name = "chain";
  for (int i = 0; i < links; ++i) {
    add(spec, "l" + std::to_string(i), i == 0 ? "" : "l" + std::to_string(i - 1), static_cast<char>('x' + i % 3), {0, 0, i == 0 ? 0 : 0.3},
        1, {0, 0, 0.15});
    spec.links.back().inertia = Inertia::from_centre(1, {0, 0, 0.15}, {0.01, 0.01, 0.002, 0, 0, 0});
  }
  return made(std::move(spec));
}

State lively_state(const Mechanism& m, int which, double speed) {
  State s(m);
  std::vector<double> bend(s.v.size());
  for (std::size_t i = 0; i < bend.size(); ++i) {
    const int k = static_cast<int>(i) + which;
    bend[i] = 0.05 * ((k * 7) % 13 - 6);
    s.v[i] = speed * 0.1 * ((k * 5) % 11 - 5);
    s.tau[i] = speed * 4.0 * ((k * 3) % 7 - 3);
  }
  for (const Link& link : m.links())
    for (int k = 0; link.joint.type == JointType::floating && k < 6; ++k) s.tau[static_cast<std::size_t>(link.v_index + k)] = 0;
  integrate(m, m.neutral(), bend, 1.0, s.q);
  return s;
}

PlainTree plain(const Mechanism& m, const State& s) {
  PlainTree tree;
  tree.q = s.q;
  tree.v = s.v;
  tree.tau = s.tau;
  tree.gravity = gravity.z;
  struct Place {
    int link;
    Vec3 p;
  };
  std::vector<Place> places;
  std::vector<Inertia> inertias;
  for (const Link& link : m.links()) {
    const Joint& j = link.joint;
    if (j.X_PJ.R != Mat3::identity()) throw std::runtime_error("peers support only joint frames parallel to the link frames");
    const Place parent = link.parent < 0 ? Place{-1, {}} : places[static_cast<std::size_t>(link.parent)];
    const Vec3 p = parent.p + j.X_PJ.p;
    if (j.type == JointType::fixed && parent.link >= 0) {
      places.push_back({parent.link, p});
      inertias[static_cast<std::size_t>(parent.link)] += link.inertia.in_parent({Mat3::identity(), p});
      continue;
    }
    if (j.type != JointType::floating && j.type != JointType::revolute)
      throw std::runtime_error("peers support only revolute and floating joints");
    places.push_back({static_cast<int>(tree.links.size()), {}});
    inertias.push_back(link.inertia);
    tree.links.push_back(
        {.parent = parent.link, .floating = j.type == JointType::floating, .axis = {j.axis.x, j.axis.y, j.axis.z}, .p = {p.x, p.y, p.z}});
  }
  for (std::size_t i = 0; i < inertias.size(); ++i) {
    const Vec3 c = inertias[i].centre();
    const Sym3 I = inertias[i].about_centre();
    if (std::fabs(I.xy) + std::fabs(I.xz) + std::fabs(I.yz) > 1e-12)
      throw std::runtime_error("peers support only principal axes of inertia along the link's axes");
    PlainLink& l = tree.links[i];
    l.mass = inertias[i].mass;
    for (int k = 0; k < 3; ++k) l.centre[k] = c[k];
    l.inertia[0] = I.xx;
    l.inertia[1] = I.yy;
    l.inertia[2] = I.zz;
  }
  return tree;
}

std::vector<double> of_joints(const Mechanism& m, const std::vector<double>& x) {
  std::vector<double> out;
  for (const Link& link : m.links())
    if (link.joint.type == JointType::revolute) out.push_back(x[static_cast<std::size_t>(link.v_index)]);
  return out;
}

}  // namespace ugoki::benchmarks
