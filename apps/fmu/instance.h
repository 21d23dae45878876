#pragma once
// One instance as the other tool holds it, and the calls that FMI 2.0 and 3.0 have in common. They give true where they did what they were
// asked for; otherwise the tool's logger was told why.

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

struct Instance {
  std::function<void(const std::string&)> log;  ///< errors, to the other tool
  std::unique_ptr<Session> session;
  Registry<Snapshot> snapshots;
  std::vector<std::string> texts;  ///< given out, valid until the next call
  bool failed = false;

  bool refuse(const std::string& text) const {
    log(text);
    return false;
  }
  /// @param bad what went wrong; empty: nothing
  bool done(const std::string& bad) const { return bad.empty() || refuse(bad); }
  [[nodiscard]] bool in_mode(std::initializer_list<Mode> modes) const;
  bool wrong_time(const char* function) const;
};

[[nodiscard]] Registry<Instance>& instances();

/// Nothing may be thrown into the other tool. @param function in the messages @param work (Instance&) -> Status
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

/// Of one that names its session's folder. @return null where `why`, or what opening the session says, was logged
[[nodiscard]] void* instantiate(std::unique_ptr<Instance> self, const std::string& resources, const char* token, std::string why);

bool set_experiment(Instance& self, double start, bool has_stop, double stop);
bool exit_initialization(void* instance, const char* function);
bool terminate(void* instance, const char* function);
bool reset(void* instance, const char* function);
bool step(void* instance, const char* function, double now, double size);

/// May values be read or written now, and are there as many places as references? Otherwise tells why not.
bool may_get(const Instance& self, const char* function, std::size_t n, const void* references, const void* values);
bool may_set(const Instance& self, const char* function, std::size_t n, const void* references, const void* values);
bool unknown_reference(const Instance& self, const char* function, std::uint32_t reference);
/// The variable of a value reference, if it is of one of these types.
[[nodiscard]] std::optional<std::size_t> find_variable(const Instance& self, std::uint32_t reference,
                                                       std::initializer_list<fmi::InterfaceType> types);
bool get_texts(void* instance, const char* function, const std::uint32_t* references, std::size_t n, const char** values);
bool set_texts(void* instance, const char* function, const std::uint32_t* references, std::size_t n, const char* const* values);

bool get_state(void* instance, const char* function, void** state);
bool set_state(void* instance, const char* function, void* state);
bool free_state(void* instance, const char* function, void** state);
bool size_of_state(void* instance, const char* function, void* state, std::size_t* size);
bool write_state(void* instance, const char* function, void* state, std::span<std::byte> to);
bool read_state(void* instance, const char* function, std::span<const std::byte> from, void** state);

}  // namespace ugoki::fmu
