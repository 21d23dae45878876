// Dynamics of one open or closed link system without contacts. A parameter selects the integrator. Loops are closed up to rounding errors;
// an input opens and closes loops while the circuit runs.

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

/// The system with a fixed set of closed loops, and its integrator.
struct Variant {
  Variant(const Character& who, const dynamics::OpenSystemOptions& options, const dynamics::IntegratorOptions& integration,
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
  ClosedLinks::Memory first;  ///< memory of the loops in the initial state
};

struct LinkDynamics {
  const Character* character;
  std::unique_ptr<Variant> closed, opened;  // system with its loops closed; with its loops opened (null: no loop to open)
};

std::int32_t explain(const Call* call, const LinkDynamics& self, const dynamics::IntegrationReport& report) {
  const std::string who = "'" + self.character->id + "'";
  const Mechanism& m = *self.character->mechanism;
  const std::string joint = report.dof < 0 ? who : "the joint of '" + m.link(m.link_of_dof(report.dof)).name + "' of " + who;
  switch (report.status) {
    case IntegrationStatus::singular:
      return circuit::stop(call, "The inertia at " + joint + " is not positive, so its acceleration is undefined.");
    case IntegrationStatus::not_finite: return circuit::stop(call, "The motion at " + joint + " has diverged; the time step is too large.");
    case IntegrationStatus::projection_failed:
      return circuit::stop(call, "The loops of " + who + " cannot be closed from the present position.");
    default: return circuit::stop(call, "The step of " + who + " failed: " + std::string(name_of(report.status)) + ".");
  }
}

/// Writes the acceleration at the beginning of the tick, and the loop forces. Returns false if the inertia matrix is singular.
bool write_forces(const Call* call, Variant& variant, std::span<const double> q, std::span<const double> v) {
  if (variant.system.calc_acceleration(call->tick->time, q, v, {output(call, out_acceleration), v.size()}) >= 0) return false;
  const std::span<const double> forces = variant.system.links().multipliers();
  std::copy(forces.begin(), forces.end(), output(call, out_forces));
  return true;
}

std::int32_t step(const Call* call) {
  auto& self = object_of<LinkDynamics>(call);
  const Character& who = *self.character;
  Variant& variant = self.opened && !(*input(call, in_closed) > 0.5) ? *self.opened : *self.closed;
  double* next = output(call, out_next);
  std::copy_n(input(call, in_state), call->out_count[out_next], next);
  const std::span<double> q = q_of(who, next), v = v_of(who, next);
  if (call->in[in_torque]) std::copy_n(input(call, in_torque), v.size(), variant.system.drive.begin());

  dynamics::IntegrationReport report;
  report.status = IntegrationStatus::projection_failed;
  // Loops may be open, because they were opened or the character was thrown. The projection closes them, and changes the velocity to the
  // closest one that keeps them closed.
  if (variant.system.project(call->tick->time, q, v) == dynamics::Projection::failed) return explain(call, self, report);
  report.status = IntegrationStatus::singular;
  if (!write_forces(call, variant, q, v)) return explain(call, self, report);
  variant.integrator.start(call->tick->time, q, v);
  report = variant.integrator.advance(call->tick->time + call->tick->dt);
  if (report.status != IntegrationStatus::reached) return explain(call, self, report);
  std::ranges::copy(variant.integrator.q(), q.begin());
  std::ranges::copy(variant.integrator.v(), v.begin());
  *output(call, out_gap) = max_gap(variant.system.links());
  *output(call, out_energy) = variant.system.calc_energy(q, v);
  return 0;
}

/// Returns the loops that the input `closed` controls: the one that the parameter `loop` names, or all loops that are closed at the start.
std::vector<int> controlled_loops(Setup& s, const Mechanism& m) {
  std::vector<int> loops;
  std::string names;
  for (int i = 0; i < static_cast<int>(m.loops().size()); ++i) {
    const Loop& loop = m.loops()[static_cast<std::size_t>(i)];
    if (loop.closed && (s.text("loop").empty() || s.text("loop") == loop.name)) loops.push_back(i);
    if (loop.closed) names += (names.empty() ? "" : ", ") + loop.name;
  }
  if (loops.empty() && !s.text("loop").empty())
    s.fail(ErrorCode::unknown, "The mechanism has no closed loop named '" + s.text("loop") + "'.",
           names.empty() ? "Leave the parameter 'loop' empty." : "Use one of: " + names + ".");
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
           "'" + who->id + "' has " + std::to_string(nv) + " degrees of freedom; the wired value has " +
               std::to_string(s.in(in_torque).count) + " numbers.",
           "Wire one force for each degree of freedom of this character.");
  (void)controlled_loops(s, m);
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
  const std::vector<int> loops = controlled_loops(s, *who->mechanism);
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
  self->closed = std::make_unique<Variant>(*who, options, integration, std::span<const int>());
  if (!loops.empty()) self->opened = std::make_unique<Variant>(*who, options, integration, loops);
  return self.release();
}

