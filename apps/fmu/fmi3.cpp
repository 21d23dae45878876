// The functions of FMI 3.0 co-simulation around a Session. Those of the other interface types are there and refuse.

#include "ugoki/fmi/abi3.h"

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
  fmi3LogMessageCallback logger = nullptr;
  fmi3InstanceEnvironment environment = nullptr;
  std::unique_ptr<Session> session;
  Registry<Snapshot> snapshots;
  std::vector<std::string> texts;  // given out by GetString, valid until the next call
  bool failed = false;

  void log(fmi3Status status, const std::string& text) const {
    if (logger) logger(environment, status, status == fmi3Warning ? "logStatusWarning" : "logStatusError", text.c_str());
  }
  fmi3Status refuse(const std::string& text) const {
    log(fmi3Error, text);
    return fmi3Error;
  }
};

Registry<Instance>& instances() {
  static Registry<Instance> all;
  return all;
}

/// Nothing may be thrown into the other tool. @param function in the messages
template <class Work>
fmi3Status guarded(fmi3Instance instance, const char* function, Work work) {
  Instance* self = instances().find(instance);
  if (!self) return fmi3Error;
  try {
    return work(*self);
  } catch (const std::exception& e) {
    return self->refuse(std::string(function) + ": " + e.what());
  }
}

fmi3Status done(const Instance& self, const std::string& bad) { return bad.empty() ? fmi3OK : self.refuse(bad); }

fmi3Status unsupported(fmi3Instance instance, const char* function) {
  return guarded(instance, function, [&](Instance& self) { return self.refuse(std::string(function) + " is not supported by this FMU."); });
}

fmi3Status wrong_time(const Instance& self, const char* function) {
  constexpr const char* names[] = {"before the initialization mode", "in the initialization mode", "in step mode", "after its end",
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

/// The variable of a value reference, if it is of one of these types.
std::optional<std::size_t> find(const Instance& self, fmi3ValueReference reference, std::initializer_list<InterfaceType> types) {
  const std::optional<std::size_t> i = self.session->find(reference);
  if (!i || self.session->interface().variables[*i].reference != reference) return std::nullopt;
  for (const InterfaceType t : types)
    if (self.session->interface().variables[*i].type == t) return i;
  return std::nullopt;
}

/// @param what types of variables; none: this FMU has no variable of the function's type
template <class T>
fmi3Status get(fmi3Instance instance, const char* function, std::initializer_list<InterfaceType> types,
               const fmi3ValueReference* references, std::size_t n, T* values, std::size_t count) {
  return guarded(instance, function, [&](Instance& self) {
    if (!in_mode(self, {Mode::initialization, Mode::stepping, Mode::terminated})) return wrong_time(self, function);
    if (n > 0 && (!references || !values)) return self.refuse(std::string(function) + " is given a null pointer.");
    std::size_t at = 0;
    std::vector<double> numbers;
    for (std::size_t i = 0; i < n; ++i) {
      const std::optional<std::size_t> variable = find(self, references[i], types);
      if (!variable)
        return self.refuse(std::string(function) + ": no variable of this type has the value reference " + std::to_string(references[i]) +
                           ".");
      numbers.resize(self.session->interface().variables[*variable].count);
      if (at + numbers.size() > count)
        return self.refuse(std::string(function) + ": there is room for fewer values than the variables have.");
      if (const std::string bad = self.session->get(*variable, 0, numbers); !bad.empty()) return self.refuse(bad);
      for (const double x : numbers) values[at++] = static_cast<T>(x);
    }
    return at == count ? fmi3OK : self.refuse(std::string(function) + ": there is room for more values than the variables have.");
  });
}

template <class T>
fmi3Status set(fmi3Instance instance, const char* function, std::initializer_list<InterfaceType> types,
               const fmi3ValueReference* references, std::size_t n, const T* values, std::size_t count) {
  return guarded(instance, function, [&](Instance& self) {
    if (!in_mode(self, {Mode::instantiated, Mode::initialization, Mode::stepping})) return wrong_time(self, function);
    if (n > 0 && (!references || !values)) return self.refuse(std::string(function) + " is given a null pointer.");
    std::size_t at = 0;
    std::vector<double> numbers;
    for (std::size_t i = 0; i < n; ++i) {
      const std::optional<std::size_t> variable = find(self, references[i], types);
      if (!variable)
        return self.refuse(std::string(function) + ": no variable of this type has the value reference " + std::to_string(references[i]) +
                           ".");
      numbers.resize(self.session->interface().variables[*variable].count);
      if (at + numbers.size() > count) return self.refuse(std::string(function) + ": there are fewer values than the variables have.");
      for (double& x : numbers) x = static_cast<double>(values[at++]);
      if (const std::string bad = self.session->set(*variable, 0, numbers); !bad.empty()) return self.refuse(bad);
    }
    return at == count ? fmi3OK : self.refuse(std::string(function) + ": there are more values than the variables have.");
  });
}

}  // namespace
}  // namespace ugoki::fmu

