// `ugoki circuit run`: the guarded process runs the circuit; the parent process reports crashes.

#include "circuit_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <optional>
#include <thread>

#include "output.h"
#include "output_files.h"
#include "probe_log.h"
#include "ugoki/base/number.h"
#include "ugoki/circuit/breakpoint.h"
#include "ugoki/circuit/interpreter.h"
#include "ugoki/files/files.h"
#include "ugoki/lsi/standard_library.h"
#include "ugoki/plugin/guard.h"
#include "ugoki/plugin/osc.h"
#include "ugoki/plugin/shelf.h"
#include "ugoki/plugin/thread_pool.h"

namespace ugoki::cli {

Result<circuit::Circuit> load_circuit(const std::string& path) {
  const Result<std::string> text = files::read_file(path);
  if (!text) return fail(text.error());
  return circuit::read_circuit(*text, path + ":");
}

std::shared_ptr<plugin::LiveLibrary> open_libraries(const CircuitOptions& o) {
  auto live =
      std::make_shared<plugin::LiveLibrary>(lsi::standard_library(), o.shelf.empty() ? plugin::default_shelf() : o.shelf, o.libraries);
  for (const std::string& m : live->take_messages()) print_message(m);
  return live;
}

namespace {

using circuit::Interpreter;

/// Parses an assignment such as "name=1,2,3".
Result<std::pair<std::string, std::vector<double>>> read_assignment(const std::string& text, const char* option) {
  const auto equal = text.rfind('=');
  std::pair<std::string, std::vector<double>> out;
  out.first = text.substr(0, equal);
  bool good = equal != std::string::npos;
  for (std::size_t at = equal + 1; good; ++at) {
    const auto comma = std::min(text.find(',', at), text.size());
    const auto x = parse_double(std::string_view(text).substr(at, comma - at));
    good = x.has_value();
    if (x) out.second.push_back(*x);
    at = comma;
    if (at >= text.size()) break;
  }
  if (good) return out;
  return fail(ErrorCode::syntax, option, "'" + text + "' is not an assignment of numbers.", "Write it as name=1.5 or name=1,2,3.");
}

Result<void> apply_inputs(Interpreter& interpreter, const CircuitOptions& o) {
  for (const std::string& text : o.sets) {
    const auto set = read_assignment(text, "--set");
    if (!set) return fail(set.error());
    for (std::size_t i = 0; i < set->second.size(); ++i)
      if (Result<void> done = interpreter.set_parameter(set->first, set->second[i], i); !done) return done;
  }
  for (const std::string& text : o.inputs) {
    const auto set = read_assignment(text, "--input");
    if (!set) return fail(set.error());
    std::span<std::byte> to = interpreter.find_circuit_input(set->first);
    for (const circuit::DeviceSlot& d : interpreter.devices())
      if (d.id + "." + d.pin == set->first) to = std::as_writable_bytes(d.numbers);
    if (to.size() != set->second.size() * sizeof(double))
      return fail(ErrorCode::unknown, "--input",
                  "The circuit has no input '" + set->first + "' of " + std::to_string(set->second.size()) + " numbers.",
                  "Name an input of the circuit, or the pin of a device as id.pin.");
    std::memcpy(to.data(), set->second.data(), to.size());
  }
  return {};
}

Json numbers_json(std::span<const double> x) {
  if (x.size() == 1) return x[0];
  Json out = Json::array();
  for (const double n : x) out.push_back(n);
  return out;
}

/// Starts to sample the probed pins. Rows that are already in the log are kept if the new rows have the same width.
Result<void> start_probes(Interpreter& interpreter, const CircuitOptions& o, ProbeLog& log) {
  if (o.probes.empty()) return {};
  // The interpreter needs memory for one row only, because the row is copied to the log after each tick.
  if (Result<void> done = interpreter.set_probes(o.probes, 1, static_cast<std::uint32_t>(o.every)); !done) return done;
  std::size_t width = 0;
  for (const std::string& pin : o.probes)
    if (const auto view = interpreter.find_output(pin)) width += view->numbers().size();
  return log.width() == width ? Result<void>{} : log.begin(width);
}

/// Copies the row of samples of the last tick to the log, if the tick was sampled.
void log_probes(const Interpreter& interpreter, ProbeLog& log) {
  const circuit::ProbeRows rows = interpreter.probes();
  if (rows.size() > 0 && (log.size() == 0 || log.tick(log.size() - 1) != rows.tick(0))) log.add(rows.tick(0), rows.numbers(0));
}

Json probes_json(const ProbeLog& log, const CircuitOptions& o) {
  Json times = Json::array(), values = Json::array();
  for (std::size_t i = 0; i < log.size(); ++i) {
    times.push_back(static_cast<double>(log.tick(i)) * o.dt);
    values.push_back(numbers_json(log.numbers(i)));
  }
  return {{"pins", o.probes}, {"time", times}, {"values", values}};
}

/// Prints the last rows of samples as a table.
void print_probes(const ProbeLog& log, const CircuitOptions& o) {
  constexpr std::size_t shown = 10;
  const std::size_t first = log.size() > shown ? log.size() - shown : 0;
  std::string pins;
  for (const std::string& pin : o.probes) pins += (pins.empty() ? "" : ", ") + pin;
  std::vector<std::vector<std::string>> rows = {{"time_s", pins}};
  for (std::size_t i = first; i < log.size(); ++i)
    rows.push_back({to_text(static_cast<double>(log.tick(i)) * o.dt), json::to_text(numbers_json(log.numbers(i)))});
  print_line("Probes: " + std::to_string(log.size()) + " rows" +
             (first > 0 ? "; the last " + std::to_string(shown) + " (--json: all)" : ""));
  print_table(rows);
}

/// Replaces the interpreter by one that uses rebuilt libraries. If that fails, the running interpreter continues unchanged.
void reload(Interpreter& interpreter, const circuit::Circuit& circuit, std::shared_ptr<const circuit::Library>& library,
            plugin::LiveLibrary& live, const circuit::BuildOptions& build, const CircuitOptions& o, plugin::ThreadPool& pool,
            ProbeLog& log) {
  if (!live.poll()) return;
  for (const std::string& m : live.take_messages()) print_message(m);
  std::shared_ptr<const circuit::Library> next = live.library();
  Result<Interpreter> made = Interpreter::build(circuit, *next, nullptr, build);
  if (!made) {
    print_message("the rebuilt library cannot run this circuit; the previous version continues.");
    (void)print_error(made.error(), false);
    return;
  }
  const Interpreter::Adoption report = made->adopt_report(interpreter);
  for (const auto* sentences : {&report.partly, &report.afresh})
    for (const std::string& s : *sentences) print_message(s);
  print_message("reloaded at " + to_fixed(interpreter.time(), 3) + " s; " + std::to_string(report.kept) + " LSIs keep their state.");
  made->set_executor(&pool);
  interpreter = std::move(*made);
  library = std::move(next);
  if (Result<void> done = start_probes(interpreter, o, log); !done) (void)print_error(done.error(), false);
  (void)apply_inputs(interpreter, o);
}

/// Writes received OSC messages to the LSIs `osc` of the circuit.
void receive(plugin::OscReceiver& osc, Interpreter& interpreter) {
  osc.poll([&](std::string_view address, std::span<const double> numbers) {
    for (const circuit::DeviceSlot& d : interpreter.devices()) {
      if (d.device != "osc" || d.address != address) continue;
      if (d.pin == "value" && !numbers.empty()) d.numbers[0] = numbers[0];
      if (d.pin == "count") d.numbers[0] += 1;
    }
  });
}

int run_inside(const CircuitOptions& o, ProbeLog& log) {
  const Result<circuit::Circuit> circuit = load_circuit(o.targets[0]);
  if (!circuit) return print_error(circuit.error(), o.json);
  const std::shared_ptr<plugin::LiveLibrary> live = open_libraries(o);
  std::shared_ptr<const circuit::Library> library = live->library();
  const circuit::BuildOptions build{.dt = o.dt, .check_finite = true, .activity = &plugin::process_activity()};
  Result<Interpreter> interpreter = Interpreter::build(*circuit, *library, nullptr, build);
  if (!interpreter) return print_error(interpreter.error(), o.json);
  if (Result<void> done = apply_inputs(*interpreter, o); !done) return print_error(done.error(), o.json);
  if (Result<void> done = start_probes(*interpreter, o, log); !done) return print_error(done.error(), o.json);
  std::vector<circuit::Breakpoint> breakpoints;
  for (const std::string& text : o.breaks) {
    const Result<circuit::Breakpoint> b = circuit::read_breakpoint(text);
    if (!b) return print_error(b.error(), o.json);
    breakpoints.push_back(*b);
  }
  if (Result<void> done = interpreter->set_breakpoints(breakpoints); !done) return print_error(done.error(), o.json);
  if (!o.record.empty()) interpreter->start_recording();
  if (!o.replay.empty()) {
    const Result<std::string> text = files::read_file(o.replay);
    const Result<circuit::InputRecord> record = text ? circuit::read_input_record(*text, o.replay) : fail(text.error());
    if (!record) return print_error(record.error(), o.json);
    if (Result<void> done = interpreter->replay(*record); !done) return print_error(done.error(), o.json);
  }
  if (o.timing)
    interpreter->set_timing([] { return static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count()); });

