// The functions of an FMU's LSI. One tick of the LSI is one communication step of the FMU. During a tick the outputs show the state of the
// FMU at the time of the tick. At the end of the tick, `advance` passes the inputs to the FMU and lets it compute up to the next tick.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>

#include "ugoki/base/number.h"
#include "ugoki/circuit/setup.h"
#include "ugoki/fmi/fmu.h"
#include "ugoki/fmi/group.h"
#include "ugoki/fmi/messages.h"

namespace ugoki::fmi {
namespace {

using circuit::Call;
using circuit::Setup;

constexpr std::size_t max_held = 256;  // maximum number of states kept inside an FMU that cannot serialise them; the oldest is dropped

/// Size in the saved state, bytes, of the values that were last set in the FMU (tunable parameters and discrete inputs).
std::size_t given_bytes(const Declaration& d) {
  std::size_t bytes = 0;
  for (const ParameterBinding& b : d.parameters) bytes += b.tunable ? b.count * sizeof(double) : 0;
  for (const PinBinding& b : d.inputs) bytes += b.discrete ? b.count * bytes_of(b.storage) : 0;
  return (bytes + 7) / 8 * 8;
}

/// Header of the saved state that `store` writes into the LSI's state. The values that were last set in the FMU follow it, then the FMU's
/// own serialised state.
struct SavedHead {
  enum Kind : std::uint64_t { nothing, bytes, held };  // bytes: serialised behind the header; held: kept inside the FMU
  std::uint64_t kind = nothing;
  std::uint64_t size = 0;   // bytes of the serialised state, or number of the held state
  std::uint64_t owner = 0;  // address of the Running object whose FMU keeps the state
  double until = 0;         // time at which the state was saved, s
  double next_event = 0;    // time of the next scheduled event (Running::next_event_), s
  std::uint64_t given = 0;  // 1: discrete inputs have been set in the FMU
};

/// Object of an LSI: one instance of the FMU. Functions that return std::int32_t return 0, or stop the circuit (circuit::stop) and
/// return 1.
class Running {
 public:
  Running(const FmuClass& c, Setup& setup);
  ~Running();

  /// Creates the FMU's instance. False: the problem was added to `setup`.
  bool start(Setup& setup);
  std::int32_t init(const Call* call);
  std::int32_t advance(const Call* call);
  void store(const Call* call);
  void recall(const Call* call);

 private:
  bool make_unit(std::string& why);  // creates unit_; on failure returns false and writes the reason to `why`
  std::int32_t initialise(const Call* call, double start);
  std::int32_t convert(const Call* call, Group& g);  // copies values from the wires to g.memory
  std::int32_t give(const Call* call, Group& g);     // copies values from g.memory to the FMU
  std::int32_t set_group(const Call* call, Group& g) {
    const std::int32_t bad = convert(call, g);
    return bad ? bad : give(call, g);
  }
  [[nodiscard]] bool has_changed(const Call* call, std::size_t parameter) const;
  std::int32_t set_inputs(const Call* call);
  std::int32_t finish_events(const Call* call, double now);
  std::int32_t set_parameter(const Call* call, const ParameterBinding& b);
  std::int32_t set_parameters(const Call* call);  // sets all parameters that differ from the start values, before initialisation
  std::int32_t set_changed(const Call* call);     // sets tunable parameters that differ from the value that was set last
  std::int32_t get_outputs(const Call* call);
  std::int32_t fail(const Call* call, Status status, const std::string& what);
  [[nodiscard]] const std::string& name_of_input(const PinBinding& b) const { return class_.declaration.lsi_class.inputs[b.pin].name; }
  void drop_held();
  /// Calls visit(address, bytes) for the values that were last set in the FMU (tunable parameters and discrete inputs).
  template <class Visit>
  void visit_given(Visit visit) {
    for (std::size_t i = 0; i < set_.size(); ++i)
      if (class_.declaration.parameters[i].tunable) visit(set_[i].data(), set_[i].size() * sizeof(double));
    for (Group& g : discrete_) visit(g.given.data(), g.size());
  }

