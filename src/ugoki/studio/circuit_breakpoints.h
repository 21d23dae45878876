#pragma once
// Breakpoints in the circuit that runs: kept while circuits come and go.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "ugoki/circuit/interpreter.h"

namespace ugoki::studio {

class CircuitBreakpoints {
 public:
  struct Hit {
    std::string condition;  ///< as it was set
    std::string pin;
    std::size_t component = 0;
    double value = 0;
    std::uint64_t tick = 0;  ///< that met it, from 0
  };

  /// Replaces all. @param conditions as circuit::read_breakpoint takes them
  void set(std::vector<std::string> conditions);
  /// Another circuit runs from now on; null: none. It must outlive this, or the next attach.
  void attach(circuit::Interpreter* circuit);
  /// The circuit is at its beginning again: what is true there has not become so.
  void begin() { place(); }
  /// True if the circuit has an output that one of them looks at.
  [[nodiscard]] bool active() const { return !placed_.empty(); }
  /// True if the last tick met one of them.
  [[nodiscard]] bool met() const { return active() && circuit_->breakpoint_hit() >= 0; }
  /// What the last tick met; only where met().
  [[nodiscard]] Hit hit() const;
  /// Sentences about those that cannot be met in this circuit, each told once.
  [[nodiscard]] std::vector<std::string> take_problems();

 private:
  struct Placed {
    std::string condition;
    circuit::Breakpoint what;
  };
  void place();

  circuit::Interpreter* circuit_ = nullptr;
  std::vector<std::string> conditions_;
  std::vector<Placed> placed_;
  std::vector<std::string> problems_, told_;
};

}  // namespace ugoki::studio