  plugin::ThreadPool pool(o.threads);
  interpreter->set_executor(&pool);
  // Prints the messages of LSI libraries, for example of FMUs.
  const auto print_messages = [&live] {
    for (const std::string& m : live->take_messages()) print_message(m);
  };
  print_messages();
  std::optional<plugin::OscReceiver> osc;
  if (o.osc > 0) {
    Result<plugin::OscReceiver> opened = plugin::OscReceiver::open(static_cast<std::uint16_t>(o.osc));
    if (!opened) return print_error(opened.error(), o.json);
    osc.emplace(std::move(*opened));
  }

  catch_interrupt();
  const auto ticks = static_cast<std::uint64_t>(std::llround(o.duration / o.dt));
  const auto begin = std::chrono::steady_clock::now();
  auto last_poll = begin;
  int hit = -1;
  Error stopped;  // error of the LSI that stopped the circuit
  while (interpreter->ticks() < ticks && hit < 0 && stopped.empty() && !interrupted()) {
    if (osc) receive(*osc, *interpreter);
    const bool good = interpreter->tick();
    if (!good || interpreter->ticks() % 64 == 0) print_messages();
    if (!good) {
      const circuit::Stop& stop = *interpreter->stopped();
      stopped.add(ErrorCode::structure, stop.pin.empty() ? stop.lsi : stop.pin, stop.text(), "Correct the LSI or the circuit.");
      break;
    }
    log_probes(*interpreter, log);
    hit = interpreter->breakpoint_hit();
    if (o.realtime) std::this_thread::sleep_until(begin + std::chrono::duration<double>(interpreter->time()));
    if (!o.reload || interpreter->ticks() % 16 != 0) continue;
    const auto now = std::chrono::steady_clock::now();
    if (now - last_poll < std::chrono::milliseconds(100)) continue;
    last_poll = now;
    reload(*interpreter, *circuit, library, *live, build, o, pool, log);
  }
  const bool cut_off = interrupted() && interpreter->ticks() < ticks;
  const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  print_messages();
  if (!o.record.empty())
    if (Result<void> done = files::write_file(o.record, circuit::write_input_record(interpreter->recording())); !done)
      return print_error(done.error(), o.json);