  const FmuClass& class_;
  Fmu& fmu_;
  std::string id_;
  bool logging_ = false;
  std::unique_ptr<Unit> unit_;
  std::vector<Group> wired_, given_, outputs_;  // inputs with a wire; inputs without a wire (constant); outputs
  std::vector<Group> discrete_;                 // inputs with a wire that may be set only at events
  std::vector<std::string> texts_;              // [parameters] values of text parameters
  std::vector<std::vector<double>> set_;        // [parameters] values that were last set in the FMU; empty for texts
  std::vector<std::uint64_t> scratch_;          // memory for the values of the largest parameter
  std::map<std::uint64_t, void*> held_;         // states kept inside the FMU, by SavedHead::size
  std::uint64_t next_held_ = 1;
  double next_event_ = std::numeric_limits<double>::infinity();  // time of the event that the FMU has scheduled, s
  bool are_discrete_given_ = false;
  bool initialised_ = false;
  bool dead_ = false;      // after a fatal error no function of the FMU may be called
  bool restarts_ = false;  // the next tick starts the FMU from its initial state, because its state could not be restored
};

Running::Running(const FmuClass& c, Setup& setup) : class_(c), fmu_(*c.fmu), id_(setup.id()) {
  const Declaration& d = c.declaration;
  std::vector<PinBinding> wired, given, discrete;
  const bool has_events = fmu_.description().event_mode;
  for (const PinBinding& b : d.inputs) (setup.wires(b.pin) == 0 ? given : has_events && b.discrete ? discrete : wired).push_back(b);
  wired_ = group(wired);
  discrete_ = group(discrete);
  given_ = group(given);
  outputs_ = group(d.outputs);
  std::size_t largest = 1;
  for (const ParameterBinding& b : d.parameters) {
    texts_.push_back(b.text ? setup.text(b.name) : std::string());
    set_.emplace_back(b.text ? 0 : b.count);
    largest = std::max(largest, b.start.size() * 8);
    largest = std::max<std::size_t>(largest, b.count * 8u);
  }
  scratch_.resize(largest / 8 + 1);
  if (d.logging >= 0) logging_ = setup.boolean("logging");
  ++fmu_.instances;
}

Running::~Running() {
  if (unit_ && dead_) {
    unit_->abandon();
  } else if (unit_) {
    drop_held();
    if (initialised_) unit_->terminate();
  }
  --fmu_.instances;
}

void Running::drop_held() {
  for (auto& [number, state] : held_) unit_->free_state(state);
  held_.clear();
}

bool Running::make_unit(std::string& why) {
  const Result<std::shared_ptr<Code>> code = fmu_.code();
  if (!code) {
    why = code.error().problems[0].message;
    return false;
  }
  unit_ = Unit::make(*code, fmu_.description(), id_, logging_);
  if (unit_->instantiate()) return true;
  why = "The FMU does not start: " + (unit_->last_words().empty() ? std::string("it gives no reason.") : unit_->last_words());
  unit_.reset();
  return false;
}

bool Running::start(Setup& setup) {
  const ModelDescription& d = fmu_.description();
  if (d.only_once_per_process && fmu_.instances > 1) {
    setup.fail(ErrorCode::unsupported,
               "The FMU '" + d.identifier + "' can have only one instance in a process, and another LSI uses it already.",
               "Use it only once, or export it so that it can be instantiated several times.");
    return false;
  }
  const double step = setup.dt();
  if (d.internal_step) {
    const double times = step / *d.internal_step;
    // The relative tolerance of 1e-6 accepts multiples that are inexact in binary, such as 0.1 s / 0.001 s.
    if (!(times > 0.5) || std::fabs(times - std::floor(times + 0.5)) > 1e-6 * times) {
      const std::string what = "The FMU '" + d.identifier + "' computes in steps of " + to_text(*d.internal_step) +
                               " s, but this LSI needs steps of " + to_text(step) + " s, which is not a multiple.";
      if (!d.variable_step) {
        setup.fail(ErrorCode::range, what, "Change the time between ticks, or 'every' of the LSI, so that the step is a multiple.");
        return false;
      }
      post_message("'" + id_ + "': " + what);
    }
  }
  std::string why;
  if (make_unit(why)) return true;
  setup.fail(ErrorCode::structure, why, "Check its parameters, and that all libraries it needs are installed.");
  return false;
}

std::int32_t Running::fail(const Call* call, Status status, const std::string& what) {
  std::string text = what;
  if (status == Status::fatal) {
    dead_ = true;
    text += " (fatal: this instance cannot be used any more)";
  } else if (status == Status::pending) {
    text += ": it computes asynchronously (pending), which is not supported";
  }
  if (!unit_->last_words().empty()) text += ": " + unit_->last_words();
  if (!text.ends_with('.')) text += '.';
  return circuit::stop(call, text);
}

std::int32_t Running::convert(const Call* call, Group& g) {
  std::byte* to = g.bytes();
  for (const PinBinding& b : g.pins) {
    const double* from = circuit::input(call, b.pin);
    for (std::uint32_t k = 0; k < b.count; ++k, to += bytes_of(g.storage))
      if (!write(g.storage, from[k], to))
        return circuit::stop(call, "The input '" + name_of_input(b) + "' has the value " + to_text(from[k]) +
                                       ", which is outside of the range of its type in the FMU.");
  }
  return 0;
}

std::int32_t Running::give(const Call* call, Group& g) {
  const Status status = unit_->set(g.storage, g.references, g.bytes(), g.count);
  if (status <= Status::warning) return 0;
  std::string names;
  for (std::size_t i = 0; i < g.pins.size() && i < 6; ++i) names += (i ? ", '" : "'") + name_of_input(g.pins[i]) + "'";
  return fail(call, status, "The FMU refuses its " + std::string(g.pins.size() == 1 ? "input " : "inputs ") + names);
}

std::int32_t Running::set_parameter(const Call* call, const ParameterBinding& b) {
  const auto index = static_cast<std::size_t>(&b - class_.declaration.parameters.data());
  Status status = Status::ok;
  if (b.text) {
    status = unit_->set_text(b.reference, texts_[index].c_str());
  } else {
    auto* to = reinterpret_cast<std::byte*>(scratch_.data());
    for (std::uint32_t k = 0; k < b.count; ++k) {
      double x = call->parameters[b.first + k];
      if (!b.choices.empty()) x = static_cast<double>(b.choices[static_cast<std::size_t>(x)]);
      if (!write(b.storage, x, to + k * bytes_of(b.storage)))
        return circuit::stop(
            call, "The parameter '" + b.name + "' has the value " + to_text(x) + ", which is outside of the range of its type in the FMU.");
    }
    status = unit_->set(b.storage, {&b.reference, 1}, scratch_.data(), b.count);
  }
  if (status > Status::warning) return fail(call, status, "The FMU refuses its parameter '" + b.name + "'");
  if (!b.text) set_[index].assign(call->parameters + b.first, call->parameters + b.first + b.count);
  return 0;
}

/// Sets the parameters that differ from the FMU's start values.
std::int32_t Running::set_parameters(const Call* call) {
  const std::vector<ParameterBinding>& all = class_.declaration.parameters;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const ParameterBinding& b = all[i];
    const double* now = call->parameters + b.first;
    if (!b.text && std::equal(b.start.begin(), b.start.end(), now, now + b.count)) {
      set_[i].assign(now, now + b.count);
      continue;
    }
    if (b.text &&
        texts_[i] == std::get<std::string>(class_.declaration.lsi_class
                                               .parameters[static_cast<std::size_t>(class_.declaration.lsi_class.find_parameter(b.name))]
                                               .initial))
      continue;
    if (const std::int32_t bad = set_parameter(call, b)) return bad;
  }
  return 0;
}

bool Running::has_changed(const Call* call, std::size_t parameter) const {
  const ParameterBinding& b = class_.declaration.parameters[parameter];
  const double* now = call->parameters + b.first;
  return b.tunable && !b.text && !std::equal(set_[parameter].begin(), set_[parameter].end(), now, now + b.count);
}

std::int32_t Running::set_changed(const Call* call) {
  const std::vector<ParameterBinding>& all = class_.declaration.parameters;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (has_changed(call, i))
      if (const std::int32_t bad = set_parameter(call, all[i])) return bad;
  }
  return 0;
}

