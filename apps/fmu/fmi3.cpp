// The functions of FMI 3.0 co-simulation, on top of a Session. The functions for model exchange and scheduled execution only return an
// error; the standard requires that they exist.

#include "ugoki/fmi/abi3.h"

#include "instance.h"

namespace ugoki::fmu {
namespace {

using fmi::InterfaceType;

fmi3Status status_of(bool good) { return good ? fmi3OK : fmi3Error; }

/// Logs that the function is not supported. @return fmi3Error
fmi3Status unsupported(fmi3Instance instance, const char* function) {
  return status_of(
      guarded(instance, function, [&](Instance& self) { return self.refuse(std::string(function) + " is not supported by this FMU."); }));
}
/// Accepts a call that needs no action. @return fmi3OK if the instance exists, otherwise fmi3Error
fmi3Status accepted(fmi3Instance instance, const char* function) {
  return status_of(guarded(instance, function, [](Instance&) { return true; }));
}

/// Index of the variable that has one of these types and whose first value reference is `reference`; otherwise none.
std::optional<std::size_t> find(const Instance& self, fmi3ValueReference reference, std::initializer_list<InterfaceType> types) {
  const std::optional<std::size_t> i = find_variable(self, reference, types);
  return i && self.session->interface().variables[*i].reference == reference ? i : std::nullopt;
}

/// Splits an array of `count` values among the variables. For each variable, calls work(variable, index of its first value in the array,
/// buffer with one number for each element of the variable).
template <class Work>
bool for_variables(Instance& self, const char* function, std::initializer_list<InterfaceType> types,
                   std::span<const fmi3ValueReference> references, std::size_t count, Work work) {
  std::size_t at = 0;
  std::vector<double> numbers;
  for (const fmi3ValueReference reference : references) {
    const std::optional<std::size_t> variable = find(self, reference, types);
    if (!variable) return unknown_reference(self, function, reference);
    numbers.resize(self.session->interface().variables[*variable].count);
    if (at + numbers.size() > count)
      return self.refuse(std::string(function) + ": there are fewer values than the variables have elements.");
    if (!self.done(work(*variable, at, numbers))) return false;
    at += numbers.size();
  }
  return at == count || self.refuse(std::string(function) + ": there are more values than the variables have elements.");
}

/// Implements fmi3Get<Type>. @param types types of the variables that the function reads; empty: no variable of an FMU has them
template <class T>
fmi3Status get(fmi3Instance instance, const char* function, std::initializer_list<InterfaceType> types,
               const fmi3ValueReference* references, std::size_t n, T* values, std::size_t count) {
  return status_of(guarded(instance, function, [&](Instance& self) {
    const auto read = [&](std::size_t variable, std::size_t first, std::span<double> numbers) {
      std::string bad = self.session->get(variable, 0, numbers);
      if (bad.empty())
        for (const double x : numbers) values[first++] = static_cast<T>(x);
      return bad;
    };
    return may_get(self, function, n, references, values) && for_variables(self, function, types, {references, n}, count, read);
  }));
}

/// Implements fmi3Set<Type>. The parameters are those of the function in the standard.
template <class T>
fmi3Status set(fmi3Instance instance, const char* function, std::initializer_list<InterfaceType> types,
               const fmi3ValueReference* references, std::size_t n, const T* values, std::size_t count) {
  return status_of(guarded(instance, function, [&](Instance& self) {
    const auto write = [&](std::size_t variable, std::size_t first, std::span<double> numbers) {
      for (double& x : numbers) x = static_cast<double>(values[first++]);
      return self.session->set(variable, 0, numbers);
    };
    return may_set(self, function, n, references, values) && for_variables(self, function, types, {references, n}, count, write);
  }));
}

/// True if the number of strings m equals the number of value references n; otherwise logs an error.
bool as_many(fmi3Instance instance, const char* function, std::size_t n, std::size_t m) {
  return n == m || guarded(instance, function, [&](Instance& self) {
           return self.refuse(std::string(function) + ": there are " + std::to_string(m) + " values for " + std::to_string(n) +
                              " variables.");
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
    self->log = [logger, environment](const std::string& text) {
      if (logger) logger(environment, fmi3Error, "logStatusError", text.c_str());
    };
    std::string why;
    if (!name || !*name)
      why = "The instance has no name.";
    else if (!token || !resources)
      why = "The instantiation token or the path of the resources is missing.";
    else if (required > 0)
      why = "This FMU has no intermediate variables.";
    return instantiate(std::move(self), resources ? resources : "", token, std::move(why));
  } catch (const std::exception&) {  // out of memory
    return nullptr;
  }
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
  return accepted(c, "fmi3SetDebugLogging");
}

UGOKI_FMI_EXPORT fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean, fmi3Float64, fmi3Float64 start, fmi3Boolean has_stop,
                                                        fmi3Float64 stop) {
  return status_of(guarded(c, "fmi3EnterInitializationMode", [&](Instance& self) {
    if (!self.in_mode({Mode::instantiated})) return self.wrong_time("fmi3EnterInitializationMode");
    return set_experiment(self, start, has_stop, stop) && self.done(self.session->enter_initialization());
  }));
}
UGOKI_FMI_EXPORT fmi3Status fmi3ExitInitializationMode(fmi3Instance c) {
  return status_of(exit_initialization(c, "fmi3ExitInitializationMode"));
}
UGOKI_FMI_EXPORT fmi3Status fmi3EnterStepMode(fmi3Instance c) { return unsupported(c, "fmi3EnterStepMode"); }
UGOKI_FMI_EXPORT fmi3Status fmi3EnterEventMode(fmi3Instance c) { return unsupported(c, "fmi3EnterEventMode"); }
UGOKI_FMI_EXPORT fmi3Status fmi3EnterConfigurationMode(fmi3Instance c) { return unsupported(c, "fmi3EnterConfigurationMode"); }
UGOKI_FMI_EXPORT fmi3Status fmi3ExitConfigurationMode(fmi3Instance c) { return unsupported(c, "fmi3ExitConfigurationMode"); }
UGOKI_FMI_EXPORT fmi3Status fmi3Terminate(fmi3Instance c) { return status_of(terminate(c, "fmi3Terminate")); }
UGOKI_FMI_EXPORT fmi3Status fmi3Reset(fmi3Instance c) { return status_of(reset(c, "fmi3Reset")); }

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
  return status_of(as_many(c, "fmi3GetString", n, m) && get_texts(c, "fmi3GetString", r, n, v));
}
UGOKI_FMI_EXPORT fmi3Status fmi3SetString(fmi3Instance c, const fmi3ValueReference* r, std::size_t n, const fmi3String* v, std::size_t m) {
  return status_of(as_many(c, "fmi3SetString", n, m) && set_texts(c, "fmi3SetString", r, n, v));
}
UGOKI_FMI_EXPORT fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference*, std::size_t n, std::size_t*, fmi3Binary*,
                                          std::size_t) {
  return n == 0 ? accepted(c, "fmi3GetBinary") : unsupported(c, "fmi3GetBinary");
}
UGOKI_FMI_EXPORT fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference*, std::size_t n, const std::size_t*, const fmi3Binary*,
                                          std::size_t) {
  return n == 0 ? accepted(c, "fmi3SetBinary") : unsupported(c, "fmi3SetBinary");
}
UGOKI_FMI_EXPORT fmi3Status fmi3GetClock(fmi3Instance c, const fmi3ValueReference*, std::size_t, fmi3Clock*) {
  return unsupported(c, "fmi3GetClock");
}
UGOKI_FMI_EXPORT fmi3Status fmi3SetClock(fmi3Instance c, const fmi3ValueReference*, std::size_t, const fmi3Clock*) {
  return unsupported(c, "fmi3SetClock");
}

