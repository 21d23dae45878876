#pragma once
// One running instance of an FMU: a thin wrapper around the FMU's functions, with a common interface for FMI 2.0 and 3.0.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "ugoki/fmi/code.h"
#include "ugoki/fmi/declare.h"

namespace ugoki::fmi {

/// Status that a function of an FMU returns, with the values of the standard (pending: FMI 2.0 only). Values above `warning` are failures.
enum class Status : std::uint8_t { ok, warning, discard, error, fatal, pending };

/// Result of a communication step.
struct StepEnd {
  Status status = Status::ok;
  bool terminated = false;  ///< true: the FMU requests the end of the simulation
  bool event = false;       ///< true: an event occurred at the time `reached` and must be handled before the next step
  double reached = 0;       ///< time up to which the FMU computed, s
};

/// Result of the handling of events.
struct EventEnd {
  bool terminated = false;                                ///< true: the FMU requests the end of the simulation
  double next = std::numeric_limits<double>::infinity();  ///< time of the next event that the FMU has scheduled, s; infinity: none
};

/// An instance. The call order is that of the standard: instantiate, enter_initialization, exit_initialization, then steps, terminate.
class Unit {
 public:
  /// Makes a Unit of the FMU's version; call instantiate() next. @param description must outlive the Unit
  /// @param name name of the instance, for the FMU and for messages @param logging show all log messages, not only warnings and errors
  [[nodiscard]] static std::unique_ptr<Unit> make(std::shared_ptr<Code> code, const ModelDescription& description, std::string name,
                                                  bool logging);
  virtual ~Unit() = default;
  Unit(const Unit&) = delete;
  Unit& operator=(const Unit&) = delete;

  /// Creates the instance in the FMU. @return false if the FMU refuses; last_words() may contain the reason
  [[nodiscard]] virtual bool instantiate() = 0;
  /// @param start start time of the simulation, s
  [[nodiscard]] virtual Status enter_initialization(double start) = 0;
  [[nodiscard]] virtual Status exit_initialization() = 0;
  /// Computes the communication step from `now` to now + size, s. @param end [out] result, also when the step fails
  [[nodiscard]] virtual Status step(double now, double size, StepEnd& end) = 0;
  /// True if the FMU uses event mode (FMI 3.0). Then finish_events() must be called after the initialisation and after enter_events(),
  /// before the next step; tunable parameters and discrete inputs may be set only between enter_events() and finish_events(). Without event
  /// mode both functions do nothing.
  [[nodiscard]] virtual bool has_events() const { return false; }
  [[nodiscard]] virtual Status enter_events() { return Status::ok; }
  [[nodiscard]] virtual Status finish_events(EventEnd&) { return Status::ok; }
  [[nodiscard]] virtual Status reset() = 0;
  virtual void terminate() = 0;
  virtual void free() = 0;
  /// Drops the instance without calling the FMU. Use it after a fatal error, when no function of the FMU may be called, not even to free
  /// the instance.
  virtual void abandon() = 0;

  /// Sets and gets variables of one type. @param values [count] values of the storage type, in the order of the references
  [[nodiscard]] virtual Status set(Storage storage, std::span<const ValueReference> references, const void* values, std::size_t count) = 0;
  [[nodiscard]] virtual Status get(Storage storage, std::span<const ValueReference> references, void* values, std::size_t count) = 0;
  [[nodiscard]] virtual Status set_text(ValueReference reference, const char* text) = 0;

  /// Saves and restores a state inside the FMU. free_state() releases a saved state. serialize() writes a state as bytes.
  [[nodiscard]] virtual Status get_state(void*& state) = 0;
  [[nodiscard]] virtual Status set_state(void* state) = 0;
  virtual void free_state(void*& state) = 0;
  [[nodiscard]] virtual Status serialized_size(void* state, std::size_t& bytes) = 0;
  [[nodiscard]] virtual Status serialize(void* state, std::span<std::byte> bytes) = 0;
  [[nodiscard]] virtual Status deserialize(std::span<const std::byte> bytes, void*& state) = 0;

  /// The last log message with a status other than `ok`; empty: none.
  [[nodiscard]] const std::string& last_words() const { return last_words_; }
  void forget_words() { last_words_.clear(); }

 protected:
  Unit(std::shared_ptr<Code> code, const ModelDescription& description, std::string name, bool logging);
  /// Handles a log message of the FMU: keeps it for last_words() and posts it (messages.h).
  void note(Status status, const char* category, const std::string& text);

  std::shared_ptr<Code> code_;
  const ModelDescription& description_;
  std::string name_;
  bool logging_;

 private:
  std::string last_words_;
  int noted_ = 0;  // number of messages posted so far
};

}  // namespace ugoki::fmi
