#pragma once
// Binary interface of FMI 3.0 co-simulation: those types and functions of the standard that this project uses, with their standard names.
// Source: "Functional Mock-up Interface Specification", version 3.0, chapters 2.2 and 4.2.

#include <cstddef>
#include <cstdint>

extern "C" {

using fmi3Instance = void*;
using fmi3InstanceEnvironment = void*;
using fmi3FMUState = void*;
using fmi3ValueReference = std::uint32_t;
using fmi3Float32 = float;
using fmi3Float64 = double;
using fmi3Int8 = std::int8_t;
using fmi3UInt8 = std::uint8_t;
using fmi3Int16 = std::int16_t;
using fmi3UInt16 = std::uint16_t;
using fmi3Int32 = std::int32_t;
using fmi3UInt32 = std::uint32_t;
using fmi3Int64 = std::int64_t;
using fmi3UInt64 = std::uint64_t;
using fmi3Boolean = bool;
using fmi3String = const char*;
using fmi3Byte = std::uint8_t;
using fmi3Binary = const fmi3Byte*;
using fmi3Clock = bool;

enum fmi3Status { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal };
enum fmi3DependencyKind { fmi3Independent, fmi3Constant, fmi3Fixed, fmi3Tunable, fmi3Discrete, fmi3Dependent };
enum fmi3IntervalQualifier { fmi3IntervalNotYetKnown, fmi3IntervalUnchanged, fmi3IntervalChanged };

using fmi3LogMessageCallback = void (*)(fmi3InstanceEnvironment, fmi3Status, fmi3String category, fmi3String message);
using fmi3IntermediateUpdateCallback = void (*)(fmi3InstanceEnvironment, fmi3Float64 time, fmi3Boolean set_requested,
                                                fmi3Boolean get_allowed, fmi3Boolean step_finished, fmi3Boolean can_return_early,
                                                fmi3Boolean* return_requested, fmi3Float64* return_time);
using fmi3ClockUpdateCallback = void (*)(fmi3InstanceEnvironment);
using fmi3LockPreemptionCallback = void (*)();
using fmi3UnlockPreemptionCallback = void (*)();
}

/// Calls the macro X(name) for each numeric type; the type is fmi3NAME, its functions are fmi3GetNAME and fmi3SetNAME.
#define UGOKI_FMI3_NUMBERS(X) X(Float32) X(Float64) X(Int8) X(UInt8) X(Int16) X(UInt16) X(Int32) X(UInt32) X(Int64) X(UInt64) X(Boolean)

/// Calls the macro X(return type, name without "fmi3", parameters) for each function that an importer of co-simulation needs, except the
/// functions of UGOKI_FMI3_NUMBERS.
#define UGOKI_FMI3_FUNCTIONS(X)                                                                                                           \
  X(const char*, GetVersion, (void))                                                                                                      \
  X(fmi3Instance, InstantiateCoSimulation,                                                                                                \
    (fmi3String, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early, \
     const fmi3ValueReference*, std::size_t, fmi3InstanceEnvironment, fmi3LogMessageCallback, fmi3IntermediateUpdateCallback))            \
  X(void, FreeInstance, (fmi3Instance))                                                                                                   \
  X(fmi3Status, SetDebugLogging, (fmi3Instance, fmi3Boolean, std::size_t, const fmi3String*))                                             \
  X(fmi3Status, EnterInitializationMode,                                                                                                  \
    (fmi3Instance, fmi3Boolean has_tolerance, fmi3Float64 tolerance, fmi3Float64 start, fmi3Boolean has_stop, fmi3Float64 stop))          \
  X(fmi3Status, ExitInitializationMode, (fmi3Instance))                                                                                   \
  X(fmi3Status, Terminate, (fmi3Instance))                                                                                                \
  X(fmi3Status, Reset, (fmi3Instance))                                                                                                    \
  X(fmi3Status, SetString, (fmi3Instance, const fmi3ValueReference*, std::size_t, const fmi3String*, std::size_t))                        \
  X(fmi3Status, DoStep,                                                                                                                   \
    (fmi3Instance, fmi3Float64 now, fmi3Float64 step, fmi3Boolean never_back, fmi3Boolean * event, fmi3Boolean * terminate,               \
     fmi3Boolean * early, fmi3Float64 * last))                                                                                            \
  X(fmi3Status, EnterEventMode, (fmi3Instance))                                                                                           \
  X(fmi3Status, UpdateDiscreteStates,                                                                                                     \
    (fmi3Instance, fmi3Boolean * again, fmi3Boolean * terminate, fmi3Boolean * nominals, fmi3Boolean * states, fmi3Boolean * has_next,    \
     fmi3Float64 * next))                                                                                                                 \
  X(fmi3Status, EnterStepMode, (fmi3Instance))                                                                                            \
  X(fmi3Status, GetFMUState, (fmi3Instance, fmi3FMUState*))                                                                               \
  X(fmi3Status, SetFMUState, (fmi3Instance, fmi3FMUState))                                                                                \
  X(fmi3Status, FreeFMUState, (fmi3Instance, fmi3FMUState*))                                                                              \
  X(fmi3Status, SerializedFMUStateSize, (fmi3Instance, fmi3FMUState, std::size_t*))                                                       \
  X(fmi3Status, SerializeFMUState, (fmi3Instance, fmi3FMUState, fmi3Byte*, std::size_t))                                                  \
  X(fmi3Status, DeserializeFMUState, (fmi3Instance, const fmi3Byte*, std::size_t, fmi3FMUState*))
