// The functions of an FMU's LSI. Its communication step is the LSI's own tick: what its outputs show during a tick is the state at the
// tick's time; `advance` gives it the inputs of the tick and lets it compute up to the next one.

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

constexpr std::size_t most_held = 256;  // states that are kept of an FMU that saves but does not serialise

/// Bytes of what the FMU was given last (tunable parameters, discrete inputs), in the saved state.
std::size_t given_bytes(const Declaration& d) {
  std::size_t bytes = 0;
  for (const ParameterBinding& b : d.parameters) bytes += b.tunable ? b.count * sizeof(double) : 0;
  for (const PinBinding& b : d.inputs) bytes += b.discrete ? b.count * bytes_of(b.storage) : 0;
  return (bytes + 7) / 8 * 8;
}

/// In front of what `store` writes into the LSI's state. Behind it: what the FMU was given last, then the FMU's own state.
struct SavedHead {
  enum Kind : std::uint64_t { nothing, bytes, held };
  std::uint64_t kind = nothing;
  std::uint64_t size = 0;   // bytes behind this; or number of the held state
  std::uint64_t owner = 0;  // address of the instance that holds it
  double until = 0;         // s
  double next_event = 0;    // s
  std::uint64_t given = 0;  // 1: it was given discrete inputs
};

class Running {
 public:
  Running(const FmuClass& c, Setup& setup);
  ~Running();

  /// False with a problem reported.
  bool start(Setup& setup);
  std::int32_t init(const Call* call);
  std::int32_t advance(const Call* call);
  void store(const Call* call);
  void recall(const Call* call);

 private:
  bool make_unit(std::string& why);
  std::int32_t initialise(const Call* call, double start);
  std::int32_t convert(const Call* call, Group& g);
  std::int32_t give(const Call* call, Group& g);
  std::int32_t set_group(const Call* call, Group& g) {
    const std::int32_t bad = convert(call, g);
    return bad ? bad : give(call, g);
  }
  [[nodiscard]] bool has_changed(const Call* call, std::size_t parameter) const;
  std::int32_t set_inputs(const Call* call);
  std::int32_t finish_events(const Call* call, double now);
  std::int32_t set_parameter(const Call* call, const ParameterBinding& b);
  std::int32_t set_parameters(const Call* call);
  std::int32_t set_changed(const Call* call);
  std::int32_t get_outputs(const Call* call);
  std::int32_t fail(const Call* call, Status status, const std::string& what);
  [[nodiscard]] const std::string& name_of_input(const PinBinding& b) const { return class_.declaration.lsi_class.inputs[b.pin].name; }
  void drop_held();
  /// Calls visit(address, bytes) with what the FMU was given last.
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
  std::uint32_t every_ = 1;
  std::unique_ptr<Unit> unit_;
  std::vector<Group> wired_, given_, outputs_;  // inputs with a wire, inputs with a value, outputs
  std::vector<Group> discrete_;                 // inputs with a wire that may be set at events only
  std::vector<std::string> texts_;              // of text parameters, in the order of bindings
  std::vector<std::vector<double>> set_;        // [bindings] what the FMU has been given last, of numbers
  std::vector<std::uint64_t> scratch_;
  std::map<std::uint64_t, void*> held_;
  std::uint64_t next_held_ = 1;
  double next_event_ = std::numeric_limits<double>::infinity();  // s
  bool are_discrete_given_ = false;
  bool initialised_ = false, dead_ = false, afresh_ = false;
};

Running::Running(const FmuClass& c, Setup& setup) : class_(c), fmu_(*c.fmu), id_(setup.id()), every_(std::max(1u, setup.every())) {
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
  why = "The FMU does not start: " + (unit_->last_words().empty() ? std::string("it does not say why.") : unit_->last_words());
  unit_.reset();
  return false;
}

bool Running::start(Setup& setup) {
  const ModelDescription& d = fmu_.description();
  if (d.only_once_per_process && fmu_.instances > 1) {
    setup.fail(ErrorCode::unsupported, "The FMU '" + d.identifier + "' can be there once only, and another LSI uses it already.",
               "Use it once, or export it so that it can be instantiated several times.");
    return false;
  }
  const double step = setup.dt() * every_;
  if (d.internal_step) {
    const double times = step / *d.internal_step;
    if (!(times > 0.5) || std::fabs(times - std::floor(times + 0.5)) > 1e-6 * times) {
      const std::string what = "The FMU '" + d.identifier + "' computes in steps of " + to_text(*d.internal_step) +
                               " s, and this LSI asks for steps of " + to_text(step) + " s, which is not a multiple.";
      if (!d.variable_step) {
        setup.fail(ErrorCode::range, what, "Choose the time between ticks, or 'every' of the LSI, so that it is one.");
        return false;
      }
      post_message("'" + id_ + "': " + what);
    }
  }
  std::string why;
  if (make_unit(why)) return true;
  setup.fail(ErrorCode::structure, why, "Check its parameters, and that all it needs is installed.");
  return false;
}

