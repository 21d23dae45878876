#pragma once
// Breakpoints in the running circuit. The conditions are kept when the circuit is replaced.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "ugoki/circuit/interpreter.h"

namespace ugoki::studio {

class CircuitBreakpoints {
 public:
  struct Hit {
    std::string condition;      ///< the condition as the user wrote it
    std::string pin;            ///< name of the output with its path: "arm/elbow.out"
    std::size_t component = 0;  ///< index of the component in the pin's value
    double value = 0;           ///< value of this component after the tick
    std::uint64_t tick = 0;     ///< index of the tick that met the condition, from 0
  };

  /// Replaces all breakpoints. @param conditions texts in the syntax of circuit::read_breakpoint
  void set(std::vector<std::string> conditions);
  /// Sets the circuit that is watched; null: none. The circuit must live until the next attach() or the end of this object.
  void attach(circuit::Interpreter* circuit);
  /// Call after the circuit was reset to its first tick. Installs the breakpoints again. Only a change of a condition from false to true
  /// is a hit; a condition that is already true at the first tick is not.
  void rearm() { install(); }
  /// True if at least one breakpoint refers to an output of the current circuit.
  [[nodiscard]] bool active() const { return !installed_.empty(); }
  /// True if the last tick met a breakpoint.
  [[nodiscard]] bool met() const { return active() && circuit_->breakpoint_hit() >= 0; }
  /// The breakpoint that the last tick met. Requires met().
  [[nodiscard]] Hit hit() const;
  /// Messages about breakpoints that do not fit the current circuit. Each message is returned once.
  [[nodiscard]] std::vector<std::string> take_problems();

 private:
  struct Installed {
    std::string condition;
    circuit::Breakpoint breakpoint;
  };
  void install();

  circuit::Interpreter* circuit_ = nullptr;
  std::vector<std::string> conditions_;
  std::vector<Installed> installed_;
  std::vector<std::string> problems_, reported_;
};

}  // namespace ugoki::studio
