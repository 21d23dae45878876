#include "ugoki/circuit/machine.h"

#include <algorithm>
#include <cstring>

#include "ugoki/base/floating_point_mode.h"
#include "ugoki/base/hash.h"

namespace ugoki::circuit {
namespace {

/// Assigns offsets in the arena before the arena is allocated.
class Layout {
 public:
  std::size_t take(std::size_t bytes) {
    const std::size_t begin = size_;
    size_ += (bytes + 7) / 8 * 8;
    return begin;
  }
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  std::size_t size_ = 0;
};

std::size_t output_bytes(const Unit& unit, std::size_t pin) {
  return payload_bytes(pin_type(unit.lsi_class->outputs[pin].type), unit.outputs[pin].count);
}

/// Places the outputs and states of LSIs in the arena, for LSIs of installed libraries with a guard word (Fence) on both sides.
class Placer {
 public:
  Placer(Layout& layout, std::vector<Fence>& fences) : layout_(layout), fences_(fences) {}

  /// Places the delayed or the direct outputs of an LSI. Numeric outputs come first, so that one range contains all numbers that must be
  /// finite. @return the range of these numbers
  Range outputs(Unit& unit, std::uint32_t lsi, bool delayed) {
    const auto is_here = [delayed](const OutputPin& pin) { return pin.delayed == delayed; };
    if (std::ranges::any_of(unit.lsi_class->outputs, is_here)) fence(unit, {0, lsi, 0, Fence::Side::before_outputs});
    Range numbers{layout_.size(), layout_.size()};
    for (const bool numeric : {true, false})
      for (std::size_t pin = 0; pin < unit.outputs.size(); ++pin) {
        const OutputPin& declared = unit.lsi_class->outputs[pin];
        if (!is_here(declared) || pin_type(declared.type).numeric != numeric) continue;
        unit.output_offsets[pin] = layout_.take(output_bytes(unit, pin));
        if (numeric) numbers.end = layout_.size();
        fence(unit, {0, lsi, static_cast<std::uint32_t>(pin), Fence::Side::after_output});
      }
    return numbers;
  }

  Range state(const Unit& unit, std::uint32_t lsi, std::size_t bytes) {
    if (bytes) fence(unit, {0, lsi, 0, Fence::Side::before_state});
    Range range;
    range.begin = layout_.take(bytes);
    range.end = layout_.size();
    if (bytes) fence(unit, {0, lsi, 0, Fence::Side::after_state});
    return range;
  }

 private:
  void fence(const Unit& unit, Fence fence) {
    if (unit.lsi_class->from.empty()) return;  // no guard words: built-in LSIs are trusted
    fence.at = layout_.take(sizeof Fence::intact);
    fences_.push_back(fence);
  }

