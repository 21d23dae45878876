#include "session.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "ugoki/base/number.h"
#include "ugoki/files/files.h"
#include "ugoki/fmi/export.h"
#include "ugoki/json/json.h"

namespace ugoki::fmu {
namespace {

using fmi::InterfaceRole;
using fmi::InterfaceType;
using fmi::InterfaceVariable;

// Fraction of the tick length: a communication point this close to a tick coincides with the tick. Importing tools add up their steps,
// which accumulates rounding errors.
constexpr double slack = 1e-6;

std::string first_problem(const Error& error) {
  const Problem& p = error.problems[0];
  return p.location + ": " + p.message;
}

/// Serialises plain values and arrays (with their size in front). The `take` functions read from the front; false: too few bytes are left.
class Bytes {
 public:
  template <class T>
  static void put(std::vector<std::byte>& to, const T& x) {
    const auto* p = reinterpret_cast<const std::byte*>(&x);
    to.insert(to.end(), p, p + sizeof x);
  }
  template <class T>
  static void put_all(std::vector<std::byte>& to, std::span<const T> x) {
    put(to, static_cast<std::uint64_t>(x.size()));
    const auto* p = reinterpret_cast<const std::byte*>(x.data());
    to.insert(to.end(), p, p + x.size_bytes());
  }

  explicit Bytes(std::span<const std::byte> rest) : rest_(rest) {}
  template <class T>
  bool take(T& x) {
    if (rest_.size() < sizeof x) return false;
    std::memcpy(&x, rest_.data(), sizeof x);
    rest_ = rest_.subspan(sizeof x);
    return true;
  }
  template <class Container>
  bool take_all(Container& out) {
    std::uint64_t n = 0;
    using T = typename Container::value_type;
    if (!take(n) || n > rest_.size() / sizeof(T)) return false;
    out.resize(n);
    if (n) std::memcpy(out.data(), rest_.data(), n * sizeof(T));
    rest_ = rest_.subspan(n * sizeof(T));
    return true;
  }
  [[nodiscard]] bool at_end() const { return rest_.empty(); }