std::int32_t Running::finish_events(const Call* call, double now) {
  EventEnd end;
  if (const Status status = unit_->finish_events(end); status > Status::warning)
    return fail(call, status, "The FMU cannot handle its event at " + to_fixed(now, 6) + " s");
  if (end.terminated) return fail(call, Status::ok, "The FMU requests the end of the simulation at " + to_fixed(now, 6) + " s");
  next_event_ = end.next;
  return 0;
}

/// Passes parameters and inputs to the FMU before a step. In event mode, tunable parameters and discrete inputs may be set only at an
/// event; therefore a change of one of them causes an event.
std::int32_t Running::set_inputs(const Call* call) {
  if (unit_->has_events()) {
    bool event = !are_discrete_given_ && !discrete_.empty();
    for (Group& g : discrete_) {
      if (const std::int32_t bad = convert(call, g)) return bad;
      event = event || std::memcmp(g.memory.data(), g.given.data(), g.size()) != 0;
    }
    for (std::size_t i = 0; i < set_.size(); ++i) event = event || has_changed(call, i);
    if (event) {
      if (const Status status = unit_->enter_events(); status > Status::warning) return fail(call, status, "The FMU refuses an event");
      if (const std::int32_t bad = set_changed(call)) return bad;
      for (Group& g : discrete_) {
        if (const std::int32_t bad = give(call, g)) return bad;
        g.given = g.memory;
      }
      are_discrete_given_ = true;
      if (const std::int32_t bad = finish_events(call, call->tick->time)) return bad;
    }
  } else if (const std::int32_t bad = set_changed(call)) {
    return bad;
  }
  for (Group& g : wired_)
    if (const std::int32_t bad = set_group(call, g)) return bad;
  return 0;
}

