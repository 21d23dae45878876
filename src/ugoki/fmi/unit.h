#pragma once
// One running instance of an FMU, the same for FMI 2.0 and 3.0: a thin wrap of its functions.

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

/// As both versions number them.
enum class Status : std::uint8_t { ok, warning, discard, error, fatal, pending };

/// How far a step came.
struct StepEnd {
  Status status = Status::ok;
  bool terminated = false;  ///< the FMU wants the simulation to end
  bool event = false;       ///< there is an event at `reached`, to be handled before the next step
  double reached = 0;       ///< s, time up to which it computed
};

/// What the FMU says when its events are handled.
struct EventEnd {
  bool terminated = false;                                ///< it wants the simulation to end
  double next = std::numeric_limits<double>::infinity();  ///< s, time of an event that it knows of
};

class Unit {
 public:
  /// @param name of the instance, for the FMU and for messages
  [[nodiscard]] static std::unique_ptr<Unit> make(std::shared_ptr<Code> code, const ModelDescription& description, std::string name,
                                                  bool logging);
  virtual ~Unit() = default;
  Unit(const Unit&) = delete;
  Unit& operator=(const Unit&) = delete;

  /// False: last_words() may tell why.
  [[nodiscard]] virtual bool instantiate() = 0;
  [[nodiscard]] virtual Status enter_initialization(double start) = 0;
  [[nodiscard]] virtual Status exit_initialization() = 0;
  [[nodiscard]] virtual Status step(double now, double size, StepEnd& end) = 0;
  /// Whether it was made with event mode: after initialisation and after enter_events(), finish_events() leads to the next step;
  /// parameters and discrete inputs are set between the two. Without, there is nothing to do.
  [[nodiscard]] virtual bool has_events() const { return false; }
  [[nodiscard]] virtual Status enter_events() { return Status::ok; }
  [[nodiscard]] virtual Status finish_events(EventEnd&) { return Status::ok; }
  [[nodiscard]] virtual Status reset() = 0;
  virtual void terminate() = 0;
  virtual void free() = 0;
  /// After a fatal error none of its functions may be called, not even to free it.
  virtual void abandon() = 0;

  /// @param values `count` numbers of this storage
  [[nodiscard]] virtual Status set(Storage storage, std::span<const ValueReference> references, const void* values, std::size_t count) = 0;
  [[nodiscard]] virtual Status get(Storage storage, std::span<const ValueReference> references, void* values, std::size_t count) = 0;
  [[nodiscard]] virtual Status set_text(ValueReference reference, const char* text) = 0;

  [[nodiscard]] virtual Status get_state(void*& state) = 0;
  [[nodiscard]] virtual Status set_state(void* state) = 0;
  virtual void free_state(void*& state) = 0;
  [[nodiscard]] virtual Status serialized_size(void* state, std::size_t& bytes) = 0;
  [[nodiscard]] virtual Status serialize(void* state, std::span<std::byte> bytes) = 0;
  [[nodiscard]] virtual Status deserialize(std::span<const std::byte> bytes, void*& state) = 0;

  /// What the FMU reported last of a warning or worse, as a sentence; empty: nothing.
  [[nodiscard]] const std::string& last_words() const { return last_words_; }
  void forget_words() { last_words_.clear(); }

 protected:
  Unit(std::shared_ptr<Code> code, const ModelDescription& description, std::string name, bool logging);
  void note(Status status, const char* category, const std::string& text);

  std::shared_ptr<Code> code_;
  const ModelDescription& description_;
  std::string name_;
  bool logging_;

 private:
  std::string last_words_;
  int noted_ = 0;
};

}  // namespace ugoki::fmi