UGOKI_FMI_EXPORT fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 now, fmi3Float64 size, fmi3Boolean, fmi3Boolean* event,
                                       fmi3Boolean* terminate, fmi3Boolean* early, fmi3Float64* last) {
  const bool good = step(c, "fmi3DoStep", now, size);
  for (fmi3Boolean* flag : {event, terminate, early})
    if (flag) *flag = false;
  if (last) (void)guarded(c, "fmi3DoStep", [&](Instance& self) { return (*last = self.session->now(), true); });
  return status_of(good);
}

UGOKI_FMI_EXPORT fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState* state) {
  return status_of(get_state(c, "fmi3GetFMUState", state));
}
UGOKI_FMI_EXPORT fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) {
  return status_of(set_state(c, "fmi3SetFMUState", state));
}
UGOKI_FMI_EXPORT fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState* state) {
  return status_of(free_state(c, "fmi3FreeFMUState", state));
}
UGOKI_FMI_EXPORT fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, std::size_t* size) {
  return status_of(size_of_state(c, "fmi3SerializedFMUStateSize", state, size));
}
UGOKI_FMI_EXPORT fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte* to, std::size_t size) {
  return status_of(write_state(c, "fmi3SerializeFMUState", state, {reinterpret_cast<std::byte*>(to), size}));
}
UGOKI_FMI_EXPORT fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte* from, std::size_t size, fmi3FMUState* state) {
  return status_of(read_state(c, "fmi3DeserializeFMUState", {reinterpret_cast<const std::byte*>(from), size}, state));
}

// Optional functions that this FMU does not support, and functions for model exchange and scheduled execution.

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
