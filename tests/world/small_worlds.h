#pragma once
// A world for tests: a puppet with limbs on spherical joints, a four-bar linkage and a ball.

#include "../dynamics/benchmark_mechanisms.h"
#include "ugoki/world/world.h"

namespace ugoki::world {

inline LinkSpec part(const std::string& name, const std::string& parent, const Vec3& at, const Shape& shape) {
  LinkSpec l;
  l.name = name;
  l.parent = parent;
  l.joint.type = parent.empty() ? JointType::floating : JointType::spherical;
  l.joint.X_PJ.p = at;
  l.inertia = solid_inertia(shape, 1000);
  l.shapes.push_back(shape);
  return l;
}

inline MechanismPtr make_puppet() {
  MechanismSpec spec;
  spec.name = "puppet";
  spec.links.push_back(part("trunk", "", {}, Shape::box({0.1, 0.15, 0.25})));
  for (const double y : {0.2, -0.2})
    for (const double z : {0.2, -0.25}) {
      const std::string i = std::to_string(spec.links.size());
      spec.links.push_back(part("upper" + i, "trunk", {0, y, z}, Shape::capsule(0.05, {0, 0, -0.05}, {0, 0, -0.3})));
      spec.links.push_back(part("lower" + i, "upper" + i, {0, 0, -0.35}, Shape::capsule(0.04, {0, 0, -0.05}, {0, 0, -0.3})));
    }
  return Mechanism::make(std::move(spec)).value();
}

inline MechanismPtr make_ball() {
  MechanismSpec spec;
  spec.name = "ball";
  spec.links.push_back(part("ball", "", {}, Shape::sphere(0.1)));
  return Mechanism::make(std::move(spec)).value();
}

enum System { puppet, four_bar, ball };

inline World make_world() {
  WorldOptions options;
  options.self_collision = true;
  return World({make_puppet(), testing::four_bar({}, 1.0, 0).mechanism, make_ball()}, options);
}

/// Returns an initial state that differs for each k: the puppet above the ground, the ball above the puppet, the linkage in motion.
inline WorldState make_state(const World& world, int k) {
  WorldState s(world);
  s.q(puppet)[2] = 0.95 + 0.01 * k;
  s.v(puppet)[0] = 0.3 * k;
  s.v(puppet)[4] = 1;
  const testing::ClosedCase bars = testing::four_bar({}, 1.0, 0.5 + 0.1 * k);
  std::ranges::copy(bars.q, s.q(four_bar).begin());
  std::ranges::copy(bars.v, s.v(four_bar).begin());
  s.q(ball)[0] = 0.05;
  s.q(ball)[2] = 1.6;
  return s;
}

}  // namespace ugoki::world