using namespace ugoki::fmu;
using ugoki::fmi::InterfaceType;

#define UGOKI_FMI_EXPORT extern "C" __attribute__((visibility("default")))

UGOKI_FMI_EXPORT const char* fmi3GetVersion() { return "3.0"; }

UGOKI_FMI_EXPORT fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean, fmi3Boolean,
                                                          fmi3Boolean, fmi3Boolean, const fmi3ValueReference*, std::size_t required,
                                                          fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
                                                          fmi3IntermediateUpdateCallback) {
  try {
    auto self = std::make_unique<Instance>();
    self->logger = logger;
    self->environment = environment;
    std::string why;
    if (!name || !*name)
      why = "The instance has no name.";
    else if (!token || !resources)
      why = "The instantiation token or the path of the resources is missing.";
    else if (required > 0)
      why = "This FMU has no intermediate variables.";
    else
      self->session = Session::open(resources, token, why);
    if (self->session) return instances().add(std::move(self));
    self->log(fmi3Error, why);
  } catch (const std::exception&) {  // memory
  }
  return nullptr;
}
UGOKI_FMI_EXPORT fmi3Instance fmi3InstantiateModelExchange(fmi3String, fmi3String, fmi3String, fmi3Boolean, fmi3Boolean,
                                                           fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger) {
  if (logger) logger(environment, fmi3Error, "logStatusError", "This FMU is for co-simulation only.");
  return nullptr;
}
UGOKI_FMI_EXPORT fmi3Instance fmi3InstantiateScheduledExecution(fmi3String, fmi3String, fmi3String, fmi3Boolean, fmi3Boolean,
                                                                fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
                                                                fmi3ClockUpdateCallback, fmi3LockPreemptionCallback,
                                                                fmi3UnlockPreemptionCallback) {
  if (logger) logger(environment, fmi3Error, "logStatusError", "This FMU is for co-simulation only.");
  return nullptr;
}
UGOKI_FMI_EXPORT void fmi3FreeInstance(fmi3Instance c) { instances().remove(c); }
UGOKI_FMI_EXPORT fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean, std::size_t, const fmi3String*) {
  return guarded(c, "fmi3SetDebugLogging", [](Instance&) { return fmi3OK; });
}

