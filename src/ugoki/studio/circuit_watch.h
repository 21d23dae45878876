#pragma once
// What a page looks at while a circuit runs: values of outputs, curves of probes, the time of each LSI. Reported as events at most
// fifteen times a second; costs a few copies a step for probes and nothing for values.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "ugoki/circuit/interpreter.h"

namespace ugoki::studio {

struct WatchRequest {
  std::vector<std::string> pins;    ///< outputs of the flat circuit: "arm/elbow.out"
  std::vector<std::string> probes;  ///< outputs of which every step counts
  bool timing = false;
  bool nearest = false;  ///< frames with the nearest points of all characters
};

class CircuitWatch {
 public:
  /// s between reports.
  static constexpr double period = 1.0 / 15;

  /// Replaces what is watched. Outputs that the circuit does not have are left out.
  void set(WatchRequest request);
  /// Another circuit runs from now on; null: none. It must outlive this, or the next attach.
  void attach(circuit::Interpreter* circuit);
  /// A step was done.
  void stepped() {
    dirty_ = true;
    if (!probes_.empty()) sample();
  }
  /// The circuit's values are others: it was restored, or set back.
  void changed() { dirty_ = true; }

  [[nodiscard]] bool active() const { return circuit_ != nullptr && (request_.timing || !pins_.empty() || !probes_.empty()); }
  /// True if there is something to report.
  [[nodiscard]] bool dirty() const { return dirty_ && active(); }
  /// The event `values` (docs/studio-protocol.md). @param seconds the time now, from any start
  [[nodiscard]] std::string report(double seconds);

 private:
  struct Pin {
    std::string name;
    circuit::PinView view;
  };
  struct Curve {
    Pin pin;
    std::size_t components = 0;
    std::vector<double> numbers;  ///< [rows x components]
  };

  void resolve();
  void sample();

  WatchRequest request_;
  circuit::Interpreter* circuit_ = nullptr;
  std::vector<Pin> pins_;
  std::vector<Curve> probes_;
  std::vector<double> times_;  ///< s, of the rows of all curves
  std::uint32_t stride_ = 1;   ///< steps between two rows
  bool dirty_ = false;
  std::uint64_t counted_from_ = 0, timed_from_ = 0;  ///< processor's counter and timed ticks at the last report
  double seconds_from_ = 0;
  std::vector<circuit::Timing> before_;
};

}  // namespace ugoki::studio
