// Dynamics of one open or closed link system alone: an integrator of one's choice, loops that hold to rounding and can be opened and
// closed.

#include <algorithm>
#include <memory>

#include "ugoki/dynamics/closed_system.h"
#include "ugoki/dynamics/integrators.h"
#include "ugoki/lsi/declare.h"

namespace ugoki::lsi {
namespace {

using circuit::input;
using circuit::output;
using dynamics::ClosedLinks;
using dynamics::ClosedSystem;
using dynamics::IntegrationMethod;
using dynamics::IntegrationStatus;

enum Input : std::size_t { in_state, in_torque, in_closed };
enum Output : std::size_t { out_next, out_acceleration, out_forces, out_gap, out_energy };

constexpr std::pair<const char*, IntegrationMethod> methods[] = {{"Runge-Kutta 4", IntegrationMethod::runge_kutta_4},
                                                                 {"Dormand-Prince 5(4)", IntegrationMethod::dormand_prince_54},
                                                                 {"Gauss-Legendre 6", IntegrationMethod::gauss_legendre_6},
                                                                 {"Radau IIA 5", IntegrationMethod::radau_iia_5},
                                                                 {"semi-implicit Euler", IntegrationMethod::semi_implicit_euler}};

/// The system with some of its loops closed, and what steps it.
struct Way {
  Way(const Character& who, const dynamics::OpenSystemOptions& options, const dynamics::IntegratorOptions& integration,
      std::span<const int> opened)
      : system(who.mechanism, options), integrator(system, integration) {
    for (const int loop : opened)
      if (system.links().is_closed(loop)) system.open(loop);
    std::vector<double> q = who.q0, v(who.v0.size());
    if (system.project(0, q, v) != dynamics::Projection::failed) system.leave_out_redundant_rows(q);
    first = system.links().memory();
  }
  ClosedSystem system;
  dynamics::Integrator integrator;
  ClosedLinks::Memory first;
};

struct LinkDynamics {
  const Character* character;
  std::unique_ptr<Way> closed, opened;  // opened: null where there is no loop to open
};

std::int32_t explain(const Call* call, const LinkDynamics& self, const dynamics::IntegrationReport& report) {
  const std::string who = "'" + self.character->id + "'";
  const Mechanism& m = *self.character->mechanism;
  const std::string joint = report.freedom < 0 ? who : "the joint of '" + m.link(m.link_of_freedom(report.freedom)).name + "' of " + who;
  switch (report.status) {
    case IntegrationStatus::singular: return circuit::stop(call, "Nothing resists motion at " + joint + ": its inertia is not positive.");
    case IntegrationStatus::not_finite:
      return circuit::stop(call, "The motion at " + joint + " has blown up; the tick is too long for it.");
    case IntegrationStatus::projection_failed: return circuit::stop(call, "The loops of " + who + " cannot be closed from here.");
    default: return circuit::stop(call, "The step of " + who + " failed: " + std::string(name_of(report.status)) + ".");
  }
}

/// The acceleration at the beginning, and the forces in the loops that belong to it.
bool show_forces(const Call* call, Way& way, std::span<const double> q, std::span<const double> v) {
  if (way.system.calc_acceleration(call->tick->time, q, v, {output(call, out_acceleration), v.size()}) >= 0) return false;
  const std::span<const double> forces = way.system.links().multipliers();
  std::copy(forces.begin(), forces.end(), output(call, out_forces));
  return true;
}

std::int32_t step(const Call* call) {
  auto& self = object_of<LinkDynamics>(call);
  const Character& who = *self.character;
  Way& way = self.opened && !(*input(call, in_closed) > 0.5) ? *self.opened : *self.closed;
  double* next = output(call, out_next);
  std::copy_n(input(call, in_state), call->out_count[out_next], next);
  const std::span<double> q = q_of(who, next), v = v_of(who, next);
  if (call->in[in_torque]) std::copy_n(input(call, in_torque), v.size(), way.system.drive.begin());

  dynamics::IntegrationReport report;
  report.status = IntegrationStatus::projection_failed;
  // What was open or thrown a tick before comes together: its velocity jumps to the nearest that opens no loop.
  if (way.system.project(call->tick->time, q, v) == dynamics::Projection::failed) return explain(call, self, report);
  report.status = IntegrationStatus::singular;
  if (!show_forces(call, way, q, v)) return explain(call, self, report);
  way.integrator.start(call->tick->time, q, v);
  report = way.integrator.advance(call->tick->time + call->tick->dt);
  if (report.status != IntegrationStatus::reached) return explain(call, self, report);
  std::ranges::copy(way.integrator.q(), q.begin());
  std::ranges::copy(way.integrator.v(), v.begin());
  *output(call, out_gap) = greatest_gap(way.system.links());
  *output(call, out_energy) = way.system.calc_energy(q, v);
  return 0;
}

/// Loops that the input `closed` is about: all that are closed at the start, or the one that is named.
std::vector<int> governed(Setup& s, const Mechanism& m) {
  std::vector<int> loops;
  std::string names;
  for (int i = 0; i < static_cast<int>(m.loops().size()); ++i) {
    const Loop& loop = m.loops()[static_cast<std::size_t>(i)];
    if (loop.closed && (s.text("loop").empty() || s.text("loop") == loop.name)) loops.push_back(i);
    if (loop.closed) names += (names.empty() ? "" : ", ") + loop.name;
  }
  if (loops.empty() && !s.text("loop").empty())
    s.fail(ErrorCode::unknown, "The mechanism has no closed loop named '" + s.text("loop") + "'.",
           names.empty() ? "Leave the parameter empty." : "Name one of " + names + ".");
  return loops;
}

void configure(Setup& s) {
  const Character* who = character_of(s);
  const World* world = world_of(s);
  if (!who || !world) return;
  const Mechanism& m = *who->mechanism;
  const auto nv = static_cast<std::uint32_t>(m.nv());
  check_subject(s, in_torque, "torque", *who);
  if (s.in(in_torque).count != 0 && s.in(in_torque).count != nv)
    s.fail(ErrorCode::structure,
           "'" + who->id + "' has " + std::to_string(nv) + " freedoms; what is wired has " + std::to_string(s.in(in_torque).count) +
               " numbers.",
           "Wire one force for each freedom of the same character.");
  (void)governed(s, m);
  s.set_out(out_next, world->state_count());
  s.set_out(out_acceleration, World::payload_count(nv), who->index);
  std::size_t rows = 0;
  for (const Loop& loop : m.loops()) rows += static_cast<std::size_t>(loop.rows());
  s.set_out(out_forces, World::payload_count(rows), who->index);
  s.set_state(2 * sizeof(ClosedLinks::Memory));
}

void* make(Setup& s) {
  const Character* who = character_of(s);
  const World* world = world_of(s);
  if (!who || !world) return nullptr;
  const std::vector<int> loops = governed(s, *who->mechanism);
  dynamics::OpenSystemOptions options;
  options.gravity = world->gravity();
  dynamics::IntegratorOptions integration;
  for (const auto& [name, method] : methods)
    if (s.text("method") == name) integration.method = method;
  integration.step = s.dt() / s.number("steps");
  integration.relative_tolerance = integration.absolute_tolerance = s.number("tolerance");
  integration.max_steps = 100'000;
  auto self = std::make_unique<LinkDynamics>();
  self->character = who;
  self->closed = std::make_unique<Way>(*who, options, integration, std::span<const int>());
  if (!loops.empty()) self->opened = std::make_unique<Way>(*who, options, integration, loops);
  return self.release();
}

/// What the two ways remember, as plain bytes.
template <class Each>
void for_memories(const Call* call, Each each) {
  auto& self = object_of<LinkDynamics>(call);
  auto* at = static_cast<std::byte*>(call->state);
  for (Way* way : {self.closed.get(), self.opened.get()}) {
    if (way) each(*way, at);
    at += sizeof(ClosedLinks::Memory);
  }
}

}  // namespace

void add_link_dynamics(circuit::Library& library) {
  circuit::LsiClass c;
  c.name = "link dynamics";
  c.group = "mechanics";
  c.doc =
      "Dynamics of one open or closed link system by an integrator of one's choice, without contacts: joint springs, dampers, friction and "
      "limits act, loops hold to rounding. Of other characters the state is passed on.";
  c.inputs = {input_pin("state", PinTypeId::state, "", "Positions and velocities now."),
              input_pin("torque", PinTypeId::joint_values, "N | N m", "Drive forces; without wire: none."),
              input_pin("closed", PinTypeId::scalar, "1",
                        "Above 0.5: the loops are closed, as without wire; otherwise open. Where they close, what is left of the gap is "
                        "brought together and velocities jump to those that open no loop.")};
  c.inputs[in_torque].required = false;
  c.inputs[in_closed].required = false;
  c.inputs[in_closed].value = 1;
  c.outputs = {output_pin("next", PinTypeId::state, "", "Positions and velocities one tick later."),
               output_pin("acceleration", PinTypeId::joint_values, "m/s^2 | rad/s^2", "At the beginning of the tick."),
               output_pin("loop forces", PinTypeId::joint_values, "N | N m",
                          "In the loops at the beginning of the tick, row by row; 0 where a row follows from others or a loop is open."),
               output_pin("gap", PinTypeId::scalar, "m | rad", "The greatest that is left in a closed loop."),
               output_pin("energy", PinTypeId::scalar, "J", "Kinetic, potential and of springs, at the end of the tick.")};
  circuit::Parameter method;
  method.name = "method";
  method.kind = circuit::ParameterKind::choice;
  for (const auto& [name, unused] : methods) method.choices.emplace_back(name);
  method.initial = method.choices[0];
  method.doc = "Of integration. Dormand-Prince and Radau choose their steps within a tick by the tolerance.";
  method.live = false;
  circuit::Parameter loop;
  loop.name = "loop";
  loop.kind = circuit::ParameterKind::text;
  loop.initial = std::string();
  loop.doc = "The loop that the input `closed` is about; empty: all.";
  loop.live = false;
  circuit::Parameter steps = number_parameter("steps", 1, 1, 1000, "1", "Equal steps in a tick, of the methods that do not choose them.");
  steps.kind = circuit::ParameterKind::integer;
  circuit::Parameter tolerance = number_parameter("tolerance", 1e-8, 1e-13, 1, "1", "Of the methods that choose their steps.");
  c.parameters = {character_parameter(), std::move(method), std::move(steps), std::move(tolerance), std::move(loop)};
  for (circuit::Parameter& p : c.parameters) p.live = false;
  c.configure = configure;
  c.make = make;
  c.destroy = destroy<LinkDynamics>;
  c.init = [](const Call* call) -> std::int32_t {
    for_memories(call, [](Way& way, std::byte*) { way.system.set_memory(way.first); });
    return 0;
  };
  c.step = step;
  c.store = [](const Call* call) {
    for_memories(call, [](Way& way, std::byte* at) {
      const ClosedLinks::Memory memory = way.system.links().memory();
      std::memcpy(at, &memory, sizeof memory);
    });
  };
  c.recall = [](const Call* call) {
    for_memories(call, [](Way& way, const std::byte* at) {
      ClosedLinks::Memory memory;
      std::memcpy(&memory, at, sizeof memory);
      way.system.set_memory(memory);
    });
  };
  library.add(std::move(c));
}

}  // namespace ugoki::lsi