UGOKI_FMI_EXPORT fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean, fmi3Float64, fmi3Float64 start, fmi3Boolean has_stop,
                                                        fmi3Float64 stop) {
  return guarded(c, "fmi3EnterInitializationMode", [&](Instance& self) {
    if (!in_mode(self, {Mode::instantiated})) return wrong_time(self, "fmi3EnterInitializationMode");
    if (!std::isfinite(start) || (has_stop && !(stop >= start))) return self.refuse("The start or stop time is no time.");
    self.session->set_experiment(start, has_stop ? std::optional(stop) : std::nullopt);
    return done(self, self.session->enter_initialization());
  });
}
UGOKI_FMI_EXPORT fmi3Status fmi3ExitInitializationMode(fmi3Instance c) {
  return guarded(c, "fmi3ExitInitializationMode", [](Instance& self) {
    if (!in_mode(self, {Mode::initialization})) return wrong_time(self, "fmi3ExitInitializationMode");
    const fmi3Status status = done(self, self.session->exit_initialization());
    self.failed = status != fmi3OK;
    return status;
  });
}
UGOKI_FMI_EXPORT fmi3Status fmi3EnterStepMode(fmi3Instance c) { return unsupported(c, "fmi3EnterStepMode"); }
UGOKI_FMI_EXPORT fmi3Status fmi3EnterEventMode(fmi3Instance c) { return unsupported(c, "fmi3EnterEventMode"); }
UGOKI_FMI_EXPORT fmi3Status fmi3EnterConfigurationMode(fmi3Instance c) { return unsupported(c, "fmi3EnterConfigurationMode"); }
UGOKI_FMI_EXPORT fmi3Status fmi3ExitConfigurationMode(fmi3Instance c) { return unsupported(c, "fmi3ExitConfigurationMode"); }
UGOKI_FMI_EXPORT fmi3Status fmi3Terminate(fmi3Instance c) {
  return guarded(c, "fmi3Terminate", [](Instance& self) {
    if (!in_mode(self, {Mode::stepping})) return wrong_time(self, "fmi3Terminate");
    return done(self, self.session->terminate());
  });
}
UGOKI_FMI_EXPORT fmi3Status fmi3Reset(fmi3Instance c) {
  return guarded(c, "fmi3Reset", [](Instance& self) {
    self.failed = false;
    return done(self, self.session->reset());
  });
}

