#pragma once
// The measures of naturalness of one character over time, with the time spans in which they are bad.

#include <array>
#include <string>
#include <vector>

#include "ugoki/naturalness/meter.h"

namespace ugoki::naturalness {

/// Time span in which a value over time is bad.
struct BadSpan {
  double from = 0, to = 0;  ///< s
  double at = 0;            ///< s: time of the worst value
  double value = 0;         ///< the worst value
};

struct MeasureReport {
  double total = no_value;
  std::string reason;             ///< why there is no total; else empty
  Limits limits;                  ///< of `total`
  std::vector<double> over_time;  ///< [frames] values over time; rms over `rms_time` where MeasureInfo::smooth is true
  std::vector<BadSpan> spans;     ///< in the order of time
  [[nodiscard]] Grade grade() const { return naturalness::grade(limits, total); }
};

struct Report {
  std::string name;
  double rate = 0;  ///< frames per second
  int frames = 0;
  std::array<MeasureReport, measure_count> measures;  ///< indices: MeasureId
  [[nodiscard]] bool good() const;                    ///< no total is bad
};

/// Collects the values of measures over time.
class Recorder {
 public:
  /// @param now [measure_count] values at this instant
  void add(std::span<const double> now);
  /// Ends the recording. @param totals [measure_count] values of the whole motion @param rate samples per second
  [[nodiscard]] Report finish(std::span<const double> totals, std::string name, double rate);

 private:
  std::array<std::vector<double>, measure_count> series_;
};

/// Root mean square over `rms_time` around each value; values of no_value are left out.
[[nodiscard]] std::vector<double> moving_rms(const std::vector<double>& values, double rate);
/// Time spans in which `values` are bad; spans less than 0.1 s apart are joined.
[[nodiscard]] std::vector<BadSpan> find_bad_spans(const std::vector<double>& values, const Limits& limits, double rate);

}  // namespace ugoki::naturalness