  Layout& layout_;
  std::vector<Fence>& fences_;
};

/// Returns the payload that an optional input pin reads while no wire is connected to it.
/// @param given numbers from the circuit; empty: the default value of the pin is used
std::vector<double> default_payload(const InputPin& pin, const std::vector<double>& given) {
  if (!given.empty()) return given;
  const PinType& type = pin_type(pin.type);
  const std::uint32_t count = pin.count ? pin.count : type.default_count;
  std::vector<double> numbers(payload_bytes(type, count) / sizeof(double), type.numeric ? pin.value : 0.0);
  const std::size_t stride = type.element_bytes / sizeof(double);
  if (pin.type == PinTypeId::rotation || pin.type == PinTypeId::pose)
    for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = i % stride == (pin.type == PinTypeId::pose ? 3u : 0u) ? 1.0 : 0.0;
  return numbers;
}

std::uint64_t hash_layout(const std::vector<Unit>& units, double dt) {
  Hash64 hash;
  hash.add(dt);
  for (const Unit& u : units) {
    hash.add_bytes(u.id.data(), u.id.size() + 1);
    hash.add_bytes(u.lsi_class->name.data(), u.lsi_class->name.size() + 1);
    hash.add(std::uint64_t{u.lsi_class->version});
    hash.add(std::uint64_t{u.state.size()});
    hash.add(u.lsi_class->state_layout());
    for (const Shape& s : u.outputs) hash.add(std::uint64_t{s.count});
  }
  return hash.value();
}

/// Sets all elements of a declared field to its initial value. @param state  the LSI's state
void set_field(const StateField& field, std::byte* state) {
  const auto fill = [&]<class T>(T value) {
    for (std::uint32_t i = 0; i < field.count; ++i) std::memcpy(state + field.offset + i * sizeof(T), &value, sizeof(T));
  };
  switch (field.type) {
    case FieldType::f64: return fill(field.initial);
    case FieldType::f32: return fill(static_cast<float>(field.initial));
    case FieldType::i64: return fill(static_cast<std::int64_t>(field.initial));
    case FieldType::i32: return fill(static_cast<std::int32_t>(field.initial));
    case FieldType::u64: return fill(static_cast<std::uint64_t>(field.initial));
    case FieldType::u32: return fill(static_cast<std::uint32_t>(field.initial));
    case FieldType::i8: return fill(static_cast<std::int8_t>(field.initial));
    case FieldType::u8: return fill(static_cast<std::uint8_t>(field.initial));
  }
}

struct Constant {
  std::size_t offset = 0;
  std::vector<double> numbers;
};

}  // namespace

std::unique_ptr<Interpreter::Machine> make_machine(FlatCircuit flat, Plan plan, const BuildOptions& options, Error& problems) {
  auto machine = std::make_unique<Interpreter::Machine>();
  Interpreter::Machine& m = *machine;
  const std::size_t n = flat.lsis.size();
  m.units.resize(n);
  m.running.resize(n);
  m.tick.size = sizeof m.tick;
  m.tick.dt = options.dt;
  m.activity = options.activity ? options.activity : &m.own_activity;
  m.order = plan.order;
  m.inputs = std::move(flat.inputs);
  m.outputs = std::move(flat.outputs);

  std::vector<std::uint32_t> rates;
  for (const FlatLsi& lsi : flat.lsis)
    if (lsi.every > 1) rates.push_back(lsi.every);
  std::ranges::sort(rates);
  rates.erase(std::unique(rates.begin(), rates.end()), rates.end());
  for (const std::uint32_t every : rates) {
    m.slow_ticks.push_back(m.tick);
    m.slow_ticks.back().dt = options.dt * every;
    m.slow_rates.push_back(every);
  }

  Layout layout;
  Placer placer(layout, m.fences);
  for (std::size_t i = 0; i < n; ++i) {
    Unit& u = m.units[i];
    u.id = flat.lsis[i].id;
    u.lsi_class = flat.lsis[i].lsi_class;
    u.every = flat.lsis[i].every;
    u.outputs = plan.setups[i].outputs();
    u.address = plan.setups[i].first_word();
    m.running[i] = {u.id.c_str(), u.lsi_class, nullptr};
    if (m.activity->announce) m.activity->announce(m.running[i]);
    u.output_offsets.resize(u.outputs.size());
  }
  for (const int i : m.order) {
    Unit& u = m.units[static_cast<std::size_t>(i)];
    u.direct_numbers = placer.outputs(u, static_cast<std::uint32_t>(i), false);
  }
  m.front.begin = layout.size();
  const std::size_t first_delayed = m.fences.size();
  for (const int i : m.order) {
    Unit& u = m.units[static_cast<std::size_t>(i)];
    u.delayed_numbers = placer.outputs(u, static_cast<std::uint32_t>(i), true);
  }
  m.front.end = layout.size();
  m.back.begin = layout.take(m.front.size());
  m.back.end = layout.size();
  const std::size_t to_back = m.back.begin - m.front.begin;
  for (std::size_t i = first_delayed, n_fences = m.fences.size(); i < n_fences; ++i) m.fences[i].at += to_back;  // LSIs write to `back`
  for (const int i : m.order) {
    Unit& u = m.units[static_cast<std::size_t>(i)];
    u.delayed_numbers.begin += to_back;
    u.delayed_numbers.end += to_back;
    u.state = placer.state(u, static_cast<std::uint32_t>(i), plan.setups[static_cast<std::size_t>(i)].state_bytes());
  }
  std::vector<Constant> constants;
  std::vector<std::vector<std::size_t>> constant_offsets(n);  // [lsi][input] arena offset, bytes; for unwired inputs
  for (std::size_t i = 0; i < n; ++i) {
    const FlatLsi& lsi = flat.lsis[i];
    constant_offsets[i].resize(lsi.inputs.size());
    for (std::size_t pin = 0; pin < lsi.inputs.size(); ++pin) {
      if (!lsi.inputs[pin].sources.empty() || lsi.lsi_class->inputs[pin].multiple) continue;
      Constant c{0, default_payload(lsi.lsi_class->inputs[pin], lsi.inputs[pin].value)};
      if (c.numbers.empty()) continue;
      constant_offsets[i][pin] = c.offset = layout.take(c.numbers.size() * sizeof(double));
      constants.push_back(std::move(c));
    }
  }
  m.arena = Arena(layout.size() / 8 + 1);
  for (const Constant& c : constants) std::memcpy(m.bytes() + c.offset, c.numbers.data(), c.numbers.size() * sizeof(double));
  m.layout = hash_layout(m.units, options.dt);

  // Reserve first: calls point into these vectors, so they must not be reallocated.
  std::size_t wires = 0, ins = 0, outs = 0, numbers = 0;
  for (std::size_t i = 0; i < n; ++i) {
    ins += flat.lsis[i].inputs.size() + 1;
    for (const FlatInput& input : flat.lsis[i].inputs) wires += std::max<std::size_t>(1, input.sources.size());
    outs += m.units[i].outputs.size();
    numbers += plan.setups[i].numbers().size();
  }
  m.in.reserve(wires);
  m.in_count.reserve(wires);
  m.in_first.reserve(ins);
  m.out.reserve(outs);
  m.out_count.reserve(outs);
  m.parameters.reserve(numbers);
  m.calls.resize(n);
  m.call_of.resize(n);
  std::vector<Job> advances;
  for (std::size_t rank = 0; rank < n; ++rank) {
    const auto i = static_cast<std::size_t>(m.order[rank]);
    m.call_of[i] = static_cast<std::uint32_t>(rank);
    const FlatLsi& lsi = flat.lsis[i];
    Unit& u = m.units[i];
    Call& call = m.calls[rank];
    call.size = sizeof call;
    call.in = m.in.data() + m.in.size();
    call.in_first = m.in_first.data() + m.in_first.size();
    call.in_count = m.in_count.data() + m.in_count.size();
    call.out = m.out.data() + m.out.size();
    call.out_count = m.out_count.data() + m.out_count.size();
    std::uint32_t first = 0;
    for (std::size_t pin = 0; pin < lsi.inputs.size(); ++pin) {
      const InputPin& declared = lsi.lsi_class->inputs[pin];
      m.in_first.push_back(first);
      for (const Source& s : lsi.inputs[pin].sources) {
        const Unit& from = m.units[static_cast<std::size_t>(s.lsi)];
        m.in.push_back(m.bytes() + from.output_offsets[static_cast<std::size_t>(s.pin)]);
        m.in_count.push_back(from.outputs[static_cast<std::size_t>(s.pin)].count);
        ++first;
      }
      if (!lsi.inputs[pin].sources.empty() || declared.multiple) continue;
      const std::uint32_t count = declared.count ? declared.count : pin_type(declared.type).default_count;
      m.in.push_back(count ? m.bytes() + constant_offsets[i][pin] : nullptr);
      m.in_count.push_back(count);
      ++first;
    }
    m.in_first.push_back(first);
    for (std::size_t pin = 0; pin < u.outputs.size(); ++pin) {
      const bool delayed = u.lsi_class->outputs[pin].delayed;
      m.out.push_back(m.bytes() + u.output_offsets[pin] + (delayed ? to_back : 0));
      m.out_count.push_back(u.outputs[pin].count);
    }
    u.parameters = m.parameters.size();
    call.parameters = m.parameters.data() + m.parameters.size();
    for (const double x : plan.setups[i].numbers()) m.parameters.push_back(x);
    call.state = u.state.size() ? m.bytes() + u.state.begin : nullptr;
    call.tick = &m.tick_of(u.every);
    call.reason = m.reason;
    call.reason_size = sizeof m.reason;
    call.object = nullptr;

    const auto job = [&](StepFunction run, const Range& range) {
      Job j{run, &call, &m.running[i], nullptr, 0, u.every, static_cast<std::uint32_t>(i)};
      if (options.check_finite && range.size()) {
        j.check = reinterpret_cast<const double*>(m.bytes() + range.begin);
        j.check_count = static_cast<std::uint32_t>(range.size() / sizeof(double));
      }
      return j;
    };
    if (u.lsi_class->step) (u.every == 0 ? m.on_demand : m.jobs).push_back(job(u.lsi_class->step, u.direct_numbers));
    if (u.lsi_class->advance) advances.push_back(job(u.lsi_class->advance, u.delayed_numbers));
  }
  m.step_count = m.jobs.size();
  m.jobs.insert(m.jobs.end(), advances.begin(), advances.end());
  for (const std::uint32_t end : plan.wave_ends) {
    const auto jobs = static_cast<std::uint32_t>(std::count_if(m.order.data(), m.order.data() + end, [&](int i) {
      const Unit& u = m.units[static_cast<std::size_t>(i)];
      return u.lsi_class->step && u.every != 0;
    }));
    m.wave_ends.push_back(jobs);
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (!m.units[i].lsi_class->from.empty()) m.foreign.push_back(static_cast<std::uint32_t>(i));
    if (m.units[i].lsi_class->make) {
      const KeepFloatingPointMode keep;
      set_running(*m.activity, &m.running[i]);
      m.call_at(i).object = m.units[i].lsi_class->make(plan.setups[i]);
    }
    m.running[i].call = &m.call_at(i);
  }
  set_running(*m.activity, nullptr);
  if (problems.empty()) m.initialise();
  return machine;
}

Interpreter::Machine::~Machine() {
  for (std::size_t i = 0; i < units.size(); ++i) {
    if (call_of.size() <= i || !units[i].lsi_class->destroy || !call_at(i).object) continue;
    set_running(*activity, &running[i]);
    units[i].lsi_class->destroy(call_at(i).object);
  }
  if (activity) set_running(*activity, nullptr);
}

const Tick& Interpreter::Machine::tick_of(std::uint32_t every) const {
  if (every <= 1) return tick;
  return slow_ticks[static_cast<std::size_t>(std::ranges::lower_bound(slow_rates, every) - slow_rates.begin())];
}

void Interpreter::Machine::set_tick(std::uint64_t index) {
  tick.index = index;
  tick.time = static_cast<double>(index) * tick.dt;
  for (Tick& t : slow_ticks) {
    t.index = index;
    t.time = tick.time;
  }
}

void Interpreter::Machine::initialise() {
  const std::uint64_t mode = floating_point_mode();
  set_tick(0);
  is_stopped = false;
  cursor = 0;
  breakpoint_hit = -1;
  log.next = 0;
  std::memset(arena.data(), 0, back.end);
  set_fences();
  for (std::size_t i = 0; i < units.size(); ++i) {
    const Unit& u = units[i];
    if (u.state.size()) std::memset(bytes() + u.state.begin, 0, u.state.size());
    for (const StateField& field : u.lsi_class->fields) set_field(field, bytes() + u.state.begin);
  }
  for (std::size_t i = 0; i < units.size() && !is_stopped; ++i) {
    if (!units[i].lsi_class->init) continue;
    reason[0] = '\0';
    set_running(*activity, &running[i]);
    const Job job{units[i].lsi_class->init, &call_at(i), &running[i], nullptr, 0, 1, static_cast<std::uint32_t>(i)};
    if (job.run(job.call) != 0) fail(job, false);
  }
  set_running(*activity, nullptr);
  std::memcpy(bytes() + front.begin, bytes() + back.begin, front.size());
  if (!is_stopped) (void)are_libraries_sound(mode);
}

void Interpreter::Machine::set_fences() {
  for (const Fence& f : fences) std::memcpy(bytes() + f.at, &Fence::intact, sizeof Fence::intact);
}

/// Returns false and stops the interpreter if an LSI has written outside its own memory. The check follows each run of ticks, so the
/// write may have happened some ticks earlier than the tick in `stop`.
bool Interpreter::Machine::are_fences_intact() {
  const auto is_intact = [this](const Fence& f) {
    std::uint64_t now;
    std::memcpy(&now, bytes() + f.at, sizeof now);
    return now == Fence::intact;
  };
  const auto broken = std::ranges::find_if_not(fences, is_intact);
  if (broken == fences.end()) return true;
  const Unit& u = units[broken->lsi];
  is_stopped = true;
  stop = {u.id, {}, u.lsi_class->from, {}, {}, tick.index ? tick.index - 1 : 0, 0};
  stop.time = static_cast<double>(stop.tick) * tick.dt;
  switch (broken->side) {
    case Fence::Side::before_outputs: stop.reason = "It wrote in front of its outputs."; break;
    case Fence::Side::before_state: stop.reason = "It wrote in front of its state."; break;
    case Fence::Side::after_state: stop.reason = "It wrote beyond its state of " + std::to_string(u.state.size()) + " bytes."; break;
    case Fence::Side::after_output: {
      const OutputPin& pin = u.lsi_class->outputs[broken->pin];
      stop.pin = u.id + "." + pin.name;
      const std::size_t bytes = output_bytes(u, broken->pin), count = bytes / sizeof(double);
      stop.reason = "It wrote beyond its output '" + pin.name + "', which has " +
                    (!pin_type(pin.type).numeric ? std::to_string(bytes) + " bytes."
                     : count == 1                ? "one number."
                                                 : std::to_string(count) + " numbers.");
      break;
    }
  }
  return false;
}

/// Restores the floating-point mode of this thread if an LSI of a library has changed it. Then returns false and stops the interpreter,
/// unless another error has stopped it. The check follows each run of ticks, so the results of the ticks of this run may be wrong.
bool Interpreter::Machine::is_mode_intact(std::uint64_t mode) {
  if (foreign.empty() || floating_point_mode() == mode) return true;
  set_floating_point_mode(mode);
  if (is_stopped) return true;
  is_stopped = true;
  const Unit& first = units[foreign.front()];
  stop = {first.id, {}, first.lsi_class->from, {}, {}, tick.index ? tick.index - 1 : 0, 0};
  stop.time = static_cast<double>(stop.tick) * tick.dt;
  constexpr const char* change = " changed the floating-point mode (rounding, subnormal numbers or traps) and did not restore it.";
  if (foreign.size() == 1) {
    stop.reason = std::string("It") + change;
    return false;
  }
  constexpr std::size_t max_named = 8;
  std::string names;
  for (std::size_t i = 0; i < std::min(foreign.size(), max_named); ++i) names += (i ? ", '" : "'") + units[foreign[i]].id + "'";
  if (foreign.size() > max_named) names += " and " + std::to_string(foreign.size() - max_named) + " others";
  stop.reason = "One of the LSIs of libraries (" + names + ")" + change;
  return false;
}

void Interpreter::Machine::fail(const Job& job, bool not_finite) {
  const Unit& u = units[job.lsi];
  is_stopped = true;
  stop.lsi = u.id;
  stop.pin.clear();
  stop.library = u.lsi_class->from;
  stop.tick = tick.index;
  stop.time = tick.time;
  stop.reason = job.call->reason[0] ? job.call->reason : "It failed and gave no reason.";
  char buffer[512];
  stop.inputs = std::string(buffer, describe_inputs(*job.who, buffer));
  if (!not_finite) return;
  for (std::size_t pin = 0; pin < u.outputs.size(); ++pin) {
    if (!pin_type(u.lsi_class->outputs[pin].type).numeric) continue;
    const auto* x = static_cast<const double*>(job.call->out[pin]);
    const std::size_t count = output_bytes(u, pin) / sizeof(double);
    for (std::size_t k = 0; k < count; ++k)
      if (!(x[k] - x[k] == 0)) {
        stop.pin = u.id + "." + u.lsi_class->outputs[pin].name;
        stop.reason = "Number " + std::to_string(k) + " of its output '" + u.lsi_class->outputs[pin].name + "' is not finite.";
        return;
      }
  }
}

int Interpreter::Machine::find_unit(std::string_view id) const {
  const auto at = std::lower_bound(units.begin(), units.end(), id, [](const Unit& u, std::string_view name) { return u.id < name; });
  return at != units.end() && at->id == id ? static_cast<int>(at - units.begin()) : -1;
}

PinView Interpreter::Machine::view(const Source& source) const {
  const Unit& u = units[static_cast<std::size_t>(source.lsi)];
  const auto pin = static_cast<std::size_t>(source.pin);
  return {u.lsi_class->outputs[pin].type, u.outputs[pin].count, {bytes() + u.output_offsets[pin], output_bytes(u, pin)}};
}

void Interpreter::Machine::store_objects() {
  for (std::size_t i = 0; i < units.size(); ++i)
    if (units[i].lsi_class->store) units[i].lsi_class->store(&call_at(i));
}

void Interpreter::Machine::recall_objects() {
  for (std::size_t i = 0; i < units.size(); ++i)
    if (units[i].lsi_class->recall) units[i].lsi_class->recall(&call_at(i));
}

}  // namespace ugoki::circuit