  Json outputs = Json::object(), timing = Json::array();
  std::vector<std::vector<std::string>> rows = {{"pin", "value"}};
  const auto show = [&](const std::string& name, const Result<circuit::PinView>& view) {
    if (!view || !pin_type(view->type).numeric) return;
    outputs[name] = numbers_json(view->numbers());
    rows.push_back({name, json::to_text(outputs[name])});
  };
  for (const circuit::BoundaryPin& pin : circuit->outputs) show(pin.name, interpreter->find_circuit_output(pin.name));
  if (circuit->outputs.empty())
    for (const circuit::Instance& lsi : circuit->lsis)
      if (const circuit::LsiClass* c = library->find(lsi.type))
        for (const circuit::OutputPin& pin : c->outputs) show(lsi.id + "." + pin.name, interpreter->find_output(lsi.id + "." + pin.name));
  std::vector<circuit::Timing> timings_by_total = interpreter->timings();
  std::sort(timings_by_total.begin(), timings_by_total.end(),
            [](const circuit::Timing& a, const circuit::Timing& b) { return a.total > b.total; });
  for (const circuit::Timing& t : timings_by_total)
    timing.push_back({{"lsi", t.lsi}, {"runs", t.runs}, {"mean_ns", static_cast<double>(t.total) / static_cast<double>(t.runs)}});
  if (cut_off && stopped.empty())
    stopped.add(ErrorCode::cancelled, circuit->name,
                "Stopped by a signal (Ctrl+C) after " + std::to_string(interpreter->ticks()) + " of " + std::to_string(ticks) + " ticks.",
                "The results are those up to this tick; run the circuit again for all.");
  if (!stopped.empty()) (void)print_error(stopped, false);
  if (o.json) {
    Json out = {{"circuit", circuit->name},
                {"ticks", interpreter->ticks()},
                {"time_s", interpreter->time()},
                {"wall_s", wall},
                {"outputs", outputs}};
    if (!o.probes.empty()) out["probes"] = probes_json(log, o);
    if (o.timing) out["timing"] = timing;
    if (hit >= 0) out["breakpoint"] = {{"index", hit}, {"condition", o.breaks[static_cast<std::size_t>(hit)]}};
    if (!stopped.empty()) out["error"] = json::error_json(stopped);
    print_json(out);
    return stopped.empty() ? 0 : 1;
  }
  if (hit >= 0) print_line("Stopped at " + to_fixed(interpreter->time() - o.dt, 3) + " s: " + o.breaks[static_cast<std::size_t>(hit)]);
  print_line(circuit->name + ": " + std::to_string(interpreter->ticks()) + " ticks, " + to_fixed(interpreter->time(), 3) + " s");
  print_table(rows);
  if (!o.probes.empty()) print_probes(log, o);
  for (const Json& t : timing)
    print_line(t.value("lsi", "") + "  " + to_fixed(t.value("mean_ns", 0.0), 1) + " ns, " +
               std::to_string(t.value("runs", std::uint64_t{0})) + " runs");
  return stopped.empty() ? 0 : 1;
}

}  // namespace

int run_circuit(const CircuitOptions& o) {
  std::vector<NamedFile> inputs = {{"--replay", o.replay}};
  for (const std::string& path : o.targets) inputs.push_back({"the circuit", path});
  for (const std::string& path : o.libraries) inputs.push_back({"--lsi", path});
  if (Result<void> may = check_outputs(inputs, {{"--record", o.record}}); !may) return print_error(may.error(), o.json);
  ProbeLog log;
  if (!o.probes.empty())
    if (Result<void> done = log.open(); !done) return print_error(done.error(), o.json);
  const Result<int> done =
      plugin::run_guarded([&] { return run_inside(o, log); }, std::chrono::milliseconds(static_cast<std::int64_t>(o.patience * 1000)));
  if (done) return *done;
  if (!log.attach()) return print_error(done.error(), o.json);
  (void)print_error(done.error(), false);
  if (o.json)
    print_json({{"error", json::error_json(done.error())}, {"probes", probes_json(log, o)}});
  else
    print_probes(log, o);
  return 1;
}

}  // namespace ugoki::cli