#define UGOKI_FMI_ACCESS(type, ...)                                                                                                     \
  UGOKI_FMI_EXPORT fmi3Status fmi3Get##type(fmi3Instance c, const fmi3ValueReference* r, std::size_t n, fmi3##type* v, std::size_t m) { \
    return get(c, "fmi3Get" #type, {__VA_ARGS__}, r, n, v, m);                                                                          \
  }                                                                                                                                     \
  UGOKI_FMI_EXPORT fmi3Status fmi3Set##type(fmi3Instance c, const fmi3ValueReference* r, std::size_t n, const fmi3##type* v,            \
                                            std::size_t m) {                                                                            \
    return set(c, "fmi3Set" #type, {__VA_ARGS__}, r, n, v, m);                                                                          \
  }
UGOKI_FMI_ACCESS(Float64, InterfaceType::real)
UGOKI_FMI_ACCESS(Int64, InterfaceType::whole, InterfaceType::choice)
UGOKI_FMI_ACCESS(Boolean, InterfaceType::boolean)
UGOKI_FMI_ACCESS(Float32)
UGOKI_FMI_ACCESS(Int8)
UGOKI_FMI_ACCESS(UInt8)
UGOKI_FMI_ACCESS(Int16)
UGOKI_FMI_ACCESS(UInt16)
UGOKI_FMI_ACCESS(Int32)
UGOKI_FMI_ACCESS(UInt32)
UGOKI_FMI_ACCESS(UInt64)

UGOKI_FMI_EXPORT fmi3Status fmi3GetString(fmi3Instance c, const fmi3ValueReference* r, std::size_t n, fmi3String* v, std::size_t m) {
  return guarded(c, "fmi3GetString", [&](Instance& self) {
    if (!in_mode(self, {Mode::initialization, Mode::stepping, Mode::terminated})) return wrong_time(self, "fmi3GetString");
    if (n != m || (n > 0 && (!r || !v))) return self.refuse("fmi3GetString is given a null pointer, or room for another number of texts.");
    self.texts.assign(n, {});
    for (std::size_t i = 0; i < n; ++i) {
      const std::optional<std::size_t> variable = find(self, r[i], {InterfaceType::text});
      if (!variable) return self.refuse("fmi3GetString: no text has the value reference " + std::to_string(r[i]) + ".");
      self.texts[i] = self.session->text(*variable);
      v[i] = self.texts[i].c_str();
    }
    return fmi3OK;
  });
}
UGOKI_FMI_EXPORT fmi3Status fmi3SetString(fmi3Instance c, const fmi3ValueReference* r, std::size_t n, const fmi3String* v, std::size_t m) {
  return guarded(c, "fmi3SetString", [&](Instance& self) {
    if (!in_mode(self, {Mode::instantiated, Mode::initialization, Mode::stepping})) return wrong_time(self, "fmi3SetString");
    if (n != m || (n > 0 && (!r || !v))) return self.refuse("fmi3SetString is given a null pointer, or another number of texts.");
    for (std::size_t i = 0; i < n; ++i) {
      const std::optional<std::size_t> variable = find(self, r[i], {InterfaceType::text});
      if (!variable || !v[i]) return self.refuse("fmi3SetString: no text has the value reference " + std::to_string(r[i]) + ".");
      if (const std::string bad = self.session->set_text(*variable, v[i]); !bad.empty()) return self.refuse(bad);
    }
    return fmi3OK;
  });
}
UGOKI_FMI_EXPORT fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference*, std::size_t n, std::size_t*, fmi3Binary*,
                                          std::size_t) {
  return n == 0 ? guarded(c, "fmi3GetBinary", [](Instance&) { return fmi3OK; }) : unsupported(c, "fmi3GetBinary");
}
UGOKI_FMI_EXPORT fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference*, std::size_t n, const std::size_t*, const fmi3Binary*,
                                          std::size_t) {
  return n == 0 ? guarded(c, "fmi3SetBinary", [](Instance&) { return fmi3OK; }) : unsupported(c, "fmi3SetBinary");
}
UGOKI_FMI_EXPORT fmi3Status fmi3GetClock(fmi3Instance c, const fmi3ValueReference*, std::size_t, fmi3Clock*) {
  return unsupported(c, "fmi3GetClock");
}
UGOKI_FMI_EXPORT fmi3Status fmi3SetClock(fmi3Instance c, const fmi3ValueReference*, std::size_t, const fmi3Clock*) {
  return unsupported(c, "fmi3SetClock");
}

UGOKI_FMI_EXPORT fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 now, fmi3Float64 size, fmi3Boolean, fmi3Boolean* event,
                                       fmi3Boolean* terminate, fmi3Boolean* early, fmi3Float64* last) {
  return guarded(c, "fmi3DoStep", [&](Instance& self) {
    if (!in_mode(self, {Mode::stepping})) return wrong_time(self, "fmi3DoStep");
    const fmi3Status status = done(self, self.session->step(now, size));
    self.failed = self.session->is_broken();
    for (fmi3Boolean* flag : {event, terminate, early})
      if (flag) *flag = false;
    if (last) *last = self.session->now();
    return status;
  });
}

