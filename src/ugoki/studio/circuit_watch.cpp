#include "ugoki/studio/circuit_watch.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <utility>

#include "ugoki/json/json.h"

namespace ugoki::studio {
namespace {

constexpr std::size_t max_shown_values = 8;       // number of components of a value that the page shows next to its pin
constexpr std::size_t max_curve_components = 16;  // number of components of a probe that are drawn
constexpr std::size_t max_rows = 2000;            // samples of a probe between two reports; further samples are dropped
constexpr double rows_a_second = 500;             // samples of a probe per second of simulated time; bounds the size of a report
constexpr std::uint32_t timing_interval = 4;  // every 4th tick is timed: reading the clock in each tick would take longer than small LSIs

void add_number(std::string& out, double value) {
  if (!std::isfinite(value)) {
    out += "null";
    return;
  }
  char text[32];
  std::snprintf(text, sizeof text, "%.7g", value);
  out += text;
}

template <class Items, class Add>
void add_list(std::string& out, const Items& items, Add add) {
  out += '[';
  bool first = true;
  for (const auto& item : items) {
    if (!first) out += ',';
    first = false;
    add(item);
  }
  out += ']';
}

std::string quoted(const std::string& text) { return json::to_text(json::Json(text)); }

}  // namespace

void CircuitWatch::set(WatchRequest request) {
  request_ = std::move(request);
  resolve();
}

void CircuitWatch::attach(circuit::Interpreter* circuit) {
  circuit_ = circuit;
  resolve();
}

void CircuitWatch::resolve() {
  pins_.clear();
  probes_.clear();
  times_.clear();
  before_.clear();
  dirty_ = true;
  if (!circuit_) return;
  for (const std::string& name : request_.pins)
    if (const Result<circuit::PinView> view = circuit_->find_output(name)) pins_.push_back({name, *view});
  for (const std::string& name : request_.probes) {
    const Result<circuit::PinView> view = circuit_->find_output(name);
    if (!view || !circuit::pin_type(view->type).numeric) continue;
    probes_.push_back({{name, *view}, std::min(view->numbers().size(), max_curve_components), {}});
  }
  circuit_->set_timing(request_.timing ? &circuit::Interpreter::processor_clock : nullptr, timing_interval);
  counted_from_ = circuit::Interpreter::processor_clock();
  timed_from_ = circuit_->timed_ticks();
  seconds_from_ = 0;
  stride_ = 1;
}

void CircuitWatch::sample() {
  const std::uint64_t ticks = circuit_->ticks();
  if (ticks % stride_ != 0 || times_.size() >= max_rows) return;
  if (ticks > 0) stride_ = std::max(1u, static_cast<std::uint32_t>(static_cast<double>(ticks) / circuit_->time() / rows_a_second + 0.5));
  times_.push_back(circuit_->time());
  for (Curve& curve : probes_) {
    const std::span<const double> numbers = curve.pin.view.numbers().first(curve.components);
    curve.samples.insert(curve.samples.end(), numbers.begin(), numbers.end());
  }
}

std::string CircuitWatch::report(double seconds) {
  dirty_ = false;
  std::string out = "{\"event\":\"values\",\"time\":";
  add_number(out, circuit_->time());
  out += ",\"pins\":";
  add_list(out, pins_, [&](const Pin& pin) {
    out += "[" + quoted(pin.name) + "," + std::to_string(pin.view.count) + ",";
    if (circuit::pin_type(pin.view.type).numeric) {
      const std::span<const double> numbers = pin.view.numbers();
      add_list(out, numbers.first(std::min(numbers.size(), max_shown_values)), [&](double x) { add_number(out, x); });
    } else {
      std::uint64_t records = 0;
      std::memcpy(&records, pin.view.bytes.data(), sizeof records);
      out += "[" + std::to_string(records) + "]";
    }
    out += "]";
  });
  const std::uint64_t timed = circuit_->timed_ticks(), counted = circuit::Interpreter::processor_clock();
  if (request_.timing && seconds_from_ > 0 && timed > timed_from_ && counted > counted_from_) {
    // The frequency of the processor's cycle counter is unknown. It is measured here with the clock time.
    // The reported time of an LSI is its mean time per timed tick since the last report.
    const double us_a_count = 1e6 * (seconds - seconds_from_) / static_cast<double>(counted - counted_from_);
    const std::vector<circuit::Timing> now = circuit_->timings();
    double all = 0;
    out += ",\"times\":";
    std::size_t at = 0;
    add_list(out, now, [&](const circuit::Timing& t) {
      while (at < before_.size() && before_[at].lsi < t.lsi) ++at;
      const bool known = at < before_.size() && before_[at].lsi == t.lsi && before_[at].total <= t.total;
      const std::uint64_t spent = t.total - (known ? before_[at].total : 0);
      const double us = static_cast<double>(spent) * us_a_count / static_cast<double>(timed - timed_from_);
      all += us;
      out += "[" + quoted(t.lsi) + ",";
      add_number(out, us);
      out += "]";
    });
    out += ",\"tick_us\":";
    add_number(out, all);
    before_ = now;
  } else if (request_.timing) {
    before_ = circuit_->timings();
  }
  counted_from_ = counted;
  timed_from_ = timed;
  seconds_from_ = seconds;
  if (!times_.empty()) {
    out += ",\"probes\":";
    add_list(out, probes_, [&](const Curve& curve) {
      out += "[" + quoted(curve.pin.name) + ",";
      add_list(out, times_, [&](double t) { add_number(out, t); });
      out += ",[";
      for (std::size_t c = 0; c < curve.components; ++c) {
        out += c ? ",[" : "[";
        for (std::size_t row = 0; row < times_.size(); ++row) {
          if (row) out += ',';
          add_number(out, curve.samples[row * curve.components + c]);
        }
        out += "]";
      }
      out += "]]";
    });
    times_.clear();
    for (Curve& curve : probes_) curve.samples.clear();
  }
  return out + "}";
}

}  // namespace ugoki::studio
