// The functions of FMI 2.0 co-simulation, on top of a Session.

#include "ugoki/fmi/abi2.h"

#include <cmath>
#include <string_view>

#include "instance.h"

namespace ugoki::fmu {
namespace {

using fmi::InterfaceType;

fmi2Status status_of(bool good) { return good ? fmi2OK : fmi2Error; }

/// Like guarded(), for functions that may also return another status, such as fmi2Discard. @param work (Instance&) -> fmi2Status
template <class Work>
fmi2Status guarded2(fmi2Component c, const char* function, Work work) {
  return guarded(c, function, fmi2Error, work);
}
/// Logs why a function is not supported. @return fmi2Error
fmi2Status refused(fmi2Component c, const char* function, const char* why) {
  return guarded2(c, function, [&](Instance& self) { return status_of(self.refuse(why)); });
}
/// Answers a query for a status that is not available. @return fmi2Discard
fmi2Status discarded(fmi2Component c, const char* function) {
  return guarded2(c, function, [](Instance&) { return fmi2Discard; });
}

/// Implements fmi2GetReal, fmi2GetInteger and fmi2GetBoolean. @param types types of the variables that the function reads
template <class T>
fmi2Status get(fmi2Component c, const char* function, std::initializer_list<InterfaceType> types, const fmi2ValueReference* references,
               std::size_t n, T* values) {
  return status_of(guarded(c, function, [&](Instance& self) {
    if (!may_get(self, function, n, references, values)) return false;
    for (std::size_t i = 0; i < n; ++i) {
      const std::optional<std::size_t> variable = find_variable(self, references[i], types);
      if (!variable) return unknown_reference(self, function, references[i]);
      double x = 0;
      const std::size_t element = references[i] - self.session->interface().variables[*variable].reference;
      if (!self.done(self.session->get(*variable, element, {&x, 1}))) return false;
      if constexpr (std::is_integral_v<T>) {
        if (!(std::fabs(x) <= 2147483647.0))
          return self.refuse(std::string(function) + ": the value " + std::to_string(x) + " is outside of the range of Integer.");
      }
      values[i] = static_cast<T>(x);
    }
    return true;
  }));
}

/// Implements fmi2SetReal, fmi2SetInteger and fmi2SetBoolean. @param truth true: the values are booleans
template <class T>
fmi2Status set(fmi2Component c, const char* function, std::initializer_list<InterfaceType> types, const fmi2ValueReference* references,
               std::size_t n, const T* values, bool truth = false) {
  return status_of(guarded(c, function, [&](Instance& self) {
    if (!may_set(self, function, n, references, values)) return false;
    for (std::size_t i = 0; i < n; ++i) {
      const std::optional<std::size_t> variable = find_variable(self, references[i], types);
      if (!variable) return unknown_reference(self, function, references[i]);
      const double x = truth ? (values[i] != 0 ? 1.0 : 0.0) : static_cast<double>(values[i]);
      const std::size_t element = references[i] - self.session->interface().variables[*variable].reference;
      if (!self.done(self.session->set(*variable, element, {&x, 1}))) return false;
    }
    return true;
  }));
}

/// Path of a URI: "/a b" for "file:///a%20b". Other texts are returned unchanged.
std::string path_of(std::string_view uri) {
  if (!uri.starts_with("file:")) return std::string(uri);
  uri.remove_prefix(5);
  if (uri.starts_with("//")) {
    uri.remove_prefix(2);
    const std::size_t slash = uri.find('/');  // skip the host name between "file://" and the path
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
    self->log = [call = callbacks->logger, environment = callbacks->componentEnvironment, own = std::string(name ? name : "")](
                    const std::string& text) { call(environment, own.c_str(), fmi2Error, "logStatusError", "%s", text.c_str()); };
    std::string why;
    if (!name || !*name)
      why = "The instance has no name.";
    else if (type != fmi2CoSimulation)
      why = "This FMU is for co-simulation only.";
    else if (!guid || !resources)
      why = "The GUID or the location of the resources is missing.";
    return instantiate(std::move(self), resources ? path_of(resources) : std::string(), guid, std::move(why));
  } catch (const std::exception&) {  // out of memory
    return nullptr;
  }
}
UGOKI_FMI_EXPORT void fmi2FreeInstance(fmi2Component c) { instances().remove(c); }
UGOKI_FMI_EXPORT fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean, std::size_t, const fmi2String*) {
  return guarded2(c, "fmi2SetDebugLogging", [](Instance&) { return fmi2OK; });
}

UGOKI_FMI_EXPORT fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean, fmi2Real, fmi2Real start, fmi2Boolean has_stop,
                                                fmi2Real stop) {
  return status_of(guarded(c, "fmi2SetupExperiment", [&](Instance& self) {
    if (!self.in_mode({Mode::instantiated})) return self.wrong_time("fmi2SetupExperiment");
    return set_experiment(self, start, has_stop != 0, stop);
  }));
}
UGOKI_FMI_EXPORT fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
  return status_of(guarded(c, "fmi2EnterInitializationMode", [](Instance& self) {
    if (!self.in_mode({Mode::instantiated})) return self.wrong_time("fmi2EnterInitializationMode");
    return self.done(self.session->enter_initialization());
  }));
}
UGOKI_FMI_EXPORT fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
  return status_of(exit_initialization(c, "fmi2ExitInitializationMode"));
}
UGOKI_FMI_EXPORT fmi2Status fmi2Terminate(fmi2Component c) { return status_of(terminate(c, "fmi2Terminate")); }
UGOKI_FMI_EXPORT fmi2Status fmi2Reset(fmi2Component c) { return status_of(reset(c, "fmi2Reset")); }

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
  return status_of(get_texts(c, "fmi2GetString", r, n, v));
}
UGOKI_FMI_EXPORT fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference* r, std::size_t n, const fmi2String* v) {
  return status_of(set_texts(c, "fmi2SetString", r, n, v));
}

