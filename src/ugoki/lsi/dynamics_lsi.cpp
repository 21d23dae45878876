// General-purpose dynamics: one step of all characters with contacts, friction, joint limits, drive torques, pushes and pulls.

#include <algorithm>

#include "ugoki/contact/contact_events.h"
#include "ugoki/contact/scene_step.h"
#include "ugoki/lsi/declare.h"
#include "ugoki/lsi/grips.h"
#include "ugoki/lsi/pull.h"
#include "ugoki/lsi/touch.h"

namespace ugoki::lsi {
namespace {

using contact::Stepper;

enum Input : std::size_t { in_state, in_contacts, in_events, in_torque };
enum Output : std::size_t { out_next, out_contacts, out_touches, out_not_converged, out_substeps, out_failures, out_applied, out_grips };

struct Dynamics {
  Dynamics(const World& world_, const contact::StepperOptions& options)
      : world(&world_), scene(world_.mechanisms(), world_.ground(), options), stepper(scene.stepper()) {
    scene.set_executor(world_.executor());
    world->kinematics().claim(this);
  }
  ~Dynamics() { world->kinematics().release(this); }
  Dynamics(const Dynamics&) = delete;
  Dynamics& operator=(const Dynamics&) = delete;

  const World* world;
  contact::SceneStep scene;
  Stepper& stepper;
  std::vector<dynamics::Workspace> scratch;    // [characters] working memory for pulls
  std::vector<std::vector<Vec6>> external;     // [characters][links] wrenches of pushes and pulls, world
  std::vector<unsigned char> is_pushed;        // [characters] 1: `external` is not zero in this tick
  std::vector<std::vector<double>> no_torque;  // [characters][nv] zeros
  std::vector<int> torque_wire;                // [characters] index in Call::in; -1: no wire
  std::vector<collision::ContactPoint> contacts;
  std::vector<contact::StepSystem> systems;
  contact::ContactEvents touches;
  Grips grips;
  std::vector<contact::Grip> step_grips;      // grips of the present tick
  bool constant_drives = false;               // parameter `constant drives`
  std::vector<std::vector<double>> applied;   // [characters][nv] mean drive forces of the tick
  std::vector<Stepper::Warm> warm;            // impulses before the tick, for its repetition with constant drives
  std::vector<Stepper::LoopMemory> memories;  // [characters] loop memories before the tick
};

std::size_t warm_capacity(const World& world) {
  std::size_t n = 2 * std::size_t{world.contact_capacity()};  // room for the contacts of the input, and for as many added by the guard
  for (const Character& c : world.characters()) n += 3 * static_cast<std::size_t>(c.mechanism->nv());
  return n;
}

/// Returns the offset [bytes] of the touches in the saved state. The state consists of the stepper's warm start (a count, then records),
/// the current touches (a count, then records), and the memory of each character's loops.
std::size_t touches_at(const World& world) { return sizeof(std::uint64_t) + warm_capacity(world) * sizeof(Stepper::Warm); }
// Maximum number of current touches that are saved, and maximum number of touch events per tick. Further touches are not saved; further
// events are replaced by one event that counts them.
constexpr std::size_t touch_capacity = 256, touch_events = 64;

/// Returns the offset [bytes] of the characters' loop memories in the saved state.
std::size_t loops_at(const World& world) { return touches_at(world) + sizeof(std::uint64_t) + touch_capacity * sizeof(contact::Touch); }

/// Returns the offset [bytes] of the grips in the saved state.
std::size_t grips_at(const World& world) { return loops_at(world) + world.characters().size() * sizeof(Stepper::LoopMemory); }

void add_wrench(Dynamics& self, const EventRecord& e, const Vec3& p, const Vec3& force) {
  self.external[e.character][static_cast<std::size_t>(e.link)] += Vec6{cross(p, force), force};
  self.is_pushed[e.character] = 1;
}

void apply_event(Dynamics& self, const EventRecord& e, const double* state, double dt) {
  if (e.kind != EventKind::push && e.kind != EventKind::grab) return;
  const Character& c = self.world->characters()[e.character];
  const Mechanism& m = *c.mechanism;
  dynamics::Workspace& ws = self.scratch[e.character];
  if (e.kind == EventKind::push) {
    dynamics::update_kinematics(m, q_of(c, state), v_of(c, state), ws);
    const Pose& X_WB = ws.X_WB[static_cast<std::size_t>(e.link)];
    add_wrench(self, e, X_WB * m.link(e.link).inertia.centre(), (e.flags & push_body_axes) != 0 ? X_WB.R * e.a : e.a);
  } else {
    const Vec3 force = calc_pull(m, ws, q_of(c, state), v_of(c, state), e.link, e.a, e.b, dt);
    add_wrench(self, e, ws.X_WB[static_cast<std::size_t>(e.link)] * e.a, force);
  }
}

std::int32_t explain(const Call* call, const Dynamics& self, const contact::StepReport& report) {
  const Character& c = self.world->characters()[static_cast<std::size_t>(report.system)];
  const Link& link = c.mechanism->link(c.mechanism->link_of_dof(report.dof));
  const std::string joint = "the joint of '" + link.name + "' of '" + c.id + "'";
  return circuit::stop(call, report.status == contact::StepStatus::singular
                                 ? "The inertia at " + joint + " is not positive, so its acceleration is undefined."
                                 : "The velocity at " + joint + " has diverged.");
}

/// Sets the drive forces that acted in the step: those of servos at the velocities after the step.
void calc_applied(Dynamics& self) {
  for (std::size_t s = 0; s < self.systems.size(); ++s) {
    const contact::StepSystem& system = self.systems[s];
    for (std::size_t i = 0; i < self.applied[s].size(); ++i) {
      self.applied[s][i] = system.tau[i];
      if (!system.servo_gain.empty()) self.applied[s][i] += system.servo_gain[i] * (system.servo_velocity[i] - system.v[i]);
    }
  }
}

std::int32_t step(const Call* call) {
  auto& self = object_of<Dynamics>(call);
  const double* state = circuit::input(call, in_state);
  double* next = circuit::output(call, out_next);
  std::memcpy(next, state, self.world->state_size() * sizeof(double));
  for (std::size_t i = 0; i < self.external.size(); ++i) {
    if (self.is_pushed[i] != 0) std::ranges::fill(self.external[i], Vec6{});
    self.is_pushed[i] = 0;
  }
  for (const EventRecord& e : records<EventRecord>(call->in[in_events])) {
    apply_event(self, e, state, call->tick->dt);
    self.grips.apply(*self.world, self.scratch, e, state);
  }
  self.grips.approach(call->tick->dt);
  self.step_grips.clear();
  for (const HeldGrip& h : self.grips.held()) self.step_grips.push_back(h.grip);
  self.stepper.set_grips(self.step_grips);
  const auto take_contacts = [&] {
    self.contacts.clear();
    for (const ContactRecord& c : records<ContactRecord>(call->in[in_contacts])) self.contacts.push_back(c.point);
  };
  take_contacts();
  const std::span<const dynamics::KnownKinematics> known = self.world->kinematics().at(call->tick->index);
  for (const Character& c : self.world->characters()) {
    const auto i = static_cast<std::size_t>(c.index);
    const int wire = self.torque_wire[i];
    const std::size_t nv = self.no_torque[i].size();
    const double* drive = wire < 0 ? self.no_torque[i].data() : circuit::input(call, static_cast<std::size_t>(wire));
    contact::StepSystem& system = self.systems[i] = {q_of(c, next), v_of(c, next), {drive, nv}, {}, {}, {}, &known[i]};
    if (self.is_pushed[i] != 0) system.external = self.external[i];
    if (wire >= 0 && call->in_count[wire] == 3 * nv) {
      system.servo_gain = {drive + nv, nv};
      system.servo_velocity = {drive + 2 * nv, nv};
    }
  }
  if (self.constant_drives) {
    self.warm.assign(self.stepper.warm().begin(), self.stepper.warm().end());
    for (std::size_t i = 0; i < self.memories.size(); ++i) self.memories[i] = self.stepper.loop_memory(static_cast<int>(i));
  }
  contact::StepReport report = self.scene.step(self.systems, self.contacts, call->tick->dt);
  if (report.status == contact::StepStatus::ok) calc_applied(self);
  if (report.status == contact::StepStatus::ok && self.constant_drives) {
    // Again, from the state before the tick, with the servos' forces of the first solution as constant forces.
    std::memcpy(next, state, self.world->state_size() * sizeof(double));
    self.stepper.set_warm(self.warm);
    for (std::size_t i = 0; i < self.memories.size(); ++i) self.stepper.set_loop_memory(static_cast<int>(i), self.memories[i]);
    take_contacts();
    for (std::size_t i = 0; i < self.systems.size(); ++i) {
      self.systems[i].tau = self.applied[i];
      self.systems[i].servo_gain = self.systems[i].servo_velocity = {};
    }
    report = self.scene.step(self.systems, self.contacts, call->tick->dt);
  }
  const std::span<const Vec3> forces = self.scene.forces();
  if (report.status != contact::StepStatus::ok) return explain(call, self, report);
  for (const Character& c : self.world->characters())
    self.world->kinematics().leave(&self, call->tick->index, c.index, self.scene.end()[static_cast<std::size_t>(c.index)]);
  self.grips.take(self.stepper.grip_forces(), call->tick->dt);
  set_count(call->out[out_grips], self.grips.report(*self.world, self.scratch, next, record_room<EventRecord>(call->out[out_grips])));
  auto* out = record_room<ContactRecord>(call->out[out_contacts]);
  const std::size_t count = std::min<std::size_t>(self.contacts.size(), call->out_count[out_contacts]);
  for (std::size_t i = 0; i < count; ++i) out[i] = {self.contacts[i], forces[i], 0};
  set_count(call->out[out_contacts], count);
  std::size_t events = 0;
  auto* touches = record_room<EventRecord>(call->out[out_touches]);
  const auto& changes = self.touches.update(self.contacts, forces, call->tick->dt);
  const std::size_t room = call->out_count[out_touches], kept = changes.size() <= room ? changes.size() : room - 1;
  for (; events < kept; ++events) touches[events] = record_of(changes[events]);
  if (kept < changes.size()) touches[events++] = omitted_record(changes.size() - kept);
  set_count(call->out[out_touches], events);
  circuit::output(call, out_not_converged)[0] = report.not_converged;
  circuit::output(call, out_substeps)[0] = report.substeps;
  circuit::output(call, out_failures)[0] = report.failures();
  double* applied = circuit::output(call, out_applied);
  for (const std::vector<double>& forces_of_one : self.applied) applied = std::ranges::copy(forces_of_one, applied).out;
  return 0;
}

void configure(Setup& s) {
  const World* world = world_of(s);
  if (!world) return;
  s.set_out(out_next, world->state_count());
  s.set_out(out_contacts, world->contact_capacity());
  s.set_out(out_touches, touch_events);
  std::size_t dofs = 0;
  for (const Character& c : world->characters()) dofs += static_cast<std::size_t>(c.mechanism->nv());
  s.set_out(out_applied, World::payload_count(dofs));
  s.set_out(out_grips, Grips::capacity);
  s.set_state(grips_at(*world) + sizeof(std::uint64_t) + Grips::capacity * sizeof(HeldGrip));
  std::vector<int> wires(world->characters().size(), 0);
  for (std::size_t k = 0; k < s.wires(in_torque); ++k) {
    const circuit::Shape shape = s.in(in_torque, k);
    if (shape.count == 0) continue;
    const Character* c = shape.subject >= 0 ? &world->characters()[static_cast<std::size_t>(shape.subject)] : nullptr;
    const std::uint32_t nv = c ? static_cast<std::uint32_t>(c->mechanism->nv()) : 0;
    if (!c || (shape.count != nv && shape.count != 3 * nv)) {
      s.fail(ErrorCode::structure, "Wire " + std::to_string(k) + " into '" + s.id() + ".torque' is not the torque of one character.",
             "Wire the torque of a motion control LSI.");
    } else if (++wires[static_cast<std::size_t>(c->index)] > 1) {
      s.fail(ErrorCode::structure, "Two wires into '" + s.id() + ".torque' belong to the character '" + c->id + "'.",
             "Remove one wire, or add the torques with an LSI first.");
    }
  }
}

void* make(Setup& s) {
  const World* world = world_of(s);
  contact::StepperOptions options;
  options.gravity = world->gravity();
  options.iterations = static_cast<int>(s.number("iterations"));
  options.tolerance = s.number("tolerance");
  auto* self = new Dynamics(*world, options);
  for (const Character& c : world->characters()) {
    self->scratch.emplace_back(*c.mechanism);
    self->external.emplace_back(static_cast<std::size_t>(c.mechanism->link_count()));
    self->is_pushed.push_back(0);
    self->no_torque.emplace_back(static_cast<std::size_t>(c.mechanism->nv()));
    self->torque_wire.push_back(-1);
    self->applied.emplace_back(static_cast<std::size_t>(c.mechanism->nv()));
  }
  self->step_grips.reserve(Grips::capacity);
  self->constant_drives = s.number("constant drives") != 0;
  self->memories.resize(world->characters().size());
  self->warm.reserve(warm_capacity(*world));
  for (std::size_t k = 0; k < s.wires(in_torque); ++k)
    self->torque_wire[static_cast<std::size_t>(s.in(in_torque, k).subject)] = static_cast<int>(in_torque + k);
  self->contacts.reserve(2 * std::size_t{world->contact_capacity()});
  self->systems.resize(world->characters().size());
  return self;
}

void store(const Call* call) {
  const auto& self = object_of<Dynamics>(call);
  const std::span<const Stepper::Warm> warm = self.stepper.warm();
  const std::size_t count = std::min(warm.size(), warm_capacity(*self.world));
  set_count(call->state, count);
  if (count) std::memcpy(record_room<Stepper::Warm>(call->state), warm.data(), count * sizeof(Stepper::Warm));
  auto* const at = static_cast<std::byte*>(call->state) + touches_at(*self.world);
  const std::span<const contact::Touch> touches = self.touches.touches();
  const std::size_t current = std::min(touches.size(), touch_capacity);
  set_count(at, current);
  if (current) std::memcpy(record_room<contact::Touch>(at), touches.data(), current * sizeof(contact::Touch));
  auto* const loops = static_cast<std::byte*>(call->state) + loops_at(*self.world);
  for (int i = 0; i < self.stepper.system_count(); ++i) {
    const Stepper::LoopMemory memory = self.stepper.loop_memory(i);
    std::memcpy(loops + static_cast<std::size_t>(i) * sizeof memory, &memory, sizeof memory);
  }
  auto* const grips = static_cast<std::byte*>(call->state) + grips_at(*self.world);
  const std::span<const HeldGrip> held = self.grips.held();
  set_count(grips, held.size());
  if (!held.empty()) std::memcpy(record_room<HeldGrip>(grips), held.data(), held.size_bytes());
}

void recall(const Call* call) {
  auto& self = object_of<Dynamics>(call);
  self.stepper.set_warm(records<Stepper::Warm>(call->state));
  self.touches.set_touches(records<contact::Touch>(static_cast<const std::byte*>(call->state) + touches_at(*self.world)));
  const auto* const loops = static_cast<const std::byte*>(call->state) + loops_at(*self.world);
  for (int i = 0; i < self.stepper.system_count(); ++i) {
    Stepper::LoopMemory memory;
    std::memcpy(&memory, loops + static_cast<std::size_t>(i) * sizeof memory, sizeof memory);
    self.stepper.set_loop_memory(i, memory);
  }
  self.grips.set_held(records<HeldGrip>(static_cast<const std::byte*>(call->state) + grips_at(*self.world)));
}

}  // namespace

void add_dynamics(circuit::Library& library) {
  const contact::StepperOptions usual;
  circuit::LsiClass c;
  c.name = "dynamics";
  c.version = 2;
  c.doc =
      "General-purpose dynamics: advances every character by one step under torques, gravity, contact, friction, joint limits, pushes and "
      "pulls. If bodies would penetrate each other by more than 0.4 mm at the end of a step, the step is solved again with additional "
      "contacts. In groups of touching bodies with at most 256 contacts and limits, their conditions are solved to rounding; with more, to "
      "0.1 mm "
      "per step.";
  c.inputs = {input_pin("state", PinTypeId::state, "", "Positions and velocities now."),
              input_pin("contacts", PinTypeId::contacts, "", "Contact points now."),
              input_pin("events", PinTypeId::event, "", "Pushes and pulls."),
              input_pin("torque", PinTypeId::joint_values, "N m, N",
                        "Forces on the degrees of freedom of a character, alone or with servo gains and velocities; one wire for each "
                        "character. Characters "
                        "without a wire move passively.")};
  c.inputs[in_events].required = false;
  c.inputs[in_torque].required = false;
  c.inputs[in_torque].multiple = true;
  c.outputs = {
      output_pin("next", PinTypeId::state, "", "Positions and velocities one step later."),
      output_pin("contacts", PinTypeId::contacts, "", "The contact points with their forces."),
      output_pin(
          "touches", PinTypeId::event, "",
          "Touches of links that began or ended in this tick, with their impulses; at most 64, the last one counts the further ones."),
      output_pin("not converged", PinTypeId::scalar, "",
                 "Number of groups of touching bodies whose contacts were not solved to the tolerance in this tick."),
      output_pin("substeps", PinTypeId::scalar, "",
                 "Number of substeps into which the tick was split because bodies would have passed through each other; 1: none."),
      output_pin("failures", PinTypeId::scalar, "",
                 "Number of failed stages of the tick: motions without bias forces, unfinished impacts, open loops, stops, overlaps that "
                 "are left (docs/design/contact.md)."),
      output_pin(
          "applied", PinTypeId::joint_values, "N m, N",
          "Drive forces that acted in this tick on the degrees of freedom of all characters, one character after the other: the forces "
          "of the inputs, and those of their servos."),
      output_pin("grips", PinTypeId::event, "", "The grips that hold, with their forces (LSI `grip`).")};
  c.parameters = {
      number_parameter("iterations", usual.iterations, 1, 10000, "", "Maximum number of sweeps over the contacts."),
      number_parameter("tolerance", usual.tolerance, 1e-15, 1, "m/s", "Sweeps end when no velocity changes by more than this."),
      number_parameter("constant drives", 0, 0, 1, "",
                       "1: the forces of servos are constant during a tick, so that a run with the output `applied` as torque has the same "
                       "bits. Every tick is then computed twice.")};
  c.parameters[0].kind = c.parameters[2].kind = circuit::ParameterKind::integer;
  c.configure = configure;
  c.make = make;
  c.destroy = destroy<Dynamics>;
  c.init = [](const Call* call) -> std::int32_t {
    auto& self = object_of<Dynamics>(call);
    self.stepper.set_warm({});
    for (int i = 0; i < self.stepper.system_count(); ++i) self.stepper.set_loop_memory(i, {});
    self.touches.set_touches({});
    self.grips.set_held({});
    return 0;
  };
  c.step = step;
  c.store = store;
  c.recall = recall;
  library.add(std::move(c));
}

}  // namespace ugoki::lsi