std::int32_t Running::get_outputs(const Call* call) {
  for (Group& g : outputs_) {
    const Status status = unit_->get(g.storage, g.references, g.bytes(), g.count);
    if (status > Status::warning) return fail(call, status, "The FMU does not return its outputs");
    const std::byte* from = g.bytes();
    for (const PinBinding& b : g.pins) {
      double* to = circuit::output(call, b.pin);
      for (std::uint32_t k = 0; k < b.count; ++k, from += bytes_of(g.storage)) to[k] = read(g.storage, from);
    }
  }
  return 0;
}

std::int32_t Running::initialise(const Call* call, double start) {
  unit_->forget_words();
  if (const std::int32_t bad = set_parameters(call)) return bad;
  if (const Status status = unit_->enter_initialization(start); status > Status::warning)
    return fail(call, status, "The FMU cannot be initialised");
  for (Group& g : given_)
    if (const std::int32_t bad = set_group(call, g)) return bad;
  if (const Status status = unit_->exit_initialization(); status > Status::warning)
    return fail(call, status, "The FMU cannot be initialised");
  initialised_ = true;
  are_discrete_given_ = false;
  if (const std::int32_t bad = finish_events(call, start)) return bad;
  return get_outputs(call);
}

std::int32_t Running::init(const Call* call) {
  if (dead_) return circuit::stop(call, "The FMU had a fatal error before; rebuild the circuit.");
  if (initialised_) {
    drop_held();
    initialised_ = false;
    if (unit_->reset() > Status::warning) {
      std::string why;
      unit_.reset();
      if (!make_unit(why)) return circuit::stop(call, why);
    }
  }
  if (!unit_) return circuit::stop(call, "The FMU cannot be restarted.");
  return initialise(call, 0);
}

std::int32_t Running::advance(const Call* call) {
  if (dead_ || !unit_) return circuit::stop(call, "The FMU had a fatal error before; rebuild the circuit.");
  unit_->forget_words();
  const double now = call->tick->time, size = call->tick->dt;
  if (restarts_) {
    restarts_ = false;
    initialised_ = false;
    if (const Status status = unit_->reset(); status > Status::warning) return fail(call, status, "The FMU cannot be reset");
    if (const std::int32_t bad = initialise(call, now)) return bad;
  }
  if (const std::int32_t bad = set_inputs(call)) return bad;
  const double close = 1e-9 * size;  // s; times that differ by less count as equal, because summed steps have rounding errors
  double at = now;
  // An FMU may return early, and events split the step. After 1000 substeps the FMU is considered stuck.
  for (int substep = 0; substep < 1000; ++substep) {
    StepEnd end;
    const bool to_event = fmu_.description().variable_step && next_event_ > at + close && next_event_ < now + size - close;
    const Status status = unit_->step(at, (to_event ? next_event_ : now + size) - at, end);
    if (end.terminated) return fail(call, Status::ok, "The FMU requests the end of the simulation at " + to_fixed(end.reached, 6) + " s");
    if (status == Status::discard) return fail(call, status, "The FMU cannot compute beyond " + to_fixed(end.reached, 6) + " s");
    if (status > Status::warning) return fail(call, status, "The FMU reports an error in its step");
    const bool event = unit_->has_events() && (end.event || end.reached >= next_event_ - close);
    if (event) {
      if (const Status entered = unit_->enter_events(); entered > Status::warning)
        return fail(call, entered, "The FMU refuses its event at " + to_fixed(end.reached, 6) + " s");
      if (const std::int32_t bad = finish_events(call, end.reached)) return bad;
    }
    if (end.reached >= now + size - close) return get_outputs(call);
    if (!(end.reached > at) && !event) break;
    at = end.reached;
  }
  return fail(call, Status::error, "The FMU does not reach the end of its step");
}

