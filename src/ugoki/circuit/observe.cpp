// Observation of a running circuit: probes, breakpoints, recording and replay of inputs.

#include <algorithm>
#include <cstring>

#include "ugoki/circuit/machine.h"

namespace ugoki::circuit {

const double* Interpreter::Machine::find_number(std::string_view pin, std::size_t component, Error& problems) const {
  const auto dot = pin.rfind('.');
  const int lsi = dot == std::string_view::npos ? -1 : find_unit(pin.substr(0, dot));
  const int k = lsi < 0 ? -1 : units[static_cast<std::size_t>(lsi)].lsi_class->find_output(pin.substr(dot + 1));
  if (k < 0) {
    problems.add(ErrorCode::unknown, std::string(pin), "The circuit has no output '" + std::string(pin) + "'.", "Write it as \"id.pin\".");
    return nullptr;
  }
  const PinView v = view({lsi, k});
  if (!pin_type(v.type).numeric) {
    problems.add(ErrorCode::unsupported, std::string(pin), "This pin does not carry numbers.", "Choose a pin of another type.");
    return nullptr;
  }
  if (component >= v.numbers().size()) {
    problems.add(ErrorCode::range, std::string(pin), "The pin has no number [" + std::to_string(component) + "].",
                 "Use an index from 0 to " + std::to_string(v.numbers().size() - 1) + ".");
    return nullptr;
  }
  return v.numbers().data() + component;
}

Result<void> Interpreter::set_probes(std::span<const std::string> pins, std::size_t rows, std::uint32_t every) {
  Machine& m = *machine_;
  constexpr std::size_t max_numbers = std::size_t{1} << 27;  // 1 GiB of doubles: bounds the memory of the probes
  Error problems;
  ProbeBuffer probes;
  for (const std::string& pin : pins) {
    const double* from = m.find_number(pin, 0, problems);
    if (!from) continue;
    const auto dot = pin.rfind('.');
    const int lsi = m.find_unit(std::string_view(pin).substr(0, dot));
    const int k = m.units[static_cast<std::size_t>(lsi)].lsi_class->find_output(std::string_view(pin).substr(dot + 1));
    const std::size_t count = m.view({lsi, k}).numbers().size();
    for (std::size_t i = 0; i < count; ++i) probes.sources.push_back(from + i);
  }
  if (!problems.empty()) return ugoki::fail(std::move(problems));
  if (rows == 0 || every == 0 || rows > max_numbers / std::max<std::size_t>(1, probes.width()))
    return ugoki::fail(ErrorCode::range, "probes",
                       "The ring buffer of the probes must hold at least 1 row and at most 1 GiB, and `every` must be at least 1.",
                       "Keep fewer rows, or probe fewer pins.");
  probes.every = every;
  probes.rows.resize(rows * probes.width());
  probes.ticks.resize(rows);
  m.probes = std::move(probes);
  m.update_plain();
  return {};
}

ProbeRows Interpreter::probes() const {
  const ProbeBuffer& p = machine_->probes;
  ProbeRows view;
  view.data_ = p.rows.data();
  view.ticks_ = p.ticks.data();
  view.width_ = p.width();
  view.capacity_ = std::max<std::size_t>(1, p.ticks.size());
  view.rows_ = static_cast<std::size_t>(std::min<std::uint64_t>(p.written, p.ticks.size()));
  view.first_ = p.written - view.rows_;
  return view;
}

void Interpreter::Machine::sample_probes() {
  const std::size_t row = probes.next;
  probes.next = row + 1 == probes.ticks.size() ? 0 : row + 1;
  double* to = probes.rows.data() + row * probes.width();
  for (const double* from : probes.sources) *to++ = *from;
  probes.ticks[row] = tick.index;
  ++probes.written;
}

Result<void> Interpreter::set_breakpoints(std::span<const Breakpoint> breakpoints) {
  Machine& m = *machine_;
  Error problems;
  std::vector<ActiveBreakpoint> active;
  for (const Breakpoint& b : breakpoints) active.push_back({b, m.find_number(b.pin, b.component, problems), 0, false});
  if (!problems.empty()) return ugoki::fail(std::move(problems));
  m.breakpoints = std::move(active);
  m.breakpoint_hit = -1;
  m.update_plain();
  return {};
}

int Interpreter::breakpoint_hit() const { return machine_->breakpoint_hit; }

void Interpreter::Machine::test_breakpoints() {
  for (std::size_t i = 0; i < breakpoints.size(); ++i) {
    ActiveBreakpoint& b = breakpoints[i];
    const double x = *b.number;
    bool met = false;
    switch (b.condition.comparison) {
      case Comparison::above: met = x > b.condition.value; break;
      case Comparison::below: met = x < b.condition.value; break;
      case Comparison::equal: met = x == b.condition.value; break;
      case Comparison::not_equal: met = x != b.condition.value; break;
      case Comparison::changed:
        met = b.armed && x != b.last;
        b.last = x;
        b.armed = true;
        if (met && breakpoint_hit < 0) breakpoint_hit = static_cast<int>(i);
        continue;
    }
    if (met && b.armed && breakpoint_hit < 0) breakpoint_hit = static_cast<int>(i);
    b.armed = !met;
  }
}

std::vector<DeviceSlot> Interpreter::devices() {
  Machine& m = *machine_;
  std::vector<DeviceSlot> out;
  for (std::size_t i = 0; i < m.units.size(); ++i) {
    const Unit& u = m.units[i];
    if (u.lsi_class->device.empty()) continue;
    for (std::size_t pin = 0; pin < u.outputs.size(); ++pin) {
      const std::size_t numbers = m.view({static_cast<int>(i), static_cast<int>(pin)}).bytes.size() / sizeof(double);
      out.push_back({u.id,
                     u.lsi_class->device,
                     u.address,
                     u.lsi_class->outputs[pin].name,
                     {reinterpret_cast<double*>(m.bytes() + u.output_offsets[pin]), numbers}});
    }
  }
  return out;
}

void Interpreter::start_recording() {
  Machine& m = *machine_;
  m.log.slots.clear();
  m.log.changes.clear();
  for (const FlatPort& port : m.inputs) m.log.slots.push_back({port.name, find_circuit_input(port.name), {}});
  for (const DeviceSlot& d : devices()) m.log.slots.push_back({d.id + "." + d.pin, std::as_writable_bytes(d.numbers), {}});
  for (RecordedSlot& s : m.log.slots) s.before.resize(s.now.size());  // all zero, which is the value after a reset
  m.log.recording = true;
  m.update_plain();
}

InputRecord Interpreter::recording() const { return {machine_->layout, machine_->tick.dt, machine_->tick.index, machine_->log.changes}; }

void Interpreter::Machine::record_inputs() {
  if (!log.recording) return;
  for (RecordedSlot& s : log.slots) {
    if (std::equal(s.now.begin(), s.now.end(), s.before.begin())) continue;
    s.before.assign(s.now.begin(), s.now.end());
    log.changes.push_back({tick.index, s.name, -1, s.before});
  }
}

Result<void> Interpreter::replay(const InputRecord& record) {
  Machine& m = *machine_;
  if (record.layout != m.layout || record.dt != m.tick.dt)
    return ugoki::fail(ErrorCode::conflict, "record",
                       "The record was made with another circuit, other versions of its LSIs, or another time step.",
                       "Run the circuit with which the record was made.");
  start_recording();
  m.log.recording = false;
  Error problems;
  const auto later = [](const InputChange& a, const InputChange& b) { return a.tick < b.tick; };
  if (!std::is_sorted(record.changes.begin(), record.changes.end(), later))
    problems.add(ErrorCode::structure, "record/changes", "The changes are not sorted by tick.", "Sort them by tick.");
  for (const InputChange& c : record.changes) {
    if (c.component >= 0) continue;
    const auto slot = std::find_if(m.log.slots.begin(), m.log.slots.end(), [&](const RecordedSlot& s) { return s.name == c.name; });
    if (slot == m.log.slots.end() || slot->now.size() != c.bytes.size())
      problems.add(ErrorCode::structure, c.name,
                   "The record sets '" + c.name + "' with " + std::to_string(c.bytes.size()) +
                       " bytes; the circuit has no input of this name and size.",
                   "Run the circuit with which the record was made.");
  }
  if (!problems.empty()) {
    m.update_plain();
    return ugoki::fail(std::move(problems));
  }
  m.log.replay = record.changes;
  m.log.next = 0;
  m.update_plain();
  return {};
}

void Interpreter::Machine::replay_inputs() {
  for (; log.next < log.replay.size() && log.replay[log.next].tick <= tick.index; ++log.next) {
    const InputChange& c = log.replay[log.next];
    if (c.tick < tick.index) continue;
    if (c.component < 0) {
      for (RecordedSlot& s : log.slots)
        if (s.name == c.name) std::copy(c.bytes.begin(), c.bytes.end(), s.now.begin());
      continue;
    }
    const auto dot = c.name.rfind('.');
    const int lsi = dot == std::string::npos ? -1 : find_unit(std::string_view(c.name).substr(0, dot));
    if (lsi < 0 || c.bytes.size() != sizeof(double)) continue;
    const Unit& u = units[static_cast<std::size_t>(lsi)];
    const int k = u.lsi_class->find_parameter(std::string_view(c.name).substr(dot + 1));
    const auto component = static_cast<std::size_t>(c.component);
    if (k < 0 || component > 2) continue;
    const Parameter& p = u.lsi_class->parameters[static_cast<std::size_t>(k)];
    if (p.kind == ParameterKind::text || (component > 0 && p.kind != ParameterKind::vector)) continue;
    std::memcpy(&parameters[u.parameters + parameter_offset(*u.lsi_class, static_cast<std::size_t>(k)) + component], c.bytes.data(),
                sizeof(double));
  }
}

}  // namespace ugoki::circuit
