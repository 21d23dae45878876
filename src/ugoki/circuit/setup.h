#pragma once
// What `configure` and `make` of an LSI class are given: its parameters, the sizes around it, the host's resources.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/circuit/lsi_class.h"
#include "ugoki/circuit/resources.h"

namespace ugoki::circuit {

/// Size of a payload and whom it is about. A subject is a number that the LSIs of a library agree on (a character's index);
/// it travels with the sizes, so that a wire from the wrong character is refused when the circuit is built.
struct Shape {
  std::uint32_t count = 0;  ///< elements; 0: not known yet
  int subject = -1;         ///< -1: nobody in particular
  friend bool operator==(const Shape&, const Shape&) = default;
};

class Setup {
 public:
  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] double number(std::string_view parameter) const;
  [[nodiscard]] bool boolean(std::string_view parameter) const;
  [[nodiscard]] const std::string& text(std::string_view parameter) const;  ///< text or choice

  [[nodiscard]] const LsiClass& lsi_class() const { return *class_; }

  /// Number of wires into input `pin` (an index of the declaration).
  [[nodiscard]] std::size_t wires(std::size_t pin) const { return inputs_[pin].size(); }
  /// Size of wire `wire` into `pin`; count 0 where it is not known yet or nothing is wired.
  [[nodiscard]] Shape in(std::size_t pin, std::size_t wire = 0) const { return wire < inputs_[pin].size() ? inputs_[pin][wire] : Shape{}; }
  void set_out(std::size_t pin, std::uint32_t count, int subject = -1);
  void set_state(std::size_t bytes) { state_bytes_ = bytes; }
  [[nodiscard]] double dt() const { return dt_; }               ///< s, between ticks
  [[nodiscard]] std::uint32_t every() const { return every_; }  ///< it runs at each `every`-th tick; 0: on demand

  /// The host's thing of type T named `name`, or null with a problem reported. T::resource_kind names the kind.
  template <class T>
  const T* resource(std::string_view name) {
    return static_cast<const T*>(find_resource(T::resource_kind, name));
  }
  /// Refuses the circuit; the place is this LSI: "circuit/lsis/3 'arm'".
  void fail(ErrorCode code, std::string message, std::string remedy);

  // For the builder.
  void set_every(std::uint32_t every) { every_ = every; }
  Setup(std::string id, std::string place, const LsiClass& lsi_class, std::vector<Value> parameters, const Resources* resources, double dt,
        Error& problems);
  void set_in(std::size_t pin, std::vector<Shape> wires) { inputs_[pin] = std::move(wires); }
  [[nodiscard]] const std::vector<Shape>& outputs() const { return outputs_; }
  [[nodiscard]] std::size_t state_bytes() const { return state_bytes_ > class_->state_bytes ? state_bytes_ : class_->state_bytes; }
  /// Sizes of outputs that are declared to be like an input.
  void follow_inputs();
  /// The first text or choice; empty where there is none.
  [[nodiscard]] std::string first_word() const;
  [[nodiscard]] const std::vector<Value>& parameters() const { return parameters_; }
  /// Parameters as numbers, as Call::parameters holds them.
  [[nodiscard]] std::vector<double> numbers() const;

 private:
  const void* find_resource(std::string_view kind, std::string_view name);
  [[nodiscard]] const Value& value(std::string_view parameter) const;

  std::string id_, place_;
  const LsiClass* class_;
  std::vector<Value> parameters_;
  const Resources* resources_;
  double dt_;
  std::uint32_t every_ = 1;
  Error* problems_;
  std::vector<std::vector<Shape>> inputs_;
  std::vector<Shape> outputs_;
  std::size_t state_bytes_ = 0;
};

/// Offset of parameter `index` in Call::parameters.
[[nodiscard]] std::size_t parameter_offset(const LsiClass& lsi_class, std::size_t index);

}  // namespace ugoki::circuit
