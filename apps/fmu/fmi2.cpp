// The functions of FMI 2.0 co-simulation around a Session.

#include "ugoki/fmi/abi2.h"

#include <cmath>
#include <cstring>
#include <exception>
#include <optional>

#include "registry.h"
#include "session.h"

namespace ugoki::fmu {
namespace {

using fmi::InterfaceType;
using fmi::InterfaceVariable;

struct Instance {
  std::string name;
  fmi2CallbackLogger logger = nullptr;
  fmi2ComponentEnvironment environment = nullptr;
  std::unique_ptr<Session> session;
  Registry<Snapshot> snapshots;
  std::vector<std::string> texts;  // given out by GetString, valid until the next call
  bool failed = false;

  void log(fmi2Status status, const std::string& text) const {
    if (logger)
      logger(environment, name.c_str(), status, status == fmi2Warning ? "logStatusWarning" : "logStatusError", "%s", text.c_str());
  }
  fmi2Status refuse(const std::string& text) const {
    log(fmi2Error, text);
    return fmi2Error;
  }
};

Registry<Instance>& instances() {
  static Registry<Instance> all;
  return all;
}

/// Nothing may be thrown into the other tool. @param function in the messages
template <class Work>
fmi2Status guarded(fmi2Component component, const char* function, Work work) {
  Instance* self = instances().find(component);
  if (!self) return fmi2Error;
  try {
    return work(*self);
  } catch (const std::exception& e) {
    return self->refuse(std::string(function) + ": " + e.what());
  }
}

fmi2Status done(const Instance& self, const std::string& bad) { return bad.empty() ? fmi2OK : self.refuse(bad); }

fmi2Status wrong_time(const Instance& self, const char* function) {
  constexpr const char* names[] = {"before the initialization mode", "in the initialization mode", "while it steps", "after its end",
                                   "after an error"};
  return self.refuse(std::string(function) + " may not be called " +
                     names[self.failed ? 4u : static_cast<std::size_t>(self.session->mode())] + ".");
}

bool in_mode(const Instance& self, std::initializer_list<Mode> modes) {
  if (self.failed) return false;
  for (const Mode m : modes)
    if (self.session->mode() == m) return true;
  return false;
}

struct Place {
  std::size_t variable = 0, element = 0;
};
/// The variable of a value reference, if it is of one of these types.
std::optional<Place> find(const Instance& self, fmi2ValueReference reference, std::initializer_list<InterfaceType> types) {
  const std::optional<std::size_t> i = self.session->find(reference);
  if (!i) return std::nullopt;
  const InterfaceVariable& v = self.session->interface().variables[*i];
  for (const InterfaceType t : types)
    if (v.type == t) return Place{*i, reference - v.reference};
  return std::nullopt;
}

template <class T>
fmi2Status get(fmi2Component c, const char* function, std::initializer_list<InterfaceType> types, const fmi2ValueReference* references,
               std::size_t n, T* values) {
  return guarded(c, function, [&](Instance& self) {
    if (!in_mode(self, {Mode::initialization, Mode::stepping, Mode::terminated})) return wrong_time(self, function);
    if (n > 0 && (!references || !values)) return self.refuse(std::string(function) + " is given a null pointer.");
    for (std::size_t i = 0; i < n; ++i) {
      const std::optional<Place> place = find(self, references[i], types);
      if (!place)
        return self.refuse(std::string(function) + ": no variable of this type has the value reference " + std::to_string(references[i]) +
                           ".");
      double x = 0;
      if (const std::string bad = self.session->get(place->variable, place->element, {&x, 1}); !bad.empty()) return self.refuse(bad);
      if constexpr (std::is_integral_v<T>) {
        if (!(std::fabs(x) <= 2147483647.0)) return self.refuse(std::string(function) + ": the value is too large for an Integer.");
      }
      values[i] = static_cast<T>(x);
    }
    return fmi2OK;
  });
}

template <class T>
fmi2Status set(fmi2Component c, const char* function, std::initializer_list<InterfaceType> types, const fmi2ValueReference* references,
               std::size_t n, const T* values, bool truth = false) {
  return guarded(c, function, [&](Instance& self) {
    if (!in_mode(self, {Mode::instantiated, Mode::initialization, Mode::stepping})) return wrong_time(self, function);
    if (n > 0 && (!references || !values)) return self.refuse(std::string(function) + " is given a null pointer.");
    for (std::size_t i = 0; i < n; ++i) {
      const std::optional<Place> place = find(self, references[i], types);
      if (!place)
        return self.refuse(std::string(function) + ": no variable of this type has the value reference " + std::to_string(references[i]) +
                           ".");
      const double x = truth ? (values[i] != 0 ? 1.0 : 0.0) : static_cast<double>(values[i]);
      if (const std::string bad = self.session->set(place->variable, place->element, {&x, 1}); !bad.empty()) return self.refuse(bad);
    }
    return fmi2OK;
  });
}

/// "file:///a%20b" as a path; other texts as they are.
std::string path_of(std::string_view uri) {
  if (!uri.starts_with("file:")) return std::string(uri);
  uri.remove_prefix(5);
  if (uri.starts_with("//")) {
    uri.remove_prefix(2);
    const std::size_t slash = uri.find('/');  // after a host, which is this one
    uri.remove_prefix(slash == std::string_view::npos ? uri.size() : slash);
  }
  const auto digit = [](char c) {
    return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
  };
  std::string out;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] == '%' && i + 2 < uri.size() && digit(uri[i + 1]) >= 0 && digit(uri[i + 2]) >= 0) {
      out += static_cast<char>(digit(uri[i + 1]) * 16 + digit(uri[i + 2]));
      i += 2;
    } else {
      out += uri[i];
    }
  }
  return out;
}

