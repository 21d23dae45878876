#pragma once
// A circuit that runs inside another tool as an FMU: the state machine of an instance, common to FMI 2.0 and 3.0.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/circuit/interpreter.h"
#include "ugoki/circuit/resources.h"
#include "ugoki/fmi/interface.h"

namespace ugoki::fmu {

/// State of the instance, as in the state machine of the standard.
enum class Mode : std::uint8_t { instantiated, initialization, stepping, terminated, failed };

/// A copy of the state of a Session.
struct Snapshot {
  Mode mode = Mode::instantiated;
  double start = 0, now = 0;                ///< start time and current communication point, s
  std::vector<std::vector<double>> values;  ///< as Session::values_
  std::vector<std::string> texts;           ///< as Session::texts_
  std::vector<double> seen;                 ///< as Session::seen_
  bool fresh = false;                       ///< as Session::fresh_
  std::vector<std::byte> machine;           ///< saved state of the interpreter; empty: not built yet

  [[nodiscard]] std::vector<std::byte> to_bytes() const;
  /// Reads the result of to_bytes. @return false if the bytes are damaged or the number of variables differs
  [[nodiscard]] bool from_bytes(std::span<const std::byte> bytes, std::size_t variables);
};

/// The LSIs in this binary. Defined in signals.cpp or content.cpp.
[[nodiscard]] const circuit::Library& packed_library();
/// The mechanisms and motions that the LSIs use. @param bytes content of the file content.ugx; empty: the FMU has no content
/// @param why [out] error message @return null without content or after an error
[[nodiscard]] std::unique_ptr<circuit::Resources> packed_content(std::string_view bytes, std::string& why);

/// An instance of the circuit. Its ticks have a fixed length; a communication step computes all ticks from its start up to, but not
/// including, its end. Inputs are constant during a step. Outputs are those of the tick at the current communication point. This tick is
/// computed ahead when an output is read for the first time. The next step keeps this tick. If an input changes before the step, the
/// tick is undone (see ahead_). Functions with a string result return an error message; empty: success.
class Session {
 public:
  /// Opens the session of an FMU: reads the circuit from the FMU's resources.
  /// @param resources folder that contains circuit.json, run.json and, if the FMU has content, content.ugx
  /// @param token instantiation token that the simulation tool passed; must equal the token of the FMU in run.json
  /// @param why [out] error message @return null after an error
  [[nodiscard]] static std::unique_ptr<Session> open(const std::string& resources, std::string_view token, std::string& why);

  [[nodiscard]] Mode mode() const { return mode_; }
  [[nodiscard]] double now() const { return now_; }  ///< current communication point, s
  [[nodiscard]] const fmi::Interface& interface() const { return interface_; }
  /// Index of the variable that contains this value reference; an array has one for each element.
  [[nodiscard]] std::optional<std::size_t> find(std::uint32_t reference) const;
  /// True if an LSI has stopped the circuit.
  [[nodiscard]] bool is_broken() const { return running_ && running_->stopped(); }

  void set_experiment(double start, std::optional<double> stop);  ///< start and stop time, s
  [[nodiscard]] std::string enter_initialization();
  [[nodiscard]] std::string exit_initialization();
  [[nodiscard]] std::string step(double now, double size);  ///< computes the step from `now`, which must be now(), to now + size, s
  [[nodiscard]] std::string terminate();
  [[nodiscard]] std::string reset();

  /// Gets or sets the elements [first, first + values.size()) of a variable.
  [[nodiscard]] std::string get(std::size_t variable, std::size_t first, std::span<double> values);
  [[nodiscard]] std::string set(std::size_t variable, std::size_t first, std::span<const double> values);
  [[nodiscard]] const std::string& text(std::size_t variable) const { return texts_[variable]; }
  [[nodiscard]] std::string set_text(std::size_t variable, std::string text);

  [[nodiscard]] std::string save(Snapshot& out);
  [[nodiscard]] std::string load(const Snapshot& from);

 private:
  Session() = default;
  void to_start();  // restores the state that the session had after open()
  [[nodiscard]] std::string may_set(const fmi::InterfaceVariable& v) const;
  [[nodiscard]] std::string build();
  void write_input(std::size_t variable);  // copies the value of an input variable to the interpreter
  [[nodiscard]] std::string update_outputs();
  [[nodiscard]] std::string undo();  // restores the state before the tick that was computed ahead
  [[nodiscard]] std::string tick(std::uint64_t count);
  [[nodiscard]] std::string stop_words() const;
  [[nodiscard]] std::uint64_t ticks_until(double time, bool& due) const;

  circuit::Circuit circuit_;
  std::unique_ptr<circuit::Resources> content_;
  double dt_ = 0.001;
  fmi::Interface interface_;
  std::vector<std::size_t> seen_at_;  // [variables] index into seen_ of the first element of an output

  Mode mode_ = Mode::instantiated;
  double start_ = 0, now_ = 0;
  std::optional<double> stop_;
  std::vector<std::vector<double>> values_;  // [variables] values of inputs and parameters
  std::vector<std::string> texts_;           // [variables] values of text parameters
  std::optional<circuit::Interpreter> running_;
  std::vector<std::byte> before_;  // state of the interpreter before the tick that was computed ahead
  std::vector<double> seen_;       // values of the outputs in the last tick
  bool ahead_ = false;             // true: the tick at now_ has been computed ahead
  bool fresh_ = false;             // true: seen_ contains the outputs at now_ for the current inputs
  bool refreshes_ = false;         // true: some outputs belong to LSIs that run on demand
};

}  // namespace ugoki::fmu
