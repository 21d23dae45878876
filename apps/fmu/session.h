#pragma once
// One instance of a circuit that runs inside another tool as an FMU: what FMI 2.0 and 3.0 have in common.

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

enum class Mode : std::uint8_t { instantiated, initialization, stepping, terminated, failed };

/// A copy of a session's state.
struct Snapshot {
  Mode mode = Mode::instantiated;
  double start = 0, now = 0;
  std::vector<std::vector<double>> values;  ///< [variables]
  std::vector<std::string> texts;           ///< [variables]
  std::vector<double> seen;
  bool fresh = false;
  std::vector<std::byte> machine;  ///< of the interpreter; empty: not built yet

  [[nodiscard]] std::vector<std::byte> to_bytes() const;
  /// @return false: not of to_bytes, or of another number of variables
  [[nodiscard]] bool from_bytes(std::span<const std::byte> bytes, std::size_t variables);
};

/// The LSIs that this binary has (signals.cpp or content.cpp).
[[nodiscard]] const circuit::Library& packed_library();
/// What they work on. @param bytes of content.ugx; empty: the FMU has none @return null without content, or with a sentence in `why`
[[nodiscard]] std::unique_ptr<circuit::Resources> packed_content(std::string_view bytes, std::string& why);

/// Inputs are held over the ticks of a communication step; outputs are those of the tick at the communication point, computed when somebody
/// asks for them: that tick is then either kept by the next step, or undone because an input has changed.
/// Functions that can fail return a sentence; empty: done.
class Session {
 public:
  /// @param resources folder with circuit.json, run.json and perhaps content.ugx @return null with a sentence in `why`
  [[nodiscard]] static std::unique_ptr<Session> open(const std::string& resources, std::string_view token, std::string& why);

  [[nodiscard]] Mode mode() const { return mode_; }
  [[nodiscard]] double now() const { return now_; }
  [[nodiscard]] const fmi::Interface& interface() const { return interface_; }
  /// The variable that has this value reference among its numbers.
  [[nodiscard]] std::optional<std::size_t> find(std::uint32_t reference) const;
  [[nodiscard]] bool is_broken() const { return running_ && running_->stopped(); }

  void set_experiment(double start, std::optional<double> stop);
  [[nodiscard]] std::string enter_initialization();
  [[nodiscard]] std::string exit_initialization();
  [[nodiscard]] std::string step(double now, double size);
  [[nodiscard]] std::string terminate();
  [[nodiscard]] std::string reset();

  /// Numbers [first, first + values.size()) of a variable.
  [[nodiscard]] std::string get(std::size_t variable, std::size_t first, std::span<double> values);
  [[nodiscard]] std::string set(std::size_t variable, std::size_t first, std::span<const double> values);
  [[nodiscard]] const std::string& text(std::size_t variable) const { return texts_[variable]; }
  [[nodiscard]] std::string set_text(std::size_t variable, std::string text);

  [[nodiscard]] std::string save(Snapshot& out);
  [[nodiscard]] std::string load(const Snapshot& from);

 private:
  Session() = default;
  void to_start();
  [[nodiscard]] std::string may_set(const fmi::InterfaceVariable& v) const;
  [[nodiscard]] std::string build();
  void write_input(std::size_t variable);
  [[nodiscard]] std::string look();
  [[nodiscard]] std::string undo();
  [[nodiscard]] std::string tick(std::uint64_t count);
  [[nodiscard]] std::string stop_words() const;
  [[nodiscard]] std::uint64_t ticks_until(double time, bool& due) const;

  circuit::Circuit circuit_;
  std::unique_ptr<circuit::Resources> content_;
  double dt_ = 0.001;
  fmi::Interface interface_;
  std::vector<std::size_t> seen_at_;  // [variables] where an output's numbers lie in seen_

  Mode mode_ = Mode::instantiated;
  double start_ = 0, now_ = 0;
  std::optional<double> stop_;
  std::vector<std::vector<double>> values_;
  std::vector<std::string> texts_;
  std::optional<circuit::Interpreter> running_;
  std::vector<std::byte> before_;  // state in front of a tick that was computed ahead
  std::vector<double> seen_;       // outputs, as the last tick showed them
  bool ahead_ = false;             // the tick at now_ has been computed
  bool fresh_ = false;             // seen_ is what is to be seen now
  bool refreshes_ = false;         // some outputs are made on demand
};

}  // namespace ugoki::fmu
