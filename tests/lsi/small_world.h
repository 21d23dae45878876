#pragma once
// A small world for tests: a two-legged character that sways while it stands, and a ball.

#include <gtest/gtest.h>

#include <memory>

#include "ugoki/circuit/interpreter.h"
#include "ugoki/lsi/execution_circuit.h"
#include "ugoki/lsi/standard_library.h"
#include "ugoki/lsi/world.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::lsi {

inline MechanismPtr make_checked(MechanismSpec spec) {
  auto made = Mechanism::make(std::move(spec));
  EXPECT_TRUE(made) << (made ? "" : made.error().text());
  return *made;
}

/// A trunk on two straight legs with long feet: mass 40 kg, height of the hips 0.9 m.
inline MechanismPtr make_character() {
  MechanismSpec spec;
  spec.name = "character";
  LinkSpec trunk;
  trunk.name = "trunk";
  trunk.label = "chest";
  trunk.joint.type = JointType::floating;
  trunk.shapes = {Shape::box({0.1, 0.15, 0.25}, Pose{Mat3::identity(), {0, 0, 0.3}})};
  trunk.inertia = solid_inertia(trunk.shapes[0], 20 / volume(trunk.shapes[0]));
  spec.links.push_back(trunk);
  for (const double side : {1.0, -1.0}) {
    const std::string name = side > 0 ? "left" : "right";
    LinkSpec leg;
    leg.name = "leg " + name;
    leg.parent = "trunk";
    leg.joint.type = JointType::spherical;
    leg.joint.X_PJ.p = {0, 0.1 * side, 0};
    leg.shapes = {Shape::capsule(0.05, {0, 0, -0.1}, {0, 0, -0.75})};
    leg.inertia = solid_inertia(leg.shapes[0], 8 / volume(leg.shapes[0]));
    spec.links.push_back(leg);
    LinkSpec foot;
    foot.name = "foot " + name;
    foot.label = "foot " + name;
    foot.parent = leg.name;
    foot.joint.type = JointType::revolute;
    foot.joint.axis = {0, 1, 0};
    foot.joint.X_PJ.p = {0, 0, -0.85};
    foot.shapes = {Shape::box({0.13, 0.05, 0.025}, Pose{Mat3::identity(), {0.05, 0, -0.025}})};
    foot.inertia = solid_inertia(foot.shapes[0], 2 / volume(foot.shapes[0]));
    spec.links.push_back(foot);
  }
  return make_checked(std::move(spec));
}

inline MechanismPtr make_ball() {
  MechanismSpec spec;
  spec.name = "ball";
  LinkSpec ball;
  ball.name = "ball";
  ball.joint.type = JointType::floating;
  ball.shapes = {Shape::sphere(0.11)};
  ball.inertia = solid_inertia(ball.shapes[0], 0.45 / volume(ball.shapes[0]));
  spec.links = {ball};
  return make_checked(std::move(spec));
}

/// A motion of 4 s: the standing character leans forwards by `degrees` and back, twice; its feet do not move.
inline MotionPtr make_sway(const Mechanism& m, double degrees) {
  auto motion = std::make_shared<Motion>();
  motion->name = "sway";
  motion->mechanism = m.name();
  motion->rate = 100;
  motion->frames = 401;
  motion->nq = m.nq();
  for (int f = 0; f < motion->frames; ++f) {
    std::vector<double> q = m.neutral();
    q[2] = 0.9;
    const double angle = degrees * pi / 180 * 0.5 * (1 - cos(2 * pi * f / 200.0));
    const Quat lean = axis_angle({0, 1, 0}, angle);
    const auto put = [&](std::size_t at, const Quat& r) {
      q[at] = r.w;
      q[at + 1] = r.x;
      q[at + 2] = r.y;
      q[at + 3] = r.z;
    };
    put(3, lean);
    for (const char* leg : {"leg left", "leg right"}) put(static_cast<std::size_t>(m.link(m.find_link(leg)).q_index), lean.conjugate());
    motion->q.insert(motion->q.end(), q.begin(), q.end());
  }
  return motion;
}

struct SmallWorld {
  MechanismPtr character = make_character(), ball = make_ball();
  std::unique_ptr<World> world;
  circuit::Circuit circuit;

  explicit SmallWorld(std::vector<ScheduledEvent> events = {}) {
    std::vector<CharacterSpec> specs(2);
    specs[0].id = "character";
    specs[0].mechanism = character;
    TrackClip sway;
    sway.motion = make_sway(*character, 4);
    sway.clip.length = 4;
    specs[0].track = {sway};
    specs[1].id = "ball.1";
    specs[1].mechanism = ball;
    specs[1].q0 = ball->neutral();
    specs[1].q0[0] = 3;
    specs[1].q0[2] = 0.11;
    world = std::make_unique<World>(std::move(specs), std::move(events), Vec3{0, 0, -9.81}, collision::Ground{});
    circuit = make_execution_circuit({{"character", true, 1, 1, 0.5}, {"ball.1", false, 1, 1, 0.5}}, 0.002);
  }
  [[nodiscard]] Result<circuit::Interpreter> build() const {
    return circuit::Interpreter::build(circuit, standard_library(), world.get(), {.dt = 0.002, .check_finite = true});
  }
};

inline const double* numbers(const circuit::Interpreter& i, const char* output) {
  const auto view = i.find_circuit_output(output);
  EXPECT_TRUE(view) << output;
  return view->numbers().data();
}

inline void put_event(circuit::Interpreter& i, const EventRecord& record) {
  const auto live = i.find_circuit_input("live");
  ASSERT_FALSE(live.empty());
  record_room<EventRecord>(live.data())[0] = record;
  set_count(live.data(), 1);
}
inline void clear_events(circuit::Interpreter& i) { set_count(i.find_circuit_input("live").data(), 0); }

}  // namespace ugoki::lsi
