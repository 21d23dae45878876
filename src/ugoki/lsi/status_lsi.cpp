// Status: keeps the state of the world from tick to tick.

#include "ugoki/lsi/declare.h"

namespace ugoki::lsi {
namespace {

/// Sets the position and velocity of the root to the values in the throw event, and all joint velocities to zero.
void throw_character(const Character& c, const EventRecord& e, double* state) {
  const Joint& root = c.mechanism->link(0).joint;
  if (root.type != JointType::floating) return;
  const std::span<double> q = q_of(c, state), v = v_of(c, state);
  for (double& x : v) x = 0;
  const Vec3 p = root.X_PJ.inverse() * e.a;
  const Vec3 velocity = transpose_times(root.X_PJ.R, e.b);
  const Vec3 spin = transpose_times(root.X_PJ.R * joint_pose(root, q.data()).R, e.c);
  for (int k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(k);
    q[i] = p[k];
    v[i] = spin[k];
    v[i + 3] = velocity[k];
  }
}

std::int32_t init(const Call* call) {
  const World& world = *static_cast<const World*>(call->object);
  double* state = circuit::output(call, 0);
  for (const Character& c : world.characters()) {
    std::ranges::copy(c.q0, q_of(c, state).begin());  // copies nothing if the character has no coordinates (fixed to the world)
    std::ranges::copy(c.v0, v_of(c, state).begin());
  }
  return 0;
}

std::int32_t advance(const Call* call) {
  const World& world = *static_cast<const World*>(call->object);
  double* state = circuit::output(call, 0);
  std::memcpy(state, call->in[0], world.state_size() * sizeof(double));
  for (const EventRecord& e : records<EventRecord>(call->in[1]))
    if (e.kind == EventKind::throwing) throw_character(world.characters()[e.character], e, state);
  return 0;
}

}  // namespace

void add_status(circuit::Library& library) {
  circuit::LsiClass c;
  c.name = "status";
  c.doc = "The status data: positions and velocities of all characters. They change together at the end of each tick.";
  c.inputs = {input_pin("next", PinTypeId::state, "", "Positions and velocities after this tick."),
              input_pin("events", PinTypeId::event, "", "Throws, which set the position and velocity of a character's root.")};
  for (circuit::InputPin& pin : c.inputs) pin.direct = false;
  c.inputs[1].required = false;
  c.outputs = {output_pin("state", PinTypeId::state, "", "Positions and velocities now.")};
  c.outputs[0].delayed = true;
  c.configure = [](Setup& s) {
    const World* world = world_of(s);
    if (!world) return;
    const std::uint32_t size = world->state_count();
    s.set_out(0, size);
    if (s.in(0).count != 0 && s.in(0).count != size)
      s.fail(ErrorCode::structure,
             "The wired state has " + std::to_string(s.in(0).count) + " numbers; states of this content have " + std::to_string(size) + ".",
             "Wire the output 'next' of a dynamics LSI.");
  };
  c.make = [](Setup& s) -> void* { return const_cast<World*>(world_of(s)); };  // the LSI does not write to the world
  c.init = init;
  c.advance = advance;
  library.add(std::move(c));
}

}  // namespace ugoki::lsi