 private:
  std::span<const std::byte> rest_;
};

constexpr std::uint64_t snapshot_magic = 0x31554d46494b4755ULL;  // "UGKIFMU1", first 8 bytes of a serialised Snapshot

}  // namespace

std::vector<std::byte> Snapshot::to_bytes() const {
  std::vector<std::byte> out;
  Bytes::put(out, snapshot_magic);
  Bytes::put(out, static_cast<std::uint8_t>(mode));
  Bytes::put(out, static_cast<std::uint8_t>(fresh));
  Bytes::put(out, start);
  Bytes::put(out, now);
  Bytes::put(out, static_cast<std::uint64_t>(values.size()));
  for (const std::vector<double>& v : values) Bytes::put_all<double>(out, v);
  for (const std::string& t : texts) Bytes::put_all<char>(out, t);
  Bytes::put_all<double>(out, seen);
  Bytes::put_all<std::byte>(out, machine);
  return out;
}

bool Snapshot::from_bytes(std::span<const std::byte> bytes, std::size_t variables) {
  Bytes in(bytes);
  std::uint64_t magic = 0, count = 0;
  std::uint8_t mode_number = 0, fresh_number = 0;
  if (!in.take(magic) || magic != snapshot_magic || !in.take(mode_number) || mode_number > 4 || !in.take(fresh_number) || !in.take(start) ||
      !in.take(now) || !in.take(count) || count != variables)
    return false;
  mode = static_cast<Mode>(mode_number);
  fresh = fresh_number != 0;
  values.resize(variables);
  texts.resize(variables);
  for (std::vector<double>& v : values)
    if (!in.take_all(v)) return false;
  for (std::string& t : texts)
    if (!in.take_all(t)) return false;
  return in.take_all(seen) && in.take_all(machine) && in.at_end();
}

std::unique_ptr<Session> Session::open(const std::string& resources, std::string_view token, std::string& why) {
  const auto refuse = [&why](std::string text) {
    why = std::move(text);
    return nullptr;
  };
  const auto path = [&](std::string_view name) { return resources + (resources.ends_with('/') ? "" : "/") + std::string(name); };
  const Result<std::string> circuit = files::read_file(path(fmi::circuit_file)), run = files::read_file(path(fmi::run_file));
  if (!circuit || !run) return refuse("The FMU's resources cannot be read: " + first_problem(circuit ? run.error() : circuit.error()));
  const Result<json::Json> settings = json::parse_json(*run, std::string(fmi::run_file));
  if (!settings || !settings->is_object() || !settings->contains("dt") || !(*settings)["dt"].is_number() || !settings->contains("token") ||
      !(*settings)["token"].is_string())
    return refuse("The FMU's run.json is damaged; export the FMU again.");
  if ((*settings)["token"].get<std::string>() != token) return refuse("The GUID (instantiation token) does not belong to this FMU.");
  std::unique_ptr<Session> s(new Session);
  s->dt_ = (*settings)["dt"].get<double>();
  Result<circuit::Circuit> read = circuit::read_circuit(*circuit, fmi::circuit_file);
  if (!read) return refuse(first_problem(read.error()));
  s->circuit_ = std::move(*read);
  const Result<std::string> content = std::filesystem::exists(path(fmi::content_file)) ? files::read_file(path(fmi::content_file)) : "";
  if (!content) return refuse(first_problem(content.error()));
  s->content_ = packed_content(*content, why);
  if (!why.empty()) return nullptr;
  Result<circuit::Interpreter> built = circuit::Interpreter::build(s->circuit_, packed_library(), s->content_.get(), {.dt = s->dt_});
  if (!built) return refuse(first_problem(built.error()));
  s->interface_ = fmi::make_interface(s->circuit_, packed_library(), *built);
  std::size_t seen = 0;
  for (const InterfaceVariable& v : s->interface_.variables) {
    s->seen_at_.push_back(seen);
    if (v.role == InterfaceRole::output) seen += v.count;
    s->refreshes_ = s->refreshes_ || v.on_demand;
  }
  s->seen_.assign(seen, 0.0);
  s->to_start();
  return s;
}

std::optional<std::size_t> Session::find(std::uint32_t reference) const {
  const auto& all = interface_.variables;  // sorted by value reference
  const auto after =
      std::upper_bound(all.begin(), all.end(), reference, [](std::uint32_t r, const InterfaceVariable& v) { return r < v.reference; });
  if (after == all.begin()) return std::nullopt;
  const auto found = after - 1;
  if (reference - found->reference >= std::max(1u, found->count)) return std::nullopt;
  return static_cast<std::size_t>(found - all.begin());
}

void Session::to_start() {
  mode_ = Mode::instantiated;
  start_ = now_ = 0;
  stop_.reset();
  values_.clear();
  texts_.clear();
  for (const InterfaceVariable& v : interface_.variables) {
    values_.push_back(v.start);
    texts_.push_back(v.text);
  }
  running_.reset();
  ahead_ = fresh_ = false;
}

void Session::set_experiment(double start, std::optional<double> stop) {
  start_ = now_ = start;
  stop_ = stop;
}

std::string Session::enter_initialization() {
  mode_ = Mode::initialization;
  return {};
}

std::string Session::exit_initialization() {
  if (!running_)
    if (std::string bad = build(); !bad.empty()) return bad;
  mode_ = Mode::stepping;
  return {};
}

std::string Session::terminate() {
  mode_ = Mode::terminated;
  return {};
}

std::string Session::reset() {
  to_start();
  return {};
}

/// Message with the reason why the circuit stopped.
std::string Session::stop_words() const {
  const circuit::Stop* stop = running_->stopped();
  return stop ? stop->text() : "The circuit did not compute the tick.";
}

/// Builds the interpreter with the current values of parameters and inputs.
std::string Session::build() {
  circuit::Circuit circuit = circuit_;
  for (std::size_t i = 0; i < interface_.variables.size(); ++i) {
    const InterfaceVariable& v = interface_.variables[i];
    if (v.role != InterfaceRole::parameter || (values_[i] == v.start && texts_[i] == v.text)) continue;
    circuit::Value value = values_[i][0];
    if (v.type == InterfaceType::boolean) value = values_[i][0] != 0;
    if (v.type == InterfaceType::text) value = texts_[i];
    if (v.type == InterfaceType::choice) value = v.words[static_cast<std::size_t>(values_[i][0]) - 1];
    if (v.array) value = values_[i];
    fmi::set_parameter(circuit, v.target, value);
  }
  running_.reset();
  ahead_ = fresh_ = false;
  Result<circuit::Interpreter> built = circuit::Interpreter::build(circuit, packed_library(), content_.get(), {.dt = dt_});
  if (!built) return first_problem(built.error());
  running_.emplace(std::move(*built));
  std::vector<std::string> pins;
  for (const InterfaceVariable& v : interface_.variables)
    if (v.role == InterfaceRole::output) pins.push_back(v.source);
  if (!pins.empty())
    if (Result<void> done = running_->set_probes(pins, 1); !done) return first_problem(done.error());
  for (std::size_t i = 0; i < interface_.variables.size(); ++i) write_input(i);
  return {};
}

void Session::write_input(std::size_t variable) {
  const InterfaceVariable& v = interface_.variables[variable];
  if (v.role == InterfaceRole::input) {
    const std::span<std::byte> to = running_->find_circuit_input(v.target);
    std::memcpy(to.data(), values_[variable].data(), std::min(to.size(), values_[variable].size() * sizeof(double)));
  } else if (v.role == InterfaceRole::device) {
    for (const circuit::DeviceSlot& d : running_->devices())
      if (d.id + "." + d.pin == v.target)
        std::copy_n(values_[variable].begin(), std::min(d.numbers.size(), values_[variable].size()), d.numbers.begin());
  }
}

/// Computes `count` ticks and stores the outputs of the last tick in `seen_`.
std::string Session::tick(std::uint64_t count) {
  if (count == 0) return {};
  if (running_->run(count) != count) return stop_words();
  const circuit::ProbeRows rows = running_->probes();
  if (rows.size() > 0) std::copy(rows.numbers(rows.size() - 1).begin(), rows.numbers(rows.size() - 1).end(), seen_.begin());
  return {};
}

/// Number of ticks before `time`, s. @param due [out] true: there is a tick at `time` itself
std::uint64_t Session::ticks_until(double time, bool& due) const {
  const double ticks = (time - start_) / dt_;
  const double whole = std::floor(ticks + 0.5);
  due = std::fabs(ticks - whole) <= slack * std::max(1.0, std::fabs(ticks) * 1e-6);
  return static_cast<std::uint64_t>(std::max(0.0, due ? whole : std::ceil(ticks)));
}

/// Stores the outputs at the time `now_` in `seen_`. If there is a tick at `now_`, computes it now, before the master advances the time.
/// Refreshes the outputs of LSIs that run on demand.
std::string Session::update_outputs() {
  if (fresh_) return {};
  if (!running_)
    if (std::string bad = build(); !bad.empty()) return bad;
  bool due = false;
  const std::uint64_t done = ticks_until(now_, due);
  if (due && !ahead_ && running_->ticks() == done) {
    running_->save(before_);
    std::string bad = tick(1);
    if (!bad.empty()) {
      (void)running_->restore(before_);
      return bad;
    }
    ahead_ = true;
  }
  if (refreshes_) {
    if (!running_->refresh()) return stop_words();
    for (std::size_t i = 0; i < interface_.variables.size(); ++i) {
      const InterfaceVariable& v = interface_.variables[i];
      if (!v.on_demand) continue;
      const auto view = running_->find_output(v.source);
      if (view) std::copy_n(view->numbers().begin(), v.count, seen_.begin() + static_cast<std::ptrdiff_t>(seen_at_[i]));
    }
  }
  fresh_ = true;
  return {};
}

std::string Session::undo() {
  if (!ahead_) return {};
  ahead_ = fresh_ = false;
  const Result<void> done = running_->restore(before_);
  return done ? std::string() : first_problem(done.error());
}

std::string Session::step(double now, double size) {
  if (!std::isfinite(now) || std::fabs(now - now_) > slack * std::max(dt_, std::fabs(now) * 1e-6))
    return "The step begins at " + to_text(now) + " s, but the last step ended at " + to_text(now_) + " s.";
  if (!(size > 0) || !std::isfinite(size)) return "The communication step size is " + to_text(size) + " s; it must be positive and finite.";
  if (stop_ && now + size > *stop_ + slack * size) return "The step ends after the stop time, " + to_text(*stop_) + " s.";
  if (!((now + size - start_) / dt_ < 9e15)) return "The step ends after too many ticks of the circuit; the limit is 9e15 ticks.";
  bool due = false;
  const std::uint64_t until = ticks_until(now + size, due);
  if (until > running_->ticks()) {
    const std::uint64_t count = until - running_->ticks();
    ahead_ = false;
    fresh_ = false;
    if (std::string bad = tick(count); !bad.empty()) return bad;
  } else {
    fresh_ = fresh_ && !due;
    ahead_ = ahead_ && running_->ticks() > until;
  }
  now_ = now + size;
  return {};
}

std::string Session::may_set(const InterfaceVariable& v) const {
  const bool before = mode_ == Mode::instantiated || mode_ == Mode::initialization;
  if (v.role == InterfaceRole::time || v.role == InterfaceRole::output)
    return "'" + v.name + "' is neither an input nor a parameter; it cannot be set.";
  if (v.role == InterfaceRole::parameter && !v.tunable && !before)
    return "The parameter '" + v.name + "' is fixed; it can be set only before the end of initialization mode.";
  return {};
}

std::string Session::get(std::size_t variable, std::size_t first, std::span<double> values) {
  const InterfaceVariable& v = interface_.variables[variable];
  if (v.role == InterfaceRole::time) {
    values[0] = now_;
    return {};
  }
  if (v.role != InterfaceRole::output) {
    std::copy_n(values_[variable].begin() + static_cast<std::ptrdiff_t>(first), values.size(), values.begin());
    return {};
  }
  if (mode_ != Mode::terminated)
    if (std::string bad = update_outputs(); !bad.empty()) return bad;
  std::copy_n(seen_.begin() + static_cast<std::ptrdiff_t>(seen_at_[variable] + first), values.size(), values.begin());
  return {};
}

std::string Session::set(std::size_t variable, std::size_t first, std::span<const double> values) {
  const InterfaceVariable& v = interface_.variables[variable];
  if (std::string bad = may_set(v); !bad.empty()) return bad;
  for (const double x : values) {
    if (!std::isfinite(x)) return "'" + v.name + "' is set to a value that is not finite.";
    if (v.role == InterfaceRole::parameter && ((v.minimum && x < *v.minimum) || (v.maximum && x > *v.maximum)))
      return "'" + v.name + "' is set to " + to_text(x) + ", which is out of its range.";
    if (v.type == InterfaceType::choice && !(x >= 1 && x <= static_cast<double>(v.words.size())))
      return "'" + v.name + "' is set to " + to_text(x) + "; it must be 1 to " + std::to_string(v.words.size()) + ".";
  }
  if (std::equal(values.begin(), values.end(), values_[variable].begin() + static_cast<std::ptrdiff_t>(first))) return {};
  if (std::string bad = undo(); !bad.empty()) return bad;
  fresh_ = false;
  std::copy(values.begin(), values.end(), values_[variable].begin() + static_cast<std::ptrdiff_t>(first));
  if (!running_) return {};
  if (v.role != InterfaceRole::parameter) {
    write_input(variable);
    return {};
  }
  if (mode_ != Mode::stepping) {
    running_.reset();  // rebuild later: the parameter may affect the initial state
    return {};
  }
  for (const std::string& end : v.ends)
    for (std::size_t k = 0; k < values.size(); ++k) {
      const double x = v.type == InterfaceType::choice ? values[k] - 1 : values[k];
      if (Result<void> done = running_->set_parameter(end, x, first + k); !done) return first_problem(done.error());
    }
  return {};
}

std::string Session::set_text(std::size_t variable, std::string text) {
  if (std::string bad = may_set(interface_.variables[variable]); !bad.empty()) return bad;
  if (text == texts_[variable]) return {};
  texts_[variable] = std::move(text);
  running_.reset();
  ahead_ = fresh_ = false;
  return {};
}

std::string Session::save(Snapshot& out) {
  out = {mode_, start_, now_, values_, texts_, seen_, fresh_ && !ahead_, {}};
  if (!running_) return {};
  if (ahead_)
    out.machine = before_;
  else
    running_->save(out.machine);
  return {};
}

std::string Session::load(const Snapshot& from) {
  for (std::size_t i = 0; i < values_.size(); ++i)
    if (from.values[i].size() != values_[i].size()) return "The saved state belongs to another FMU.";
  if (from.seen.size() != seen_.size()) return "The saved state belongs to another FMU.";
  bool rebuild = false;
  for (std::size_t i = 0; i < values_.size(); ++i) {
    const InterfaceVariable& v = interface_.variables[i];
    rebuild = rebuild || (v.role == InterfaceRole::parameter && !v.tunable && (from.values[i] != values_[i] || from.texts[i] != texts_[i]));
  }
  mode_ = from.mode;
  start_ = from.start;
  now_ = from.now;
  values_ = from.values;
  texts_ = from.texts;
  seen_ = from.seen;
  ahead_ = false;
  fresh_ = from.fresh;
  if (from.machine.empty()) {
    running_.reset();
    return {};
  }
  if (rebuild || !running_) {
    if (std::string bad = build(); !bad.empty()) return bad;
    fresh_ = from.fresh;
  }
  const Result<void> done = running_->restore(from.machine);
  return done ? std::string() : first_problem(done.error());
}

}  // namespace ugoki::fmu