UGOKI_FMI_EXPORT fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState* state) {
  return guarded(c, "fmi3GetFMUState", [&](Instance& self) {
    if (!state || self.failed) return self.refuse("fmi3GetFMUState may not be called now.");
    auto copy = std::make_unique<Snapshot>();
    if (const std::string bad = self.session->save(*copy); !bad.empty()) return self.refuse(bad);
    if (Snapshot* known = *state ? self.snapshots.find(*state) : nullptr)
      *known = std::move(*copy);
    else
      *state = self.snapshots.add(std::move(copy));
    return fmi3OK;
  });
}
UGOKI_FMI_EXPORT fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) {
  return guarded(c, "fmi3SetFMUState", [&](Instance& self) {
    const Snapshot* known = self.snapshots.find(state);
    if (!known) return self.refuse("This is no saved state of this instance.");
    const fmi3Status status = done(self, self.session->load(*known));
    self.failed = status != fmi3OK;
    return status;
  });
}
UGOKI_FMI_EXPORT fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState* state) {
  return guarded(c, "fmi3FreeFMUState", [&](Instance& self) {
    if (!state || !*state) return fmi3OK;
    if (!self.snapshots.find(*state)) return self.refuse("This is no saved state of this instance.");
    self.snapshots.remove(*state);
    *state = nullptr;
    return fmi3OK;
  });
}
UGOKI_FMI_EXPORT fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, std::size_t* size) {
  return guarded(c, "fmi3SerializedFMUStateSize", [&](Instance& self) {
    const Snapshot* known = self.snapshots.find(state);
    if (!known || !size) return self.refuse("This is no saved state of this instance.");
    *size = known->to_bytes().size();
    return fmi3OK;
  });
}
UGOKI_FMI_EXPORT fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte* to, std::size_t size) {
  return guarded(c, "fmi3SerializeFMUState", [&](Instance& self) {
    const Snapshot* known = self.snapshots.find(state);
    if (!known || !to) return self.refuse("This is no saved state of this instance.");
    const std::vector<std::byte> bytes = known->to_bytes();
    if (size < bytes.size()) return self.refuse("The room for the saved state is too small.");
    std::memcpy(to, bytes.data(), bytes.size());
    return fmi3OK;
  });
}
UGOKI_FMI_EXPORT fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte* from, std::size_t size, fmi3FMUState* state) {
  return guarded(c, "fmi3DeserializeFMUState", [&](Instance& self) {
    auto copy = std::make_unique<Snapshot>();
    if (!from || !state || !copy->from_bytes({reinterpret_cast<const std::byte*>(from), size}, self.session->interface().variables.size()))
      return self.refuse("These bytes are no saved state of this FMU.");
    *state = self.snapshots.add(std::move(copy));
    return fmi3OK;
  });
}

// What co-simulation of this FMU does not have, and the other interface types.

