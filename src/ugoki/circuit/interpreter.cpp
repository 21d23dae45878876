#include "ugoki/circuit/interpreter.h"

#include <cmath>
#include <cstring>

#include "ugoki/base/number.h"
#include "ugoki/circuit/machine.h"

namespace ugoki::circuit {
namespace {

constexpr std::uint64_t saved_magic = 0x3153434b4f4755ULL;  // "UGOKCS1"

struct SavedHeader {
  std::uint64_t magic, layout, ticks, arena_words, parameters, checksum;
};

/// Of tick and content, a word at a time: states are saved while they play.
std::uint64_t checksum_of(std::uint64_t ticks, std::span<const std::byte> content) {
  std::uint64_t hash = 0xcbf29ce484222325ULL ^ ticks;
  for (std::size_t at = 0; at + sizeof hash <= content.size(); at += sizeof hash) {
    std::uint64_t word;
    std::memcpy(&word, content.data() + at, sizeof word);
    hash = (hash ^ word) * 0x100000001b3ULL;
    hash ^= hash >> 32;
  }
  return hash;
}

/// All finite, without a branch for each: x - x is 0 for a finite x only.
inline bool all_finite(const double* x, std::uint32_t count) {
  if (count == 1) return *x - *x == 0;
  double even = 0, odd = 0;
  std::uint32_t i = 0;
  for (; i + 1 < count; i += 2) {
    even += x[i] - x[i];
    odd += x[i + 1] - x[i + 1];
  }
  if (i < count) even += x[i] - x[i];
  return even + odd == 0;
}

}  // namespace

std::string Stop::text() const {
  return "'" + lsi + "' stopped at " + to_fixed(time, 3) + " s (tick " + std::to_string(tick) + "): " + reason;
}

template <bool timed>
bool Interpreter::Machine::run(std::vector<Job>& jobs) {
  for (const Job& job : jobs) {
    if (job.every > 1 && tick.index % job.every != 0) continue;
    std::uint64_t begin = 0;
    if constexpr (timed) begin = clock();
    const std::int32_t status = job.run(job.call);
    if constexpr (timed) {
      Unit& u = units[static_cast<std::size_t>(job.lsi)];
      u.total += clock() - begin;
      ++u.runs;
    }
    if (status != 0) [[unlikely]] {
      fail(job, false);
      return false;
    }
    if (!all_finite(job.check, job.check_count)) [[unlikely]] {
      fail(job, true);
      return false;
    }
  }
  return true;
}

Result<Interpreter> Interpreter::build(const Circuit& circuit, const Library& library, const Resources* resources,
                                       const BuildOptions& options) {
  if (!(options.dt > 0) || !std::isfinite(options.dt))
    return ugoki::fail(ErrorCode::range, "step", "The step must be a positive time.", "Use for example 0.002 s.");
  Error problems;
  FlatCircuit flat = flatten(circuit, library, problems);
  if (!problems.empty()) return ugoki::fail(std::move(problems));
  Plan plan = make_plan(flat, resources, options.dt, problems);
  std::unique_ptr<Machine> machine;
  if (problems.empty()) machine = make_machine(std::move(flat), std::move(plan), options, problems);
  if (!problems.empty()) {
    Error once;  // configure may have said the same thing several times
    for (Problem& p : problems.problems) {
      bool known = false;
      for (const Problem& q : once.problems) known = known || (q.place == p.place && q.message == p.message);
      if (!known) once.problems.push_back(std::move(p));
    }
    return ugoki::fail(std::move(once));
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

bool Interpreter::tick() {
  Machine& m = *machine_;
  if (m.is_stopped) return false;
  m.reason[0] = '\0';
  const bool good = m.clock ? m.run<true>(m.steps) && m.run<true>(m.advances) : m.run<false>(m.steps) && m.run<false>(m.advances);
  if (!good) return false;
  std::memcpy(m.bytes() + m.front.begin, m.bytes() + m.back.begin, m.front.size());
  ++m.tick.index;
  m.tick.time = static_cast<double>(m.tick.index) * m.tick.dt;
  return true;
}

bool Interpreter::refresh() {
  Machine& m = *machine_;
  m.reason[0] = '\0';
  return m.clock ? m.run<true>(m.on_demand) : m.run<false>(m.on_demand);
}

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
  return ugoki::fail(ErrorCode::unknown, name, "The circuit has no such output.", "Write it as \"id.pin\".");
}

Result<PinView> Interpreter::find_circuit_output(std::string_view name) const {
  for (const FlatPort& port : machine_->outputs)
    if (port.name == name) return machine_->view(port.source);
  return ugoki::fail(ErrorCode::unknown, std::string(name), "The circuit itself has no output of this name.",
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
  const std::string place(parameter);
  const int lsi = dot == std::string_view::npos ? -1 : machine_->find_unit(parameter.substr(0, dot));
  if (lsi < 0) return ugoki::fail(ErrorCode::unknown, place, "The circuit has no such LSI.", "Write the parameter as \"id.parameter\".");
  const Unit& u = machine_->units[static_cast<std::size_t>(lsi)];
  const int k = u.lsi_class->find_parameter(parameter.substr(dot + 1));
  if (k < 0) return ugoki::fail(ErrorCode::unknown, place, "The LSI has no such parameter.", "Mind the spelling.");
  const Parameter& p = u.lsi_class->parameters[static_cast<std::size_t>(k)];
  const std::size_t components = p.kind == ParameterKind::vector ? 3 : 1;
  if (!p.live || p.kind == ParameterKind::text || component >= components)
    return ugoki::fail(ErrorCode::unsupported, place, "This parameter cannot be changed while the circuit runs.",
                       "Change it in the circuit.");
  const double top = p.kind == ParameterKind::boolean  ? 1.0
                     : p.kind == ParameterKind::choice ? static_cast<double>(p.choices.size() - 1)
                                                       : p.maximum;
  const double bottom = p.kind == ParameterKind::boolean || p.kind == ParameterKind::choice ? 0.0 : p.minimum;
  const bool whole = p.kind == ParameterKind::integer || p.kind == ParameterKind::boolean || p.kind == ParameterKind::choice;
  if (!std::isfinite(value) || value < bottom || value > top || (whole && std::floor(value) != value))
    return ugoki::fail(
        ErrorCode::range, place, "The value is out of range.",
        "Give " + std::string(whole ? "a whole number" : "a number") + " from " + to_text(bottom) + " to " + to_text(top) + ".");
  machine_->parameters[u.parameters + parameter_offset(*u.lsi_class, static_cast<std::size_t>(k)) + component] = value;
  return {};
}

void Interpreter::save(std::vector<std::byte>& bytes) {
  Machine& m = *machine_;
  m.store_objects();
  SavedHeader header{saved_magic, m.layout, m.tick.index, m.arena.size(), m.parameters.size(), 0};
  const std::size_t arena_size = m.arena.size() * 8, parameter_size = m.parameters.size() * 8;
  bytes.resize(sizeof header + arena_size + parameter_size);
  std::byte* content = bytes.data() + sizeof header;
  std::memcpy(content, m.arena.data(), arena_size);
  if (parameter_size) std::memcpy(content + arena_size, m.parameters.data(), parameter_size);
  header.checksum = checksum_of(header.ticks, {content, arena_size + parameter_size});
  std::memcpy(bytes.data(), &header, sizeof header);
}

Result<void> Interpreter::restore(std::span<const std::byte> bytes) {
  Machine& m = *machine_;
  SavedHeader header{};
  if (bytes.size() >= sizeof header) std::memcpy(&header, bytes.data(), sizeof header);
  if (header.magic != saved_magic)
    return ugoki::fail(ErrorCode::syntax, "saved state", "These bytes are not a saved state.", "Give what save wrote.");
  if (header.layout != m.layout || header.arena_words != m.arena.size() || header.parameters != m.parameters.size())
    return ugoki::fail(ErrorCode::conflict, "saved state", "The state was saved by another circuit, or another version of its LSIs.",
                       "Run from the beginning.");
  const std::size_t arena_size = m.arena.size() * 8, parameter_size = m.parameters.size() * 8;
  const std::span<const std::byte> content = bytes.subspan(sizeof header);
  if (content.size() != arena_size + parameter_size || header.checksum != checksum_of(header.ticks, content))
    return ugoki::fail(ErrorCode::truncated, "saved state", "The saved state is cut off or damaged.", "Run from the beginning.");
  std::memcpy(m.arena.data(), content.data(), arena_size);
  if (parameter_size) std::memcpy(m.parameters.data(), content.data() + arena_size, parameter_size);
  m.tick.index = header.ticks;
  m.tick.time = static_cast<double>(header.ticks) * m.tick.dt;
  m.is_stopped = false;
  m.recall_objects();
  return {};
}

std::size_t Interpreter::adopt(Interpreter& other) {
  Machine& m = *machine_;
  Machine& o = *other.machine_;
  o.store_objects();
  std::size_t taken = 0;
  const std::size_t to_back = m.back.begin - m.front.begin, from_back = o.back.begin - o.front.begin;
  for (std::size_t i = 0; i < m.units.size(); ++i) {
    const Unit& to = m.units[i];
    const int k = o.find_unit(to.id);
    if (k < 0) continue;
    const Unit& from = o.units[static_cast<std::size_t>(k)];
    if (from.lsi_class->name != to.lsi_class->name || from.lsi_class->version != to.lsi_class->version || from.outputs != to.outputs ||
        from.state.size() != to.state.size())
      continue;
    if (to.state.size()) std::memcpy(m.bytes() + to.state.begin, o.bytes() + from.state.begin, to.state.size());
    for (std::size_t pin = 0; pin < to.outputs.size(); ++pin) {
      const std::size_t size = m.view({static_cast<int>(i), static_cast<int>(pin)}).bytes.size();
      std::memcpy(m.bytes() + to.output_offsets[pin], o.bytes() + from.output_offsets[pin], size);
      if (to.lsi_class->outputs[pin].delayed)
        std::memcpy(m.bytes() + to.output_offsets[pin] + to_back, o.bytes() + from.output_offsets[pin] + from_back, size);
    }
    if (to.lsi_class->recall) to.lsi_class->recall(&m.calls[i]);
    ++taken;
  }
  m.tick.index = o.tick.index;
  m.tick.time = static_cast<double>(m.tick.index) * m.tick.dt;
  return taken;
}

void Interpreter::set_timing(Clock clock) {
  machine_->clock = clock;
  for (Unit& u : machine_->units) u.runs = u.total = 0;
}

std::vector<Timing> Interpreter::timings() const {
  std::vector<Timing> out;
  for (const Unit& u : machine_->units)
    if (u.runs) out.push_back({u.id, u.runs, u.total});
  return out;
}

std::vector<std::string> Interpreter::schedule() const {
  std::vector<std::string> out;
  for (const int i : machine_->order) out.push_back(machine_->units[static_cast<std::size_t>(i)].id);
  return out;
}

std::size_t Interpreter::arena_bytes() const { return machine_->arena.size() * 8; }

}  // namespace ugoki::circuit
