#pragma once
// One instance of the FMU in the importing tool, and the functions that FMI 2.0 and 3.0 have in common. Functions with a bool result return
// true on success; on failure they have logged the reason to the tool's logger. `function` is the name of the FMI function, for messages.

#include <cstddef>
#include <exception>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "registry.h"
#include "session.h"

namespace ugoki::fmu {

/// An instance of the FMU. The importing tool uses its address as a handle.
struct Instance {
  std::function<void(const std::string&)> log;  ///< logs an error in the importing tool
  std::unique_ptr<Session> session;
  Registry<Snapshot> snapshots;
  std::vector<std::string> texts;  ///< strings returned by the last GetString; valid until the next one
  bool failed = false;             ///< an error occurred: only reset, restoring a state and freeing are allowed

  /// Logs a message. @return false
  bool refuse(const std::string& text) const {
    log(text);
    return false;
  }
  /// @param bad error message, which is logged; empty: success @return true on success
  bool done(const std::string& bad) const { return bad.empty() || refuse(bad); }
  /// True if the session is in one of these modes and has not failed.
  [[nodiscard]] bool in_mode(std::initializer_list<Mode> modes) const;
  /// Logs that the function may not be called in the current mode. @return false
  bool wrong_time(const char* function) const;
};

/// Registry of all FMU instances of this process.
[[nodiscard]] Registry<Instance>& instances();

/// Calls work(Instance&) -> Status and catches its exceptions, because none may reach the importing tool.
/// @param error result if `instance` is unknown or an exception was thrown
template <class Status, class Work>
Status guarded(const void* instance, const char* function, Status error, Work work) {
  Instance* self = instances().find(instance);
  if (!self) return error;
  try {
    return work(*self);
  } catch (const std::exception& e) {
    self->refuse(std::string(function) + ": " + e.what());
    return error;
  }
}
template <class Work>
bool guarded(const void* instance, const char* function, Work work) {
  return guarded(instance, function, false, work);
}

/// Opens the session of a new instance and registers it. @param resources folder of the FMU's resources
/// @param why an error of the arguments, which is logged; empty: none @return handle of the instance; null after an error, which was logged
[[nodiscard]] void* instantiate(std::unique_ptr<Instance> self, const std::string& resources, const char* token, std::string why);

/// Sets the start time and, if has_stop is true, the stop time of the simulation, s.
bool set_experiment(Instance& self, double start, bool has_stop, double stop);
bool exit_initialization(void* instance, const char* function);
bool terminate(void* instance, const char* function);
bool reset(void* instance, const char* function);
/// Computes the communication step from `now` to now + size, s.
bool step(void* instance, const char* function, double now, double size);

/// True if values may be read (written) in the current mode and the pointers are valid for n values; otherwise logs why not.
bool may_get(const Instance& self, const char* function, std::size_t n, const void* references, const void* values);
bool may_set(const Instance& self, const char* function, std::size_t n, const void* references, const void* values);
/// Logs that no variable of the function's type has this value reference. @return false
bool unknown_reference(const Instance& self, const char* function, std::uint32_t reference);
/// Index of the variable that contains this value reference and has one of these types; otherwise none.
[[nodiscard]] std::optional<std::size_t> find_variable(const Instance& self, std::uint32_t reference,
                                                       std::initializer_list<fmi::InterfaceType> types);
bool get_texts(void* instance, const char* function, const std::uint32_t* references, std::size_t n, const char** values);
bool set_texts(void* instance, const char* function, const std::uint32_t* references, std::size_t n, const char* const* values);

// Saved states, as "Getting and Setting the Complete FMU State" of the standards. `state` is the handle of a Snapshot of this instance.
bool get_state(void* instance, const char* function, void** state);
bool set_state(void* instance, const char* function, void* state);
bool free_state(void* instance, const char* function, void** state);
bool size_of_state(void* instance, const char* function, void* state, std::size_t* size);
bool write_state(void* instance, const char* function, void* state, std::span<std::byte> to);
bool read_state(void* instance, const char* function, std::span<const std::byte> from, void** state);

}  // namespace ugoki::fmu