UGOKI_FMI_EXPORT fmi2Status fmi2DoStep(fmi2Component c, fmi2Real now, fmi2Real size, fmi2Boolean) {
  return status_of(step(c, "fmi2DoStep", now, size));
}
UGOKI_FMI_EXPORT fmi2Status fmi2CancelStep(fmi2Component c) {
  return refused(c, "fmi2CancelStep", "fmi2CancelStep is not supported: steps are computed synchronously.");
}
UGOKI_FMI_EXPORT fmi2Status fmi2GetStatus(fmi2Component c, fmi2StatusKind, fmi2Status*) { return discarded(c, "fmi2GetStatus"); }
UGOKI_FMI_EXPORT fmi2Status fmi2GetRealStatus(fmi2Component c, fmi2StatusKind kind, fmi2Real* v) {
  return guarded2(c, "fmi2GetRealStatus", [&](Instance& self) {
    if (kind != fmi2LastSuccessfulTime || !v) return fmi2Discard;
    *v = self.session->now();
    return fmi2OK;
  });
}
UGOKI_FMI_EXPORT fmi2Status fmi2GetIntegerStatus(fmi2Component c, fmi2StatusKind, fmi2Integer*) {
  return discarded(c, "fmi2GetIntegerStatus");
}
UGOKI_FMI_EXPORT fmi2Status fmi2GetBooleanStatus(fmi2Component c, fmi2StatusKind kind, fmi2Boolean* v) {
  return guarded2(c, "fmi2GetBooleanStatus", [&](Instance&) {
    if (kind != fmi2Terminated || !v) return fmi2Discard;
    *v = 0;
    return fmi2OK;
  });
}
UGOKI_FMI_EXPORT fmi2Status fmi2GetStringStatus(fmi2Component c, fmi2StatusKind, fmi2String*) {
  return discarded(c, "fmi2GetStringStatus");
}
UGOKI_FMI_EXPORT fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference*, std::size_t, const fmi2Integer*,
                                                        const fmi2Real*) {
  return refused(c, "fmi2SetRealInputDerivatives", "Derivatives of inputs are not supported.");
}
UGOKI_FMI_EXPORT fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference*, std::size_t, const fmi2Integer*,
                                                         fmi2Real*) {
  return refused(c, "fmi2GetRealOutputDerivatives", "Derivatives of outputs are not supported.");
}
UGOKI_FMI_EXPORT fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference*, std::size_t, const fmi2ValueReference*,
                                                         std::size_t, const fmi2Real*, fmi2Real*) {
  return refused(c, "fmi2GetDirectionalDerivative", "Directional derivatives are not supported.");
}

UGOKI_FMI_EXPORT fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate* state) {
  return status_of(get_state(c, "fmi2GetFMUstate", state));
}
UGOKI_FMI_EXPORT fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
  return status_of(set_state(c, "fmi2SetFMUstate", state));
}
UGOKI_FMI_EXPORT fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate* state) {
  return status_of(free_state(c, "fmi2FreeFMUstate", state));
}
UGOKI_FMI_EXPORT fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, std::size_t* size) {
  return status_of(size_of_state(c, "fmi2SerializedFMUstateSize", state, size));
}
UGOKI_FMI_EXPORT fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte* to, std::size_t size) {
  return status_of(write_state(c, "fmi2SerializeFMUstate", state, {reinterpret_cast<std::byte*>(to), size}));
}
UGOKI_FMI_EXPORT fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte* from, std::size_t size, fmi2FMUstate* state) {
  return status_of(read_state(c, "fmi2DeSerializeFMUstate", {reinterpret_cast<const std::byte*>(from), size}, state));
}
