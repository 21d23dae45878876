#pragma once
// Binary interface of FMI 2.0 co-simulation: those types and functions of the standard that this project uses, with their standard names.
// Source: "Functional Mock-up Interface for Model Exchange and Co-Simulation", version 2.0, chapters 2.1 and 4.2.

#include <cstddef>

extern "C" {

using fmi2Component = void*;
using fmi2ComponentEnvironment = void*;
using fmi2FMUstate = void*;
using fmi2ValueReference = unsigned int;
using fmi2Real = double;
using fmi2Integer = int;
using fmi2Boolean = int;
using fmi2String = const char*;
using fmi2Byte = char;

enum fmi2Status { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending };
enum fmi2Type { fmi2ModelExchange, fmi2CoSimulation };
enum fmi2StatusKind { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated };

using fmi2CallbackLogger = void (*)(fmi2ComponentEnvironment, fmi2String instance, fmi2Status, fmi2String category, fmi2String message,
                                    ...);
using fmi2CallbackAllocateMemory = void* (*)(std::size_t count, std::size_t size);  // the allocated memory is zero, as with calloc
using fmi2CallbackFreeMemory = void (*)(void*);
using fmi2StepFinished = void (*)(fmi2ComponentEnvironment, fmi2Status);

struct fmi2CallbackFunctions {
  fmi2CallbackLogger logger;
  fmi2CallbackAllocateMemory allocateMemory;
  fmi2CallbackFreeMemory freeMemory;
  fmi2StepFinished stepFinished;
  fmi2ComponentEnvironment componentEnvironment;
};
}

/// Calls the macro X(return type, name without "fmi2", parameters) for each function that an importer of co-simulation needs.
#define UGOKI_FMI2_FUNCTIONS(X)                                                                                                            \
  X(const char*, GetVersion, (void))                                                                                                       \
  X(fmi2Component, Instantiate,                                                                                                            \
    (fmi2String, fmi2Type, fmi2String guid, fmi2String resources, const fmi2CallbackFunctions*, fmi2Boolean visible, fmi2Boolean logging)) \
  X(void, FreeInstance, (fmi2Component))                                                                                                   \
  X(fmi2Status, SetDebugLogging, (fmi2Component, fmi2Boolean, std::size_t, const fmi2String*))                                             \
  X(fmi2Status, SetupExperiment,                                                                                                           \
    (fmi2Component, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start, fmi2Boolean has_stop, fmi2Real stop))                   \
  X(fmi2Status, EnterInitializationMode, (fmi2Component))                                                                                  \
  X(fmi2Status, ExitInitializationMode, (fmi2Component))                                                                                   \
  X(fmi2Status, Terminate, (fmi2Component))                                                                                                \
  X(fmi2Status, Reset, (fmi2Component))                                                                                                    \
  X(fmi2Status, GetReal, (fmi2Component, const fmi2ValueReference*, std::size_t, fmi2Real*))                                               \
  X(fmi2Status, GetInteger, (fmi2Component, const fmi2ValueReference*, std::size_t, fmi2Integer*))                                         \
  X(fmi2Status, GetBoolean, (fmi2Component, const fmi2ValueReference*, std::size_t, fmi2Boolean*))                                         \
  X(fmi2Status, SetReal, (fmi2Component, const fmi2ValueReference*, std::size_t, const fmi2Real*))                                         \
  X(fmi2Status, SetInteger, (fmi2Component, const fmi2ValueReference*, std::size_t, const fmi2Integer*))                                   \
  X(fmi2Status, SetBoolean, (fmi2Component, const fmi2ValueReference*, std::size_t, const fmi2Boolean*))                                   \
  X(fmi2Status, SetString, (fmi2Component, const fmi2ValueReference*, std::size_t, const fmi2String*))                                     \
  X(fmi2Status, DoStep, (fmi2Component, fmi2Real now, fmi2Real step, fmi2Boolean never_back))                                              \
  X(fmi2Status, GetRealStatus, (fmi2Component, fmi2StatusKind, fmi2Real*))                                                                 \
  X(fmi2Status, GetBooleanStatus, (fmi2Component, fmi2StatusKind, fmi2Boolean*))                                                           \
  X(fmi2Status, GetFMUstate, (fmi2Component, fmi2FMUstate*))                                                                               \
  X(fmi2Status, SetFMUstate, (fmi2Component, fmi2FMUstate))                                                                                \
  X(fmi2Status, FreeFMUstate, (fmi2Component, fmi2FMUstate*))                                                                              \
  X(fmi2Status, SerializedFMUstateSize, (fmi2Component, fmi2FMUstate, std::size_t*))                                                       \
  X(fmi2Status, SerializeFMUstate, (fmi2Component, fmi2FMUstate, fmi2Byte*, std::size_t))                                                  \
  X(fmi2Status, DeSerializeFMUstate, (fmi2Component, const fmi2Byte*, std::size_t, fmi2FMUstate*))