constexpr std::initializer_list<InterfaceType> reals{InterfaceType::real}, wholes{InterfaceType::whole, InterfaceType::choice},
    truths{InterfaceType::boolean};

}  // namespace
}  // namespace ugoki::fmu

using namespace ugoki::fmu;

#define UGOKI_FMI_EXPORT extern "C" __attribute__((visibility("default")))

UGOKI_FMI_EXPORT const char* fmi2GetTypesPlatform() { return "default"; }
UGOKI_FMI_EXPORT const char* fmi2GetVersion() { return "2.0"; }

UGOKI_FMI_EXPORT fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                               const fmi2CallbackFunctions* callbacks, fmi2Boolean, fmi2Boolean) {
  if (!callbacks || !callbacks->logger) return nullptr;
  try {
    auto self = std::make_unique<Instance>();
    self->name = name ? name : "";
    self->logger = callbacks->logger;
    self->environment = callbacks->componentEnvironment;
    std::string why;
    if (self->name.empty())
      why = "The instance has no name.";
    else if (type != fmi2CoSimulation)
      why = "This FMU is for co-simulation only.";
    else if (!guid || !resources)
      why = "The GUID or the location of the resources is missing.";
    else
      self->session = Session::open(path_of(resources), guid, why);
    if (self->session) return instances().add(std::move(self));
    self->log(fmi2Error, why);
  } catch (const std::exception&) {  // memory
  }
  return nullptr;
}
UGOKI_FMI_EXPORT void fmi2FreeInstance(fmi2Component c) { instances().remove(c); }
UGOKI_FMI_EXPORT fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean, std::size_t, const fmi2String*) {
  return guarded(c, "fmi2SetDebugLogging", [](Instance&) { return fmi2OK; });
}

UGOKI_FMI_EXPORT fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean, fmi2Real, fmi2Real start, fmi2Boolean has_stop,
                                                fmi2Real stop) {
  return guarded(c, "fmi2SetupExperiment", [&](Instance& self) {
    if (!in_mode(self, {Mode::instantiated})) return wrong_time(self, "fmi2SetupExperiment");
    if (!std::isfinite(start) || (has_stop && !(stop >= start))) return self.refuse("The start or stop time is no time.");
    self.session->set_experiment(start, has_stop ? std::optional(stop) : std::nullopt);
    return fmi2OK;
  });
}
UGOKI_FMI_EXPORT fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
  return guarded(c, "fmi2EnterInitializationMode", [](Instance& self) {
    if (!in_mode(self, {Mode::instantiated})) return wrong_time(self, "fmi2EnterInitializationMode");
    return done(self, self.session->enter_initialization());
  });
}
UGOKI_FMI_EXPORT fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
  return guarded(c, "fmi2ExitInitializationMode", [](Instance& self) {
    if (!in_mode(self, {Mode::initialization})) return wrong_time(self, "fmi2ExitInitializationMode");
    const fmi2Status status = done(self, self.session->exit_initialization());
    self.failed = status != fmi2OK;
    return status;
  });
}
UGOKI_FMI_EXPORT fmi2Status fmi2Terminate(fmi2Component c) {
  return guarded(c, "fmi2Terminate", [](Instance& self) {
    if (!in_mode(self, {Mode::stepping})) return wrong_time(self, "fmi2Terminate");
    return done(self, self.session->terminate());
  });
}
UGOKI_FMI_EXPORT fmi2Status fmi2Reset(fmi2Component c) {
  return guarded(c, "fmi2Reset", [](Instance& self) {
    self.failed = false;
    return done(self, self.session->reset());
  });
}

