#include "contents.h"

#include <cstdio>
#include <cstdlib>

#include "ugoki/content/generate.h"
#include "ugoki/geometry/prepare.h"
#include "ugoki/samples/samples.h"

namespace ugoki::golden {
namespace {

template <class T>
T checked(Result<T> result) {
  if (!result) {
    std::fprintf(stderr, "%s\n", result.error().text().c_str());
    std::abort();
  }
  return std::move(*result);
}

GoldenContent pack(const std::string& name, const content::Scenario& scenario, const content::Resources& resources) {
  return {name, checked(content::generate(scenario, resources))};
}

content::Scenario empty_scenario(const std::string& name) {
  content::Scenario s;
  s.name = name;
  s.duration = 20;
  return s;
}

content::ScenarioCharacter passive(const std::string& id, const std::string& mechanism, const Vec3& at) {
  content::ScenarioCharacter c;
  c.id = c.name = id;
  c.mechanism = mechanism;
  c.place = {at.x, at.y, at.z, 0};
  c.control.mode = content::ControlMode::passive;
  return c;
}

LinkSpec link(const std::string& name, const std::string& parent, JointType type, const Pose& X_PJ, const Shape& shape) {
  LinkSpec l;
  l.name = name;
  l.parent = parent;
  l.joint.type = type;
  l.joint.axis = {0, 1, 0};
  l.joint.X_PJ = X_PJ;
  l.inertia = solid_inertia(shape, 800);
  l.shapes.push_back(shape);
  return l;
}

Pose at(const Vec3& p, double turn = 0) { return {to_matrix(axis_angle({0, 1, 0}, turn)), p}; }

MechanismPtr body(const std::string& name, const Shape& shape) {
  MechanismSpec spec;
  spec.name = name;
  spec.links = {link(name, "", JointType::floating, {}, shape)};
  return checked(Mechanism::make(std::move(spec)));
}

GoldenContent make_walk(const samples::Sample& sample) {
  content::Scenario s = checked(content::read_scenario(sample.document, "sample"));
  s.name = "walk";
  std::erase_if(s.characters, [](const content::ScenarioCharacter& c) { return c.id != "human"; });
  s.events.clear();
  content::ScenarioEvent push;
  push.id = "push";
  push.time = 1.5;
  push.character = "human";
  push.link = "chest";
  push.force = {0, 60, 0};
  s.events = {push};
  return pack("walk", s, sample.resources);
}

GoldenContent make_heap() {
  std::vector<Vec3> corners;
  for (const double x : {-0.1, 0.12})
    for (const double y : {-0.08, 0.1})
      for (const double z : {-0.15, 0.05, 0.11}) corners.push_back({x + 0.2 * z, y - 0.1 * z * z, z});
  const std::vector<std::pair<std::string, Shape>> shapes = {{"ball", Shape::sphere(0.1)},
                                                             {"box", Shape::box({0.12, 0.08, 0.1})},
                                                             {"capsule", Shape::capsule(0.06, {0, 0, -0.1}, {0, 0, 0.1})},
                                                             {"cylinder", Shape::cylinder(0.09, 0.08)},
                                                             {"ellipsoid", Shape::ellipsoid({0.12, 0.07, 0.09})},
                                                             {"hull", Shape::mesh(geometry::make_hull_geometry(corners, "hull").value())}};
  content::Scenario s = empty_scenario("heap");
  content::Resources resources;
  for (const auto& [name, shape] : shapes) resources.mechanisms[name] = body(name, shape);
  for (int k = 0; k < 48; ++k) {
    const std::string& name = shapes[static_cast<std::size_t>(k) % shapes.size()].first;
    const double side = 0.03 * (k % 5 - 2), across = 0.04 * (k % 3 - 1);
    s.characters.push_back(passive(name + std::to_string(k), name, {side, across, 0.2 + 0.26 * k}));
  }
  return pack("heap", s, resources);
}

/// A trunk on four legs. Each leg is a parallelogram, closed by a loop, with a foot on its lower bar.
GoldenContent make_closed_robot() {
  MechanismSpec spec;
  spec.name = "closed-robot";
  spec.links = {link("trunk", "", JointType::floating, {}, Shape::box({0.3, 0.2, 0.06}))};
  int number = 0;
  for (const double x : {0.2, -0.2})
    for (const double y : {0.25, -0.25}) {
      const std::string i = std::to_string(number++);
      const Shape bar = Shape::capsule(0.02, {0, 0, 0}, {0, 0, -0.3});
      spec.links.push_back(link("front" + i, "trunk", JointType::revolute, at({x + 0.05, y, 0}, 0.5), bar));
      spec.links.push_back(link("rear" + i, "trunk", JointType::revolute, at({x - 0.05, y, 0}, 0.5), bar));
      spec.links.push_back(
          link("shin" + i, "front" + i, JointType::revolute, at({0, 0, -0.3}, -0.5), Shape::capsule(0.03, {0, 0, 0}, {0, 0, -0.25})));
      for (std::size_t k = spec.links.size() - 3; k < spec.links.size(); ++k) spec.links[k].joint.dofs[0].damping = 0.5;
      LoopSpec pin;
      pin.name = "pin" + i;
      pin.type = LoopType::revolute;
      pin.link_a = "shin" + i;
      pin.link_b = "rear" + i;
      pin.X_AJ.p = {-0.1, 0, 0};
      pin.X_BJ = at({0, 0, -0.3}, -0.5);
      pin.axis = {0, 1, 0};
      spec.loops.push_back(pin);
    }
  content::Scenario s = empty_scenario("closed-robot");
  content::Resources resources;
  resources.mechanisms["robot"] = checked(Mechanism::make(std::move(spec)));
  s.characters = {passive("robot", "robot", {0, 0, 0.8})};
  content::ScenarioEvent push;
  push.id = "push";
  push.time = 2;
  push.duration = 0.1;
  push.character = "robot";
  push.link = "trunk";
  push.force = {100, 300, 400};
  s.events = {push};
  return pack("closed-robot", s, resources);
}

GoldenContent make_chain() {
  MechanismSpec spec;
  spec.name = "chain";
  const Shape bar = Shape::capsule(0.03, {0, 0, 0}, {0.15, 0, 0});
  for (int k = 0; k < 30; ++k) {
    const std::string parent = k == 0 ? "" : "link" + std::to_string(k - 1);
    const Pose X = k == 0 ? at({}, -1.2) : at({0.15, 0, 0}, k % 2 == 0 ? 0.3 : -0.28);
    spec.links.push_back(link("link" + std::to_string(k), parent, k == 0 ? JointType::floating : JointType::spherical, X, bar));
  }
  content::Scenario s = empty_scenario("chain");
  content::Resources resources;
  resources.mechanisms["chain"] = checked(Mechanism::make(std::move(spec)));
  s.characters = {passive("chain", "chain", {0, 0, 0.3})};
  return pack("chain", s, resources);
}

}  // namespace

std::vector<GoldenContent> make_contents() {
  const samples::Sample sample = samples::make_sample();
  return {pack("sample", checked(content::read_scenario(sample.document, "sample")), sample.resources), make_walk(sample), make_heap(),
          make_closed_robot(), make_chain()};
}

}  // namespace ugoki::golden