std::int32_t Running::fail(const Call* call, Status status, const std::string& what) {
  std::string text = what;
  if (status == Status::fatal) {
    dead_ = true;
    text += ", and it is beyond repair (fatal)";
  } else if (status == Status::pending) {
    text += ": it wants to go on later (pending), which is not supported";
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
        return circuit::stop(
            call, "The input '" + name_of_input(b) + "' cannot hold " + to_text(from[k]) + ", which its type in the FMU does not have.");
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
        return circuit::stop(call,
                             "The parameter '" + b.name + "' cannot hold " + to_text(x) + ", which its type in the FMU does not have.");
    }
    status = unit_->set(b.storage, {&b.reference, 1}, scratch_.data(), b.count);
  }
  if (status > Status::warning) return fail(call, status, "The FMU refuses its parameter '" + b.name + "'");
  if (!b.text) set_[index].assign(call->parameters + b.first, call->parameters + b.first + b.count);
  return 0;
}

/// All that are not what the FMU has by itself.
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
  if (end.terminated) return fail(call, Status::ok, "The FMU asks for the end of the simulation at " + to_fixed(now, 6) + " s");
  next_event_ = end.next;
  return 0;
}

/// Before a step. In event mode parameters and discrete inputs may change at an event only, and a change of theirs is one.
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
    if (status > Status::warning) return fail(call, status, "The FMU does not give its outputs");
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
  if (dead_) return circuit::stop(call, "The FMU had a fatal error before; build the circuit again.");
  if (initialised_) {
    drop_held();
    initialised_ = false;
    if (unit_->reset() > Status::warning) {
      std::string why;
      unit_.reset();
      if (!make_unit(why)) return circuit::stop(call, why);
    }
  }
  if (!unit_) return circuit::stop(call, "The FMU does not start any more.");
  return initialise(call, 0);
}

std::int32_t Running::advance(const Call* call) {
  if (dead_ || !unit_) return circuit::stop(call, "The FMU had a fatal error before.");
  unit_->forget_words();
  const double now = call->tick->time, size = call->tick->dt * every_;
  if (afresh_) {
    afresh_ = false;
    initialised_ = false;
    if (const Status status = unit_->reset(); status > Status::warning) return fail(call, status, "The FMU cannot start afresh");
    if (const std::int32_t bad = initialise(call, now)) return bad;
  }
  if (const std::int32_t bad = set_inputs(call)) return bad;
  const double close = 1e-9 * size;
  double at = now;
  for (int parts = 0; parts < 1000; ++parts) {  // an FMU may return early, and events divide the step
    StepEnd end;
    const bool to_event = fmu_.description().variable_step && next_event_ > at + close && next_event_ < now + size - close;
    const Status status = unit_->step(at, (to_event ? next_event_ : now + size) - at, end);
    if (end.terminated) return fail(call, Status::ok, "The FMU asks for the end of the simulation at " + to_fixed(end.reached, 6) + " s");
    if (status == Status::discard) return fail(call, status, "The FMU cannot compute the step beyond " + to_fixed(end.reached, 6) + " s");
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
  return fail(call, Status::error, "The FMU does not get to the end of its step");
}

void Running::store(const Call* call) {
  auto* to = static_cast<std::byte*>(call->state);
  SavedHead head;
  head.until = call->tick->time;
  head.next_event = next_event_;
  head.given = are_discrete_given_;
  std::byte* given = to + sizeof head;
  visit_given([&given](void* values, std::size_t size) {
    std::memcpy(given, values, size);
    given += size;
  });
  const std::size_t first = sizeof head + given_bytes(class_.declaration);
  void* state = nullptr;
  const ModelDescription& d = fmu_.description();
  if (unit_ && !dead_ && initialised_ && !afresh_ && d.saves_state && unit_->get_state(state) <= Status::warning && state) {
    std::size_t size = 0;
    const std::size_t room = fmu_.state_bytes();
    if (room > 0 && unit_->serialized_size(state, size) <= Status::warning && size <= room &&
        unit_->serialize(state, {to + first, size}) <= Status::warning) {
      head.kind = SavedHead::bytes;
      head.size = size;
      unit_->free_state(state);
    } else {
      if (held_.size() >= most_held) {
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
    std::memcpy(values, given, size);
    given += size;
  });
  const std::size_t first = sizeof head + given_bytes(class_.declaration);
  afresh_ = false;
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
  afresh_ = true;
  post_message("'" + id_ + "' starts afresh: the state of its FMU could not be saved or taken back.");
}

// What the class declares.

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