UGOKI_FMI_EXPORT fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference* r, std::size_t n, fmi2Real* v) {
  return get(c, "fmi2GetReal", reals, r, n, v);
}
UGOKI_FMI_EXPORT fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference* r, std::size_t n, fmi2Integer* v) {
  return get(c, "fmi2GetInteger", wholes, r, n, v);
}
UGOKI_FMI_EXPORT fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference* r, std::size_t n, fmi2Boolean* v) {
  return get(c, "fmi2GetBoolean", truths, r, n, v);
}
UGOKI_FMI_EXPORT fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference* r, std::size_t n, const fmi2Real* v) {
  return set(c, "fmi2SetReal", reals, r, n, v);
}
UGOKI_FMI_EXPORT fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference* r, std::size_t n, const fmi2Integer* v) {
  return set(c, "fmi2SetInteger", wholes, r, n, v);
}
UGOKI_FMI_EXPORT fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference* r, std::size_t n, const fmi2Boolean* v) {
  return set(c, "fmi2SetBoolean", truths, r, n, v, true);
}
UGOKI_FMI_EXPORT fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference* r, std::size_t n, fmi2String* v) {
  return guarded(c, "fmi2GetString", [&](Instance& self) {
    if (!in_mode(self, {Mode::initialization, Mode::stepping, Mode::terminated})) return wrong_time(self, "fmi2GetString");
    if (n > 0 && (!r || !v)) return self.refuse("fmi2GetString is given a null pointer.");
    self.texts.assign(n, {});
    for (std::size_t i = 0; i < n; ++i) {
      const std::optional<Place> place = find(self, r[i], {InterfaceType::text});
      if (!place) return self.refuse("fmi2GetString: no text has the value reference " + std::to_string(r[i]) + ".");
      self.texts[i] = self.session->text(place->variable);
      v[i] = self.texts[i].c_str();
    }
    return fmi2OK;
  });
}
UGOKI_FMI_EXPORT fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference* r, std::size_t n, const fmi2String* v) {
  return guarded(c, "fmi2SetString", [&](Instance& self) {
    if (!in_mode(self, {Mode::instantiated, Mode::initialization, Mode::stepping})) return wrong_time(self, "fmi2SetString");
    if (n > 0 && (!r || !v)) return self.refuse("fmi2SetString is given a null pointer.");
    for (std::size_t i = 0; i < n; ++i) {
      const std::optional<Place> place = find(self, r[i], {InterfaceType::text});
      if (!place || !v[i]) return self.refuse("fmi2SetString: no text has the value reference " + std::to_string(r[i]) + ".");
      if (const std::string bad = self.session->set_text(place->variable, v[i]); !bad.empty()) return self.refuse(bad);
    }
    return fmi2OK;
  });
}