UGOKI_FMI_EXPORT fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance c, fmi3ValueReference, std::size_t*) {
  return unsupported(c, "fmi3GetNumberOfVariableDependencies");
}
UGOKI_FMI_EXPORT fmi3Status fmi3GetVariableDependencies(fmi3Instance c, fmi3ValueReference, std::size_t*, fmi3ValueReference*, std::size_t*,
                                                        fmi3DependencyKind*, std::size_t) {
  return unsupported(c, "fmi3GetVariableDependencies");
}
UGOKI_FMI_EXPORT fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference*, std::size_t, const fmi3ValueReference*,
                                                         std::size_t, const fmi3Float64*, std::size_t, fmi3Float64*, std::size_t) {
  return unsupported(c, "fmi3GetDirectionalDerivative");
}
UGOKI_FMI_EXPORT fmi3Status fmi3GetAdjointDerivative(fmi3Instance c, const fmi3ValueReference*, std::size_t, const fmi3ValueReference*,
                                                     std::size_t, const fmi3Float64*, std::size_t, fmi3Float64*, std::size_t) {
  return unsupported(c, "fmi3GetAdjointDerivative");
}
UGOKI_FMI_EXPORT fmi3Status fmi3GetOutputDerivatives(fmi3Instance c, const fmi3ValueReference*, std::size_t, const fmi3Int32*, fmi3Float64*,
                                                     std::size_t) {
  return unsupported(c, "fmi3GetOutputDerivatives");
}
UGOKI_FMI_EXPORT fmi3Status fmi3GetIntervalDecimal(fmi3Instance c, const fmi3ValueReference*, std::size_t, fmi3Float64*,
                                                   fmi3IntervalQualifier*) {
  return unsupported(c, "fmi3GetIntervalDecimal");
}
UGOKI_FMI_EXPORT fmi3Status fmi3GetIntervalFraction(fmi3Instance c, const fmi3ValueReference*, std::size_t, fmi3UInt64*, fmi3UInt64*,
                                                    fmi3IntervalQualifier*) {
  return unsupported(c, "fmi3GetIntervalFraction");
}
UGOKI_FMI_EXPORT fmi3Status fmi3GetShiftDecimal(fmi3Instance c, const fmi3ValueReference*, std::size_t, fmi3Float64*) {
  return unsupported(c, "fmi3GetShiftDecimal");
}
UGOKI_FMI_EXPORT fmi3Status fmi3GetShiftFraction(fmi3Instance c, const fmi3ValueReference*, std::size_t, fmi3UInt64*, fmi3UInt64*) {
  return unsupported(c, "fmi3GetShiftFraction");
}
UGOKI_FMI_EXPORT fmi3Status fmi3SetIntervalDecimal(fmi3Instance c, const fmi3ValueReference*, std::size_t, const fmi3Float64*) {
  return unsupported(c, "fmi3SetIntervalDecimal");
}
UGOKI_FMI_EXPORT fmi3Status fmi3SetIntervalFraction(fmi3Instance c, const fmi3ValueReference*, std::size_t, const fmi3UInt64*,
                                                    const fmi3UInt64*) {
  return unsupported(c, "fmi3SetIntervalFraction");
}
UGOKI_FMI_EXPORT fmi3Status fmi3SetShiftDecimal(fmi3Instance c, const fmi3ValueReference*, std::size_t, const fmi3Float64*) {
  return unsupported(c, "fmi3SetShiftDecimal");
}
UGOKI_FMI_EXPORT fmi3Status fmi3SetShiftFraction(fmi3Instance c, const fmi3ValueReference*, std::size_t, const fmi3UInt64*,
                                                 const fmi3UInt64*) {
  return unsupported(c, "fmi3SetShiftFraction");
}
UGOKI_FMI_EXPORT fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance c) { return unsupported(c, "fmi3EvaluateDiscreteStates"); }
UGOKI_FMI_EXPORT fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean*, fmi3Boolean*, fmi3Boolean*, fmi3Boolean*, fmi3Boolean*,
                                                     fmi3Float64*) {
  return unsupported(c, "fmi3UpdateDiscreteStates");
}
UGOKI_FMI_EXPORT fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance c) { return unsupported(c, "fmi3EnterContinuousTimeMode"); }
UGOKI_FMI_EXPORT fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean, fmi3Boolean*, fmi3Boolean*) {
  return unsupported(c, "fmi3CompletedIntegratorStep");
}
UGOKI_FMI_EXPORT fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64) { return unsupported(c, "fmi3SetTime"); }
UGOKI_FMI_EXPORT fmi3Status fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64*, std::size_t) {
  return unsupported(c, "fmi3SetContinuousStates");
}
UGOKI_FMI_EXPORT fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64*, std::size_t) {
  return unsupported(c, "fmi3GetContinuousStateDerivatives");
}
UGOKI_FMI_EXPORT fmi3Status fmi3GetEventIndicators(fmi3Instance c, fmi3Float64*, std::size_t) {
  return unsupported(c, "fmi3GetEventIndicators");
}
UGOKI_FMI_EXPORT fmi3Status fmi3GetContinuousStates(fmi3Instance c, fmi3Float64*, std::size_t) {
  return unsupported(c, "fmi3GetContinuousStates");
}
UGOKI_FMI_EXPORT fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance c, fmi3Float64*, std::size_t) {
  return unsupported(c, "fmi3GetNominalsOfContinuousStates");
}
UGOKI_FMI_EXPORT fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, std::size_t*) {
  return unsupported(c, "fmi3GetNumberOfEventIndicators");
}
UGOKI_FMI_EXPORT fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, std::size_t*) {
  return unsupported(c, "fmi3GetNumberOfContinuousStates");
}
UGOKI_FMI_EXPORT fmi3Status fmi3ActivateModelPartition(fmi3Instance c, fmi3ValueReference, fmi3Float64) {
  return unsupported(c, "fmi3ActivateModelPartition");
}
