#include "ugoki/naturalness/report.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ugoki::naturalness {
namespace {
constexpr double join_time = 0.1;  // s
/// How far a value is outside of its limits; comparable between values below and above them.
double excess(const Limits& limits, double value) { return std::max(value - limits.high, limits.low - value); }
}  // namespace

bool Report::good() const {
  return std::ranges::none_of(measures, [](const MeasureReport& m) { return m.grade() == Grade::bad; });
}

void Recorder::add(std::span<const double> now) {
  for (std::size_t i = 0; i < measure_count; ++i) series_[i].push_back(now[i]);
}

Report Recorder::finish(std::span<const double> totals, std::string name, double rate) {
  Report out;
  out.name = std::move(name);
  out.rate = rate;
  out.frames = static_cast<int>(series_[0].size());
  for (std::size_t i = 0; i < measure_count; ++i) {
    const MeasureInfo& info = measure_list()[i];
    MeasureReport& m = out.measures[i];
    m.total = totals[i] < 0 ? no_value : totals[i];
    m.reason = reason_words(totals[i]);
    m.limits = info.limits;
    m.over_time = info.smooth ? moving_rms(series_[i], rate) : std::move(series_[i]);
    m.spans = find_bad_spans(m.over_time, info.now, rate);
    series_[i].clear();
  }
  return out;
}

std::vector<double> moving_rms(const std::vector<double>& values, double rate) {
  const auto n = static_cast<std::ptrdiff_t>(values.size()), half = static_cast<std::ptrdiff_t>(std::lround(rms_time * rate / 2));
  std::vector<double> sums(values.size() + 1), counts(values.size() + 1), out(values.size(), no_value);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const bool valid = values[i] >= 0;
    sums[i + 1] = sums[i] + (valid ? values[i] * values[i] : 0);
    counts[i + 1] = counts[i] + (valid ? 1 : 0);
  }
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    if (values[static_cast<std::size_t>(i)] < 0) continue;
    const auto from = static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, i - half)),
               to = static_cast<std::size_t>(std::min(n, i + half + 1));
    out[static_cast<std::size_t>(i)] = std::sqrt(std::max(0.0, sums[to] - sums[from]) / (counts[to] - counts[from]));
  }
  return out;
}

std::vector<BadSpan> find_bad_spans(const std::vector<double>& values, const Limits& limits, double rate) {
  std::vector<BadSpan> out;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (grade(limits, values[i]) != Grade::bad) continue;
    const double t = static_cast<double>(i) / rate;
    if (out.empty() || t - out.back().to > join_time) out.push_back({t, t, t, values[i]});
    BadSpan& span = out.back();
    span.to = t + 1 / rate;
    if (excess(limits, values[i]) > excess(limits, span.value)) {
      span.at = t;
      span.value = values[i];
    }
  }
  return out;
}

}  // namespace ugoki::naturalness