UGOKI_FMI_EXPORT fmi2Status fmi2DoStep(fmi2Component c, fmi2Real now, fmi2Real size, fmi2Boolean) {
  return guarded(c, "fmi2DoStep", [&](Instance& self) {
    if (!in_mode(self, {Mode::stepping})) return wrong_time(self, "fmi2DoStep");
    const fmi2Status status = done(self, self.session->step(now, size));
    self.failed = self.session->is_broken();
    return status;
  });
}
UGOKI_FMI_EXPORT fmi2Status fmi2CancelStep(fmi2Component c) {
  return guarded(c, "fmi2CancelStep", [](Instance& self) { return self.refuse("Steps are done at once; there is nothing to cancel."); });
}
UGOKI_FMI_EXPORT fmi2Status fmi2GetStatus(fmi2Component c, fmi2StatusKind, fmi2Status*) {
  return guarded(c, "fmi2GetStatus", [](Instance&) { return fmi2Discard; });
}
UGOKI_FMI_EXPORT fmi2Status fmi2GetRealStatus(fmi2Component c, fmi2StatusKind kind, fmi2Real* v) {
  return guarded(c, "fmi2GetRealStatus", [&](Instance& self) {
    if (kind != fmi2LastSuccessfulTime || !v) return fmi2Discard;
    *v = self.session->now();
    return fmi2OK;
  });
}
UGOKI_FMI_EXPORT fmi2Status fmi2GetIntegerStatus(fmi2Component c, fmi2StatusKind, fmi2Integer*) {
  return guarded(c, "fmi2GetIntegerStatus", [](Instance&) { return fmi2Discard; });
}
UGOKI_FMI_EXPORT fmi2Status fmi2GetBooleanStatus(fmi2Component c, fmi2StatusKind kind, fmi2Boolean* v) {
  return guarded(c, "fmi2GetBooleanStatus", [&](Instance&) {
    if (kind != fmi2Terminated || !v) return fmi2Discard;
    *v = 0;
    return fmi2OK;
  });
}
UGOKI_FMI_EXPORT fmi2Status fmi2GetStringStatus(fmi2Component c, fmi2StatusKind, fmi2String*) {
  return guarded(c, "fmi2GetStringStatus", [](Instance&) { return fmi2Discard; });
}
UGOKI_FMI_EXPORT fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference*, std::size_t, const fmi2Integer*,
                                                        const fmi2Real*) {
  return guarded(c, "fmi2SetRealInputDerivatives", [](Instance& self) { return self.refuse("Derivatives of inputs are not taken."); });
}
UGOKI_FMI_EXPORT fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference*, std::size_t, const fmi2Integer*,
                                                         fmi2Real*) {
  return guarded(c, "fmi2GetRealOutputDerivatives", [](Instance& self) { return self.refuse("Derivatives of outputs are not given."); });
}
UGOKI_FMI_EXPORT fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference*, std::size_t, const fmi2ValueReference*,
                                                         std::size_t, const fmi2Real*, fmi2Real*) {
  return guarded(c, "fmi2GetDirectionalDerivative", [](Instance& self) { return self.refuse("Directional derivatives are not given."); });
}

UGOKI_FMI_EXPORT fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate* state) {
  return guarded(c, "fmi2GetFMUstate", [&](Instance& self) {
    if (!state || self.failed) return self.refuse("fmi2GetFMUstate may not be called now.");
    auto copy = std::make_unique<Snapshot>();
    if (const std::string bad = self.session->save(*copy); !bad.empty()) return self.refuse(bad);
    if (Snapshot* known = *state ? self.snapshots.find(*state) : nullptr)
      *known = std::move(*copy);
    else
      *state = self.snapshots.add(std::move(copy));
    return fmi2OK;
  });
}
UGOKI_FMI_EXPORT fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
  return guarded(c, "fmi2SetFMUstate", [&](Instance& self) {
    const Snapshot* known = self.snapshots.find(state);
    if (!known) return self.refuse("This is no saved state of this instance.");
    const fmi2Status status = done(self, self.session->load(*known));
    self.failed = status != fmi2OK;
    return status;
  });
}
UGOKI_FMI_EXPORT fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate* state) {
  return guarded(c, "fmi2FreeFMUstate", [&](Instance& self) {
    if (!state || !*state) return fmi2OK;
    if (!self.snapshots.find(*state)) return self.refuse("This is no saved state of this instance.");
    self.snapshots.remove(*state);
    *state = nullptr;
    return fmi2OK;
  });
}
UGOKI_FMI_EXPORT fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, std::size_t* size) {
  return guarded(c, "fmi2SerializedFMUstateSize", [&](Instance& self) {
    const Snapshot* known = self.snapshots.find(state);
    if (!known || !size) return self.refuse("This is no saved state of this instance.");
    *size = known->to_bytes().size();
    return fmi2OK;
  });
}
UGOKI_FMI_EXPORT fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte* to, std::size_t size) {
  return guarded(c, "fmi2SerializeFMUstate", [&](Instance& self) {
    const Snapshot* known = self.snapshots.find(state);
    if (!known || !to) return self.refuse("This is no saved state of this instance.");
    const std::vector<std::byte> bytes = known->to_bytes();
    if (size < bytes.size()) return self.refuse("The room for the saved state is too small.");
    std::memcpy(to, bytes.data(), bytes.size());
    return fmi2OK;
  });
}
UGOKI_FMI_EXPORT fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte* from, std::size_t size, fmi2FMUstate* state) {
  return guarded(c, "fmi2DeSerializeFMUstate", [&](Instance& self) {
    auto copy = std::make_unique<Snapshot>();
    if (!from || !state || !copy->from_bytes({reinterpret_cast<const std::byte*>(from), size}, self.session->interface().variables.size()))
      return self.refuse("These bytes are no saved state of this FMU.");
    *state = self.snapshots.add(std::move(copy));
    return fmi2OK;
  });
}
