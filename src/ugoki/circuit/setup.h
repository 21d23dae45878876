#pragma once
// Argument of `configure` and `make` of an LSI class: the LSI's parameters, the sizes of its pins, and the host's resources.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/circuit/lsi_class.h"
#include "ugoki/circuit/resources.h"

namespace ugoki::circuit {

/// Size and subject of a payload. The subject is the object that the payload describes, for example a character. It is an index whose
/// meaning the LSIs of a library define. Subjects are passed along the wires with the sizes, so that building the circuit refuses a wire
/// from the wrong character.
struct Shape {
  std::uint32_t count = 0;  ///< number of elements; 0: not known yet
  int subject = -1;         ///< index of the subject; -1: no particular subject
  friend bool operator==(const Shape&, const Shape&) = default;
};

class Setup {
 public:
  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] double number(std::string_view parameter) const;
  [[nodiscard]] bool boolean(std::string_view parameter) const;
  [[nodiscard]] const std::string& text(std::string_view parameter) const;  ///< value of a text or choice parameter

  [[nodiscard]] const LsiClass& lsi_class() const { return *class_; }

  /// Number of wires into input `pin` (index in the declaration).
  [[nodiscard]] std::size_t wires(std::size_t pin) const { return inputs_[pin].size(); }
  /// Size of wire `wire` into `pin`; count 0 if the size is not known yet or nothing is wired.
  [[nodiscard]] Shape in(std::size_t pin, std::size_t wire = 0) const { return wire < inputs_[pin].size() ? inputs_[pin][wire] : Shape{}; }
  void set_out(std::size_t pin, std::uint32_t count, int subject = -1);
  void set_state(std::size_t bytes) { state_bytes_ = bytes; }
  [[nodiscard]] double dt() const { return every_ > 1 ? dt_ * every_ : dt_; }  ///< time between two runs of the LSI, s
  [[nodiscard]] std::uint32_t every() const { return every_; }                 ///< the LSI runs at each `every`-th tick; 0: on demand only

  /// Returns the host's object of kind T::resource_kind named `name`. If there is none, reports a problem and returns null.
  template <class T>
  const T* resource(std::string_view name) {
    return static_cast<const T*>(find_resource(T::resource_kind, name));
  }
  /// Reports a problem, so that the circuit is refused. Its location is this LSI: "circuit/lsis/3 'arm'".
  void fail(ErrorCode code, std::string message, std::string remedy);

  // For the code that builds the circuit.
  void set_every(std::uint32_t every) { every_ = every; }
  Setup(std::string id, std::string location, const LsiClass& lsi_class, std::vector<Value> parameters, const Resources* resources,
        double dt, Error& problems);
  void set_in(std::size_t pin, std::vector<Shape> wires) { inputs_[pin] = std::move(wires); }
  [[nodiscard]] const std::vector<Shape>& outputs() const { return outputs_; }
  [[nodiscard]] std::size_t state_bytes() const { return state_bytes_ > class_->state_bytes ? state_bytes_ : class_->state_bytes; }
  /// Gives each output declared with OutputPin::like the size of its input.
  void follow_inputs();
  /// The value of the first text or choice parameter; empty if there is none.
  [[nodiscard]] std::string first_word() const;
  [[nodiscard]] const std::vector<Value>& parameters() const { return parameters_; }
  /// Parameters as numbers, in the layout of Call::parameters: a vector gives 3 numbers, a choice its index, a text none.
  [[nodiscard]] std::vector<double> numbers() const;

 private:
  const void* find_resource(std::string_view kind, std::string_view name);
  [[nodiscard]] const Value& value(std::string_view parameter) const;

  std::string id_, location_;
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

/// Index in Call::parameters of the first number of parameter `index`.
[[nodiscard]] std::size_t parameter_offset(const LsiClass& lsi_class, std::size_t index);

}  // namespace ugoki::circuit
