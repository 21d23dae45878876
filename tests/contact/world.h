#pragma once
// Bodies, and a world that contains them, for the tests of collision force.

#include <algorithm>
#include <string>
#include <vector>

#include "ugoki/collision/scene.h"
#include "ugoki/contact/stepper.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::contact {

inline MechanismPtr body(const std::string& name, const Shape& shape, double density) {
  MechanismSpec spec;
  spec.name = name;
  LinkSpec l;
  l.name = name;
  l.joint.type = JointType::floating;
  l.inertia = solid_inertia(shape, density);
  l.shapes.push_back(shape);
  spec.links.push_back(l);
  return Mechanism::make(std::move(spec)).value();
}

/// A blade of 1.2 m length and thickness `thick` [m] on a hinge at the origin.
inline MechanismPtr sword(double thick) {
  MechanismSpec spec;
  spec.name = "sword";
  LinkSpec l;
  l.name = "blade";
  l.joint.type = JointType::revolute;
  l.joint.axis = {0, 0, 1};
  l.shapes.push_back(Shape::box({0.6, thick / 2, 0.02}, {Mat3::identity(), {0.7, 0, 0}}));
  l.inertia = solid_inertia(l.shapes[0], 7800);
  spec.links.push_back(l);
  return Mechanism::make(std::move(spec)).value();
}

inline void put(State& s, const Vec3& p) {
  s.q[0] = p.x;
  s.q[1] = p.y;
  s.q[2] = p.z;
}

struct World {
  collision::Scene scene;
  collision::Workspace workspace;
  Stepper stepper;
  std::vector<State> states;
  std::vector<std::vector<Pose>> poses;
  std::vector<std::span<const Pose>> spans;
  std::vector<collision::ContactPoint> contacts;
  std::vector<StepSystem> systems;

  World(const std::vector<MechanismPtr>& mechanisms, const collision::Ground& ground, const StepperOptions& options)
      : scene(mechanisms, ground), workspace(scene), stepper(mechanisms, options) {
    for (const MechanismPtr& m : mechanisms) {
      states.emplace_back(*m);
      poses.emplace_back(static_cast<std::size_t>(m->link_count()));
    }
    for (auto& p : poses) spans.emplace_back(p);
    for (State& s : states) systems.push_back({s.q, s.v, s.tau, s.external, {}, {}});
  }
  void find() {
    for (std::size_t i = 0; i < states.size(); ++i) calc_poses(stepper.mechanism(static_cast<int>(i)), states[i].q, poses[i]);
    collision::find_contacts(scene, spans, 0.02, workspace, contacts);
  }
  StepReport step(double dt) {
    find();
    return stepper.step(systems, contacts, dt);
  }
  double lowest() {
    double low = 1e9;
    for (const collision::ContactPoint& c : contacts) low = std::min(low, c.distance);
    return low;
  }
};

}  // namespace ugoki::contact
