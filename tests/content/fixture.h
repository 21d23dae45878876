#pragma once
// Small content for the tests of content and project: a two-link walker with a floating root, its motions, and a ball.

#include <memory>
#include <string>

#include "ugoki/content/generate.h"
#include "ugoki/content/scenario.h"

namespace ugoki::content::testing {

inline MechanismPtr make_walker() {
  MechanismSpec spec;
  spec.name = "walker";
  LinkSpec root;
  root.name = "pelvis";
  root.label = "pelvis";
  root.joint.type = JointType::floating;
  root.inertia = Inertia::from_centre(10, {}, {0.1, 0.1, 0.1, 0, 0, 0});
  root.shapes.push_back(Shape::sphere(0.1));
  LinkSpec leg;
  leg.name = "leg";
  leg.label = "shank left";
  leg.parent = "pelvis";
  leg.joint.type = JointType::revolute;
  leg.joint.axis = {0, 1, 0};
  leg.inertia = Inertia::from_centre(2, {0, 0, -0.2}, {0.02, 0.02, 0.01, 0, 0, 0});
  leg.shapes.push_back(Shape::capsule(0.05, {0, 0, 0}, {0, 0, -0.4}));
  spec.links = {root, leg};
  return Mechanism::make(spec).value();
}

inline MechanismPtr make_ball() {
  MechanismSpec spec;
  spec.name = "ball";
  LinkSpec ball;
  ball.name = "ball";
  ball.joint.type = JointType::floating;
  ball.inertia = Inertia::from_centre(0.4, {}, {0.002, 0.002, 0.002, 0, 0, 0});
  ball.shapes.push_back(Shape::sphere(0.11));
  spec.links = {ball};
  return Mechanism::make(spec).value();
}

/// A walk that lasts `seconds`, covers `distance` metres along the heading and turns by `turn` rad. It starts at (3, 4) m, heading 0.5 rad.
inline Motion make_walk(const std::string& name, double seconds, double distance, double turn, bool cyclic) {
  Motion motion;
  motion.name = name;
  motion.mechanism = "walker";
  motion.rate = 100;
  motion.frames = static_cast<int>(seconds * motion.rate) + 1;
  motion.nq = 8;
  motion.cyclic = cyclic;
  Vec3 p = {3, 4, 0.9};
  double heading = 0.5;
  for (int i = 0; i < motion.frames; ++i) {
    const double s = static_cast<double>(i) / (motion.frames - 1);
    const Quat r = axis_angle({0, 0, 1}, heading);
    motion.q.insert(motion.q.end(), {p.x, p.y, p.z, r.w, r.x, r.y, r.z, 0.3 * sin(2 * pi * s)});
    p += rotate(r, {distance / (motion.frames - 1), 0, 0});
    heading += turn / (motion.frames - 1);
  }
  return motion;
}

inline Resources make_resources() {
  Resources r;
  r.mechanisms["m-walker"] = make_walker();
  r.mechanisms["m-ball"] = make_ball();
  r.motions["n-walk"] = std::make_shared<const Motion>(make_walk("walk", 2, 3, 0.4, false));
  r.motions["n-step"] = std::make_shared<const Motion>(make_walk("step", 1, 1.2, 0.2, true));
  return r;
}

inline Scenario make_scenario() {
  Scenario s;
  s.name = "park";
  s.duration = 8;
  ScenarioCharacter walker;
  walker.id = "human";
  walker.name = "Human";
  walker.mechanism = "m-walker";
  walker.place = {1, 2, 0, 90};
  walker.track = {
      {"k1", "n-walk", 0, 2, 0, 1, 0.3, false}, {"k2", "n-step", 2, 3.5, 0, 1, 0.3, true}, {"k3", "n-walk", 5, 1, 0.5, 1.5, 0.3, false}};
  ScenarioCharacter ball;
  ball.id = "ball";
  ball.name = "Ball";
  ball.mechanism = "m-ball";
  ball.place = {3, 0, 0.11, 0};
  ball.control.mode = ControlMode::passive;
  s.characters = {walker, ball};
  ScenarioEvent push;
  push.id = "e1";
  push.time = 3.4;
  push.character = "human";
  push.link = "shank left";
  push.force = {150, 0, 0};
  ScenarioEvent throw_ball;
  throw_ball.id = "e2";
  throw_ball.type = EventType::throw_;
  throw_ball.time = 5;
  throw_ball.character = "ball";
  throw_ball.from = {3, 0, 1.2};
  throw_ball.velocity = {-6, 0, 2};
  s.events = {push, throw_ball};
  s.camera.follow = "human";
  return s;
}

}  // namespace ugoki::content::testing