void Running::store(const Call* call) {
  auto* to = static_cast<std::byte*>(call->state);
  SavedHead head;
  head.until = call->tick->time;
  head.next_event = next_event_;
  head.given = are_discrete_given_;
  std::byte* given = to + sizeof head;
  visit_given([&given](void* values, std::size_t size) {
    if (size > 0) std::memcpy(given, values, size);
    given += size;
  });
  const std::size_t first = sizeof head + given_bytes(class_.declaration);
  void* state = nullptr;
  const ModelDescription& d = fmu_.description();
  if (unit_ && !dead_ && initialised_ && !restarts_ && d.saves_state && unit_->get_state(state) <= Status::warning && state) {
    std::size_t size = 0;
    const std::size_t room = fmu_.state_bytes();
    if (room > 0 && unit_->serialized_size(state, size) <= Status::warning && size <= room &&
        unit_->serialize(state, {to + first, size}) <= Status::warning) {
      head.kind = SavedHead::bytes;
      head.size = size;
      unit_->free_state(state);
    } else {
      if (held_.size() >= max_held) {
        unit_->free_state(held_.begin()->second);
        held_.erase(held_.begin());
      }
      head.kind = SavedHead::held;
      head.size = next_held_++;
      head.owner = reinterpret_cast<std::uintptr_t>(this);
      held_[head.size] = state;
    }
  }
  std::memcpy(to, &head, sizeof head);
}

void Running::recall(const Call* call) {
  const auto* from = static_cast<const std::byte*>(call->state);
  SavedHead head;
  std::memcpy(&head, from, sizeof head);
  next_event_ = head.next_event;
  are_discrete_given_ = head.given != 0;
  const std::byte* given = from + sizeof head;
  visit_given([&given](void* values, std::size_t size) {
    if (size > 0) std::memcpy(values, given, size);
    given += size;
  });
  const std::size_t first = sizeof head + given_bytes(class_.declaration);
  restarts_ = false;
  void* state = nullptr;
  bool done = false;
  if (unit_ && !dead_ && initialised_) {
    if (head.kind == SavedHead::bytes && head.size <= fmu_.state_bytes()) {
      done = unit_->deserialize({from + first, head.size}, state) <= Status::warning && state && unit_->set_state(state) <= Status::warning;
      if (state) unit_->free_state(state);
    } else if (head.kind == SavedHead::held && head.owner == reinterpret_cast<std::uintptr_t>(this)) {
      const auto found = held_.find(head.size);
      done = found != held_.end() && unit_->set_state(found->second) <= Status::warning;
    }
  }
  if (done) return;
  restarts_ = true;
  post_message("'" + id_ + "' starts from its initial state: the state of its FMU could not be saved or restored.");
}

// The functions of LsiClass.

const FmuClass& class_of(const Setup& setup) { return *static_cast<const FmuClass*>(setup.lsi_class().abi); }
Running& of(const Call* call) { return *static_cast<Running*>(call->object); }

void configure(Setup& setup) {
  setup.set_state(sizeof(SavedHead) + given_bytes(class_of(setup).declaration) + class_of(setup).fmu->state_bytes());
}

void* make(Setup& setup) {
  auto running = std::make_unique<Running>(class_of(setup), setup);
  return running->start(setup) ? running.release() : nullptr;
}

}  // namespace

void add_functions(circuit::LsiClass& c) {
  c.configure = configure;
  c.make = make;
  c.destroy = [](void* object) { delete static_cast<Running*>(object); };
  c.init = [](const Call* call) { return of(call).init(call); };
  c.advance = [](const Call* call) { return of(call).advance(call); };
  c.store = [](const Call* call) { of(call).store(call); };
  c.recall = [](const Call* call) { of(call).recall(call); };
}

}  // namespace ugoki::fmi
