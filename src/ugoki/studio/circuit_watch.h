#pragma once
// Collects values of the running circuit for the web pages: current values of outputs, curves of probes, execution time of each LSI.
// They are sent as `values` events, at most 15 times a second. Probes are sampled after steps; other outputs are read only when an event
// is sent.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "ugoki/circuit/interpreter.h"

namespace ugoki::studio {

struct WatchRequest {
  std::vector<std::string> pins;    ///< outputs to report, each with its path: "arm/elbow.out"
  std::vector<std::string> probes;  ///< outputs that are sampled over time and drawn as curves
  bool timing = false;              ///< true: report the time that each LSI takes
  bool closest = false;             ///< true: append the closest points of all pairs of characters to display frames
};

class CircuitWatch {
 public:
  /// Minimum time between two reports, s.
  static constexpr double period = 1.0 / 15;

  /// Replaces the set of watched outputs. Outputs that the circuit does not have are ignored.
  void set(WatchRequest request);
  /// Sets the circuit that is watched; null: none. The circuit must live until the next attach() or the end of this object.
  void attach(circuit::Interpreter* circuit);
  /// Call after each step: samples the probes.
  void stepped() {
    dirty_ = true;
    if (!probes_.empty()) sample();
  }
  /// Call after the circuit was restored or reset, because its values then changed without a step.
  void changed() { dirty_ = true; }

  [[nodiscard]] bool active() const { return circuit_ != nullptr && (request_.timing || !pins_.empty() || !probes_.empty()); }
  /// True if watched values changed since the last report.
  [[nodiscard]] bool dirty() const { return dirty_ && active(); }
  /// The event `values` (docs/studio-protocol.md) as JSON. Clears the samples of the probes. @param seconds clock time, s, from any origin
  [[nodiscard]] std::string report(double seconds);

 private:
  struct Pin {
    std::string name;
    circuit::PinView view;
  };
  struct Curve {
    Pin pin;
    std::size_t components = 0;
    std::vector<double> samples;  ///< samples of the probe: [rows][components]
  };

  void resolve();
  void sample();

  WatchRequest request_;
  circuit::Interpreter* circuit_ = nullptr;
  std::vector<Pin> pins_;
  std::vector<Curve> probes_;
  std::vector<double> times_;  ///< simulated time of each row of samples, s; shared by all curves
  std::uint32_t stride_ = 1;   ///< number of ticks between two rows of samples
  bool dirty_ = false;
  std::uint64_t counted_from_ = 0;       ///< value of the processor's cycle counter at the last report
  std::uint64_t timed_from_ = 0;         ///< number of ticks with measured execution time, at the last report
  double seconds_from_ = 0;              ///< clock time of the last report, s; 0: no report yet
  std::vector<circuit::Timing> before_;  ///< accumulated execution times of the LSIs at the last report
};

}  // namespace ugoki::studio