/// Calls each(variant, address) for every existing variant; `address` is the address of the variant's memory in the LSI's state.
template <class Each>
void for_memories(const Call* call, Each each) {
  auto& self = object_of<LinkDynamics>(call);
  auto* at = static_cast<std::byte*>(call->state);
  for (Variant* variant : {self.closed.get(), self.opened.get()}) {
    if (variant) each(*variant, at);
    at += sizeof(ClosedLinks::Memory);
  }
}

}  // namespace

void add_link_dynamics(circuit::Library& library) {
  circuit::LsiClass c;
  c.name = "link dynamics";
  c.group = "mechanics";
  c.doc =
      "Dynamics of one open or closed link system with a choice of integrators, without contacts. Joint springs, dampers, friction and "
      "limits act; loops are closed to rounding. The state of other characters is passed on unchanged.";
  c.inputs = {input_pin("state", PinTypeId::state, "", "Positions and velocities now."),
              input_pin("torque", PinTypeId::joint_values, "N | N m", "Drive forces; without a wire: zero."),
              input_pin("closed", PinTypeId::scalar, "1",
                        "Above 0.5 or without a wire: the loops are closed; otherwise open. When they close, the remaining gap is removed "
                        "and the velocities change to the closest ones that keep the loops closed.")};
  c.inputs[in_torque].required = false;
  c.inputs[in_closed].required = false;
  c.inputs[in_closed].value = 1;
  c.outputs = {output_pin("next", PinTypeId::state, "", "Positions and velocities one tick later."),
               output_pin("acceleration", PinTypeId::joint_values, "m/s^2 | rad/s^2", "Acceleration at the beginning of the tick."),
               output_pin("loop forces", PinTypeId::joint_values, "N | N m",
                          "Constraint forces of the loops at the beginning of the tick, row by row; 0 for redundant rows and open loops."),
               output_pin("gap", PinTypeId::scalar, "m | rad", "Largest remaining gap of a closed loop."),
               output_pin("energy", PinTypeId::scalar, "J", "Kinetic, potential and spring energy at the end of the tick.")};
  circuit::Parameter method;
  method.name = "method";
  method.kind = circuit::ParameterKind::choice;
  for (const auto& [name, unused] : methods) method.choices.emplace_back(name);
  method.initial = method.choices[0];
  method.doc = "Integration method. Dormand-Prince and Radau choose their step sizes within a tick by the tolerance.";
  method.live = false;
  circuit::Parameter loop;
  loop.name = "loop";
  loop.kind = circuit::ParameterKind::text;
  loop.initial = std::string();
  loop.doc = "Name of the loop that the input `closed` opens and closes; empty: all loops.";
  loop.live = false;
  circuit::Parameter steps =
      number_parameter("steps", 1, 1, 1000, "1", "Number of equal steps per tick, for methods with a fixed step size.");
  steps.kind = circuit::ParameterKind::integer;
  circuit::Parameter tolerance =
      number_parameter("tolerance", 1e-8, 1e-13, 1, "1", "Relative and absolute error tolerance, for methods with adaptive step size.");
  c.parameters = {character_parameter(), std::move(method), std::move(steps), std::move(tolerance), std::move(loop)};
  for (circuit::Parameter& p : c.parameters) p.live = false;
  c.configure = configure;
  c.make = make;
  c.destroy = destroy<LinkDynamics>;
  c.init = [](const Call* call) -> std::int32_t {
    for_memories(call, [](Variant& variant, std::byte*) { variant.system.set_memory(variant.first); });
    return 0;
  };
  c.step = step;
  c.store = [](const Call* call) {
    for_memories(call, [](Variant& variant, std::byte* at) {
      const ClosedLinks::Memory memory = variant.system.links().memory();
      std::memcpy(at, &memory, sizeof memory);
    });
  };
  c.recall = [](const Call* call) {
    for_memories(call, [](Variant& variant, const std::byte* at) {
      ClosedLinks::Memory memory;
      std::memcpy(&memory, at, sizeof memory);
      variant.system.set_memory(memory);
    });
  };
  library.add(std::move(c));
}

}  // namespace ugoki::lsi
