#include "instance.h"

#include <algorithm>
#include <cmath>

namespace ugoki::fmu {

using fmi::InterfaceType;

bool Instance::in_mode(std::initializer_list<Mode> modes) const {
  return !failed && std::find(modes.begin(), modes.end(), session->mode()) != modes.end();
}

bool Instance::wrong_time(const char* function) const {
  constexpr const char* names[] = {"before initialization mode", "in initialization mode", "in step mode",
                                   "after the end of the simulation", "after an error"};
  return refuse(std::string(function) + " may not be called " + names[failed ? 4u : static_cast<std::size_t>(session->mode())] + ".");
}

Registry<Instance>& instances() {
  static Registry<Instance> all;
  return all;
}

void* instantiate(std::unique_ptr<Instance> self, const std::string& resources, const char* token, std::string why) {
  if (why.empty()) self->session = Session::open(resources, token, why);
  if (self->session) return instances().add(std::move(self));
  self->log(why);
  return nullptr;
}

bool set_experiment(Instance& self, double start, bool has_stop, double stop) {
  if (!std::isfinite(start) || (has_stop && !(stop >= start)))
    return self.refuse("The start time must be finite, and the stop time not before it.");
  self.session->set_experiment(start, has_stop ? std::optional(stop) : std::nullopt);
  return true;
}

bool exit_initialization(void* instance, const char* function) {
  return guarded(instance, function, [&](Instance& self) {
    if (!self.in_mode({Mode::initialization})) return self.wrong_time(function);
    self.failed = !self.done(self.session->exit_initialization());
    return !self.failed;
  });
}

bool terminate(void* instance, const char* function) {
  return guarded(instance, function, [&](Instance& self) {
    if (!self.in_mode({Mode::stepping})) return self.wrong_time(function);
    return self.done(self.session->terminate());
  });
}

bool reset(void* instance, const char* function) {
  return guarded(instance, function, [](Instance& self) {
    self.failed = false;
    return self.done(self.session->reset());
  });
}

bool step(void* instance, const char* function, double now, double size) {
  return guarded(instance, function, [&](Instance& self) {
    if (!self.in_mode({Mode::stepping})) return self.wrong_time(function);
    const bool good = self.done(self.session->step(now, size));
    self.failed = self.session->is_broken();
    return good;
  });
}

namespace {

bool may_access(const Instance& self, std::initializer_list<Mode> modes, const char* function, std::size_t n, const void* references,
                const void* values) {
  if (!self.in_mode(modes)) return self.wrong_time(function);
  if (n > 0 && (!references || !values)) return self.refuse(std::string(function) + ": an argument is a null pointer.");
  return true;
}

}  // namespace

bool may_get(const Instance& self, const char* function, std::size_t n, const void* references, const void* values) {
  return may_access(self, {Mode::initialization, Mode::stepping, Mode::terminated}, function, n, references, values);
}

bool may_set(const Instance& self, const char* function, std::size_t n, const void* references, const void* values) {
  return may_access(self, {Mode::instantiated, Mode::initialization, Mode::stepping}, function, n, references, values);
}

bool unknown_reference(const Instance& self, const char* function, std::uint32_t reference) {
  return self.refuse(std::string(function) + ": no variable of this type has the value reference " + std::to_string(reference) + ".");
}

std::optional<std::size_t> find_variable(const Instance& self, std::uint32_t reference, std::initializer_list<InterfaceType> types) {
  const std::optional<std::size_t> i = self.session->find(reference);
  if (!i || std::find(types.begin(), types.end(), self.session->interface().variables[*i].type) == types.end()) return std::nullopt;
  return i;
}

bool get_texts(void* instance, const char* function, const std::uint32_t* references, std::size_t n, const char** values) {
  return guarded(instance, function, [&](Instance& self) {
    if (!may_get(self, function, n, references, values)) return false;
    self.texts.assign(n, {});
    for (std::size_t i = 0; i < n; ++i) {
      const std::optional<std::size_t> variable = find_variable(self, references[i], {InterfaceType::text});
      if (!variable) return unknown_reference(self, function, references[i]);
      self.texts[i] = self.session->text(*variable);
      values[i] = self.texts[i].c_str();
    }
    return true;
  });
}

bool set_texts(void* instance, const char* function, const std::uint32_t* references, std::size_t n, const char* const* values) {
  return guarded(instance, function, [&](Instance& self) {
    if (!may_set(self, function, n, references, values)) return false;
    for (std::size_t i = 0; i < n; ++i) {
      const std::optional<std::size_t> variable = find_variable(self, references[i], {InterfaceType::text});
      if (!variable) return unknown_reference(self, function, references[i]);
      if (!values[i]) return self.refuse(std::string(function) + ": a string is a null pointer.");
      if (!self.done(self.session->set_text(*variable, values[i]))) return false;
    }
    return true;
  });
}

bool get_state(void* instance, const char* function, void** state) {
  return guarded(instance, function, [&](Instance& self) {
    if (!state || self.failed) return self.refuse(std::string(function) + " may not be called after an error or with a null pointer.");
    auto copy = std::make_unique<Snapshot>();
    if (!self.done(self.session->save(*copy))) return false;
    if (Snapshot* known = *state ? self.snapshots.find(*state) : nullptr)
      *known = std::move(*copy);
    else
      *state = self.snapshots.add(std::move(copy));
    return true;
  });
}

namespace {

/// Logs that a state handle is unknown. @return false
bool no_state(const Instance& self) { return self.refuse("The handle is not a saved state of this instance."); }

}  // namespace

bool set_state(void* instance, const char* function, void* state) {
  return guarded(instance, function, [&](Instance& self) {
    const Snapshot* known = self.snapshots.find(state);
    if (!known) return no_state(self);
    self.failed = !self.done(self.session->load(*known));
    return !self.failed;
  });
}

bool free_state(void* instance, const char* function, void** state) {
  return guarded(instance, function, [&](Instance& self) {
    if (!state || !*state) return true;
    if (!self.snapshots.find(*state)) return no_state(self);
    self.snapshots.remove(*state);
    *state = nullptr;
    return true;
  });
}

bool size_of_state(void* instance, const char* function, void* state, std::size_t* size) {
  return guarded(instance, function, [&](Instance& self) {
    const Snapshot* known = self.snapshots.find(state);
    if (!known || !size) return no_state(self);
    *size = known->to_bytes().size();
    return true;
  });
}

bool write_state(void* instance, const char* function, void* state, std::span<std::byte> to) {
  return guarded(instance, function, [&](Instance& self) {
    const Snapshot* known = self.snapshots.find(state);
    if (!known || !to.data()) return no_state(self);
    const std::vector<std::byte> bytes = known->to_bytes();
    if (to.size() < bytes.size())
      return self.refuse("The buffer for the saved state has " + std::to_string(to.size()) + " bytes; " + std::to_string(bytes.size()) +
                         " are needed.");
    std::ranges::copy(bytes, to.begin());
    return true;
  });
}

bool read_state(void* instance, const char* function, std::span<const std::byte> from, void** state) {
  return guarded(instance, function, [&](Instance& self) {
    auto copy = std::make_unique<Snapshot>();
    if (!from.data() || !state || !copy->from_bytes(from, self.session->interface().variables.size()))
      return self.refuse("The bytes are not a saved state of this FMU.");
    *state = self.snapshots.add(std::move(copy));
    return true;
  });
}

}  // namespace ugoki::fmu
