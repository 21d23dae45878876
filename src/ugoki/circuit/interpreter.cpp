#include "ugoki/circuit/interpreter.h"

#include <cmath>
#include <cstring>

#include "ugoki/base/number.h"
#include "ugoki/circuit/machine.h"

namespace ugoki::circuit {

std::string Stop::text() const {
  const bool is_sentence = reason.ends_with('.') || reason.ends_with('!') || reason.ends_with('?');
  return "'" + lsi + "'" + (library.empty() ? "" : " of library '" + library + "'") + " stopped at " + to_fixed(time, 3) + " s (tick " +
         std::to_string(tick) + "): " + reason + (is_sentence ? "" : ".") + inputs;
}

Result<Interpreter> Interpreter::build(const Circuit& circuit, const Library& library, const Resources* resources,
                                       const BuildOptions& options) {
  if (!(options.dt > 0) || !std::isfinite(options.dt))
    return ugoki::fail(ErrorCode::range, "step", "The time step is " + to_text(options.dt) + " s; it must be positive and finite.",
                       "Use for example 0.002 s.");
  Error problems;
  FlatCircuit flat = flatten(circuit, library, problems);
  if (!problems.empty()) return ugoki::fail(std::move(problems));
  Plan plan = make_plan(flat, resources, options.dt, problems);
  std::unique_ptr<Machine> machine;
  if (problems.empty()) machine = make_machine(std::move(flat), std::move(plan), options, problems);
  if (!problems.empty()) {
    Error unique;  // without duplicates: `configure` runs several times and may have reported the same problem each time
    for (Problem& p : problems.problems) {
      bool known = false;
      for (const Problem& q : unique.problems) known = known || (q.location == p.location && q.message == p.message);
      if (!known) unique.problems.push_back(std::move(p));
    }
    return ugoki::fail(std::move(unique));
  }
  if (machine->is_stopped)
    return ugoki::fail(ErrorCode::structure, machine->stop.lsi, "The LSI could not be started: " + machine->stop.reason,
                       "Check its parameters.");
  return Interpreter(std::move(machine));
}

Interpreter::Interpreter(std::unique_ptr<Machine> machine) : machine_(std::move(machine)) {}
Interpreter::Interpreter(Interpreter&&) noexcept = default;
Interpreter& Interpreter::operator=(Interpreter&&) noexcept = default;
Interpreter::~Interpreter() = default;

void Interpreter::reset() { machine_->initialise(); }

std::uint64_t Interpreter::ticks() const { return machine_->tick.index; }
double Interpreter::time() const { return machine_->tick.time; }
const Stop* Interpreter::stopped() const { return machine_->is_stopped ? &machine_->stop : nullptr; }

Result<PinView> Interpreter::find_output(std::string_view pin) const {
  const auto dot = pin.rfind('.');
  const std::string name(pin);
  if (dot != std::string_view::npos) {
    const int lsi = machine_->find_unit(pin.substr(0, dot));
    if (lsi >= 0) {
      const int k = machine_->units[static_cast<std::size_t>(lsi)].lsi_class->find_output(pin.substr(dot + 1));
      if (k >= 0) return machine_->view({lsi, k});
    }
  }
  return ugoki::fail(ErrorCode::unknown, name, "The circuit has no output '" + name + "'.", "Write it as \"id.pin\".");
}

Result<PinView> Interpreter::find_circuit_output(std::string_view name) const {
  for (const FlatPort& port : machine_->outputs)
    if (port.name == name) return machine_->view(port.source);
  return ugoki::fail(ErrorCode::unknown, std::string(name), "The circuit itself has no output '" + std::string(name) + "'.",
                     "Add it to the circuit's outputs.");
}

std::span<std::byte> Interpreter::find_circuit_input(std::string_view name) {
  for (const FlatPort& port : machine_->inputs)
    if (port.name == name) {
      const PinView v = machine_->view(port.source);
      return {machine_->bytes() + (v.bytes.data() - machine_->bytes()), v.bytes.size()};
    }
  return {};
}

Result<void> Interpreter::set_parameter(std::string_view parameter, double value, std::size_t component) {
  const auto dot = parameter.rfind('.');
  const std::string location(parameter);
  const int lsi = dot == std::string_view::npos ? -1 : machine_->find_unit(parameter.substr(0, dot));
  if (lsi < 0)
    return ugoki::fail(ErrorCode::unknown, location, "The circuit has no LSI for the parameter '" + location + "'.",
                       "Write the parameter as \"id.parameter\".");
  const Unit& u = machine_->units[static_cast<std::size_t>(lsi)];
  const int k = u.lsi_class->find_parameter(parameter.substr(dot + 1));
  if (k < 0)
    return ugoki::fail(ErrorCode::unknown, location, "'" + u.id + "' has no parameter '" + location.substr(dot + 1) + "'.",
                       "Correct the spelling.");
  const Parameter& p = u.lsi_class->parameters[static_cast<std::size_t>(k)];
  const std::size_t components = p.kind == ParameterKind::vector ? 3 : 1;
  if (!p.live || p.kind == ParameterKind::text || component >= components)
    return ugoki::fail(ErrorCode::unsupported, location, "This parameter cannot be changed while the circuit runs.",
                       "Change it in the circuit and build the circuit again.");
  const double maximum = p.kind == ParameterKind::boolean  ? 1.0
                         : p.kind == ParameterKind::choice ? static_cast<double>(p.choices.size() - 1)
                                                           : p.maximum;
  const double minimum = p.kind == ParameterKind::boolean || p.kind == ParameterKind::choice ? 0.0 : p.minimum;
  const bool whole = p.kind == ParameterKind::integer || p.kind == ParameterKind::boolean || p.kind == ParameterKind::choice;
  if (!std::isfinite(value) || value < minimum || value > maximum || (whole && std::floor(value) != value))
    return ugoki::fail(
        ErrorCode::range, location, "The value " + to_text(value) + " is not allowed.",
        "Give " + std::string(whole ? "a whole number" : "a number") + " from " + to_text(minimum) + " to " + to_text(maximum) + ".");
  machine_->parameters[u.parameters + parameter_offset(*u.lsi_class, static_cast<std::size_t>(k)) + component] = value;
  if (machine_->log.recording) {
    InputChange change{machine_->tick.index, location, static_cast<int>(component), std::vector<std::byte>(sizeof value)};
    std::memcpy(change.bytes.data(), &value, sizeof value);
    machine_->log.changes.push_back(std::move(change));
  }
  return {};
}

std::vector<std::string> Interpreter::schedule() const {
  std::vector<std::string> out;
  for (const int i : machine_->order) out.push_back(machine_->units[static_cast<std::size_t>(i)].id);
  return out;
}

std::size_t Interpreter::arena_bytes() const { return machine_->arena.size() * 8; }

}  // namespace ugoki::circuit
