// `ugoki circuit`: runs, checks and tests circuits of software LSIs from the command line.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <iostream>
#include <memory>
#include <optional>
#include <thread>

#include "fmu.h"
#include "output.h"
#include "ugoki/base/number.h"
#include "ugoki/circuit/breakpoint.h"
#include "ugoki/circuit/class_json.h"
#include "ugoki/circuit/example.h"
#include "ugoki/circuit/interpreter.h"
#include "ugoki/files/files.h"
#include "ugoki/lsi/standard_library.h"
#include "ugoki/plugin/guard.h"
#include "ugoki/plugin/live_library.h"
#include "ugoki/plugin/osc.h"
#include "ugoki/plugin/shelf.h"
#include "ugoki/plugin/thread_pool.h"
#include "verb.h"

namespace ugoki::cli {
namespace {

using circuit::Interpreter;

struct Options {
  std::vector<std::string> targets, libraries, probes, sets, inputs, breaks;
  std::string shelf, record, replay;
  double dt = 0.001, duration = 1, patience = 3;
  std::uint64_t every = 1;
  int threads = 1, osc = 0;
  bool timing = false, reload = false, realtime = false, json = false;
};

Result<circuit::Circuit> load_circuit(const std::string& path) {
  const Result<std::string> text = files::read_file(path);
  if (!text) return fail(text.error());
  return circuit::read_circuit(*text, path + ":");
}

std::shared_ptr<plugin::LiveLibrary> open_libraries(const Options& o) {
  auto live =
      std::make_shared<plugin::LiveLibrary>(lsi::standard_library(), o.shelf.empty() ? plugin::default_shelf() : o.shelf, o.libraries);
  for (const std::string& m : live->take_messages()) std::cerr << "ugoki: " << m << '\n';
  return live;
}

/// Parses "name=1,2,3".
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

Result<void> apply_inputs(Interpreter& interpreter, const Options& o) {
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

/// Replaces the interpreter by one that uses rebuilt libraries. If that fails, the running interpreter continues unchanged.
void reload(Interpreter& interpreter, const circuit::Circuit& circuit, std::shared_ptr<const circuit::Library>& library,
            plugin::LiveLibrary& live, const circuit::BuildOptions& build, const Options& o, plugin::ThreadPool& pool) {
  if (!live.poll()) return;
  for (const std::string& m : live.take_messages()) std::cerr << "ugoki: " << m << '\n';
  std::shared_ptr<const circuit::Library> next = live.library();
  Result<Interpreter> made = Interpreter::build(circuit, *next, nullptr, build);
  if (!made) {
    std::cerr << "ugoki: the rebuilt library cannot run this circuit; the previous version continues.\n" << made.error().text();
    return;
  }
  const Interpreter::Adoption report = made->adopt_report(interpreter);
  for (const auto* sentences : {&report.partly, &report.afresh})
    for (const std::string& s : *sentences) std::cerr << "ugoki: " << s << '\n';
  std::cerr << "ugoki: reloaded at " << to_fixed(interpreter.time(), 3) << " s; " << report.kept << " LSIs keep their state.\n";
  made->set_executor(&pool);
  interpreter = std::move(*made);
  library = std::move(next);
  if (!o.probes.empty()) (void)interpreter.set_probes(o.probes, 100'000, static_cast<std::uint32_t>(o.every));
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

int run_inside(const Options& o) {
  const Result<circuit::Circuit> circuit = load_circuit(o.targets[0]);
  if (!circuit) return print_error(circuit.error(), o.json);
  const std::shared_ptr<plugin::LiveLibrary> live = open_libraries(o);
  std::shared_ptr<const circuit::Library> library = live->library();
  const circuit::BuildOptions build{.dt = o.dt, .check_finite = true, .activity = &plugin::process_activity()};
  Result<Interpreter> interpreter = Interpreter::build(*circuit, *library, nullptr, build);
  if (!interpreter) return print_error(interpreter.error(), o.json);
  if (Result<void> done = apply_inputs(*interpreter, o); !done) return print_error(done.error(), o.json);
  if (Result<void> done = interpreter->set_probes(o.probes, 100'000, static_cast<std::uint32_t>(o.every)); !done)
    return print_error(done.error(), o.json);
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
  // Messages of the libraries, for example of FMUs.
  const auto print_messages = [&live] {
    for (const std::string& m : live->take_messages()) std::cerr << "ugoki: " << m << '\n';
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
  while (interpreter->ticks() < ticks && hit < 0 && !interrupted()) {
    if (osc) receive(*osc, *interpreter);
    const bool good = interpreter->tick();
    if (!good || interpreter->ticks() % 64 == 0) print_messages();
    if (!good) {
      const circuit::Stop& stop = *interpreter->stopped();
      return print_error(
          Error(ErrorCode::structure, stop.pin.empty() ? stop.lsi : stop.pin, stop.text(), "Correct the LSI or the circuit."), o.json);
    }
    hit = interpreter->breakpoint_hit();
    if (o.realtime) std::this_thread::sleep_until(begin + std::chrono::duration<double>(interpreter->time()));
    if (!o.reload || interpreter->ticks() % 16 != 0) continue;
    const auto now = std::chrono::steady_clock::now();
    if (now - last_poll < std::chrono::milliseconds(100)) continue;
    last_poll = now;
    reload(*interpreter, *circuit, library, *live, build, o, pool);
  }
  const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  print_messages();
  if (!o.record.empty())
    if (Result<void> done = files::write_file(o.record, circuit::write_input_record(interpreter->recording())); !done)
      return print_error(done.error(), o.json);

  Json outputs = Json::object(), probes = Json::object(), timing = Json::array();
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
  const circuit::ProbeRows recorded = interpreter->probes();
  if (!o.probes.empty()) {
    Json times = Json::array(), values = Json::array();
    for (std::size_t i = 0; i < recorded.size(); ++i) {
      times.push_back(static_cast<double>(recorded.tick(i)) * o.dt);
      values.push_back(numbers_json(recorded.numbers(i)));
    }
    probes = {{"pins", o.probes}, {"time", times}, {"values", values}};
  }
  std::vector<circuit::Timing> timings_by_total = interpreter->timings();
  std::sort(timings_by_total.begin(), timings_by_total.end(),
            [](const circuit::Timing& a, const circuit::Timing& b) { return a.total > b.total; });
  for (const circuit::Timing& t : timings_by_total)
    timing.push_back({{"lsi", t.lsi}, {"runs", t.runs}, {"mean_ns", static_cast<double>(t.total) / static_cast<double>(t.runs)}});
  if (o.json) {
    Json out = {{"circuit", circuit->name},
                {"ticks", interpreter->ticks()},
                {"time_s", interpreter->time()},
                {"wall_s", wall},
                {"outputs", outputs}};
    if (!o.probes.empty()) out["probes"] = probes;
    if (o.timing) out["timing"] = timing;
    if (hit >= 0) out["breakpoint"] = {{"index", hit}, {"condition", o.breaks[static_cast<std::size_t>(hit)]}};
    print_json(out);
    return 0;
  }
  if (hit >= 0) print_line("Stopped at " + to_fixed(interpreter->time() - o.dt, 3) + " s: " + o.breaks[static_cast<std::size_t>(hit)]);
  print_line(circuit->name + ": " + std::to_string(interpreter->ticks()) + " ticks, " + to_fixed(interpreter->time(), 3) + " s");
  print_table(rows);
  for (const Json& t : timing)
    print_line(t.value("lsi", "") + "  " + to_fixed(t.value("mean_ns", 0.0), 1) + " ns, " +
               std::to_string(t.value("runs", std::uint64_t{0})) + " runs");
  return 0;
}

int guarded(const Options& o, int (*work)(const Options&)) {
  const Result<int> done =
      plugin::run_guarded([&] { return work(o); }, std::chrono::milliseconds(static_cast<std::int64_t>(o.patience * 1000)));
  return done ? *done : print_error(done.error(), o.json);
}

int run_run(const Options& o) { return guarded(o, run_inside); }

/// Builds circuits without running them and reports their errors.
int run_check(const Options& o) {
  return guarded(o, [](const Options& options) {
    const std::shared_ptr<plugin::LiveLibrary> live = open_libraries(options);
    Error problems;
    for (const std::string& path : options.targets) {
      Error found;
      if (const Result<circuit::Circuit> circuit = load_circuit(path); !circuit) {
        found = circuit.error();
      } else if (Result<Interpreter> made =
                     Interpreter::build(*circuit, *live->library(), nullptr,
                                        {.dt = options.dt, .check_finite = true, .activity = &plugin::process_activity()});
                 !made) {
        found = std::move(made.error());
      }
      for (Problem& p : found.problems) {
        if (p.location.starts_with("circuit/")) p.location.replace(0, 7, path + ":");  // "circuit/..." becomes "FILE:..."
        problems.problems.push_back(std::move(p));
      }
      if (found.empty() && !options.json) print_line("good  " + path);
    }
    if (!problems.empty()) return print_error(problems, options.json);
    if (options.json) print_json({{"good", true}, {"circuits", options.targets.size()}});
    return 0;
  });
}

int run_test(const Options& o) {
  return guarded(o, [](const Options& options) {
    const std::shared_ptr<plugin::LiveLibrary> live = open_libraries(options);
    int failed = 0;
    for (const std::string& path : options.targets) {
      const Result<std::string> text = files::read_file(path);
      const Result<circuit::Example> example = text ? circuit::read_example(*text, path) : fail(text.error());
      const Result<void> passed = example ? circuit::check_example(*example, *live->library(), path) : fail(example.error());
      if (!passed)
        failed = print_error(passed.error(), false);
      else if (!options.json)
        print_line("passed  " + path);
    }
    if (options.json) print_json({{"tests", options.targets.size()}, {"passed", failed == 0}});
    return failed;
  });
}

int run_lsis(const Options& o) {
  return guarded(o, [](const Options& options) {
    print_line(json::to_text(circuit::library_json(*open_libraries(options)->library()), 2));
    return 0;
  });
}

}  // namespace

void add_circuit_verb(CLI::App& app, Action& action) {
  auto options = std::make_shared<Options>();
  CLI::App* verb = app.add_subcommand("circuit", "Run, check and test circuits of software LSIs.");
  verb->require_subcommand(1);
  const auto add = [&](const char* name, const char* doc, const char* target, const char* example, int (*run)(const Options&)) {
    CLI::App* sub = verb->add_subcommand(name, doc);
    if (*target) sub->add_option("files", options->targets, target)->required();
    sub->add_option("--lsi", options->libraries, "A library of LSIs (*.so) to use without installing it");
    sub->add_option("--shelf", options->shelf, "Folder of installed libraries (default: $UGOKI_LSI or ~/.local/share/ugoki/lsi)");
    sub->add_option("--patience", options->patience, "Seconds that one LSI may run in a tick before the program stops it")
        ->check(CLI::Range(0.1, 3600.0))
        ->capture_default_str();
    sub->add_flag("--json", options->json, "Print one JSON object");
    sub->footer(std::string("Example:\n  ") + example);
    sub->callback([options, run, &action] { action = [options, run] { return run(*options); }; });
    return sub;
  };
  CLI::App* run = add("run", "Run a circuit and print its outputs.", "The circuit, *.json",
                      "ugoki circuit run counter.json --duration 2 --probe limit.out --json", run_run);
  run->add_option("--dt", options->dt, "Seconds between ticks")->check(CLI::Range(1e-9, 1e6))->capture_default_str();
  run->add_option("--duration", options->duration, "Seconds to run")->check(CLI::Range(0.0, 1e9))->capture_default_str();
  run->add_option("--probe", options->probes, "Record this output at each tick: id.pin");
  run->add_option("--every", options->every, "Record probes at each n-th tick only")->check(CLI::Range(1, 1000000));
  run->add_option("--set", options->sets, "Set a parameter: id.parameter=value");
  run->add_option("--input", options->inputs, "Set an input of the circuit: name=value or name=x,y,z");
  run->add_option("--break", options->breaks, "Stop when a condition becomes true: \"id.pin > 3\", \"id.pin[2] < 0\", \"id.pin changes\"");
  run->add_option("--record", options->record, "Record all external inputs to this file");
  run->add_option("--replay", options->replay, "Replay the inputs recorded in this file");
  run->add_option("--threads", options->threads, "Number of threads for independent LSIs")->check(CLI::Range(1, 64));
  run->add_option("--osc", options->osc, "Receive OSC on this UDP port of 127.0.0.1, for the LSIs `osc`")->check(CLI::Range(1, 65535));
  run->add_flag("--timing", options->timing, "Measure the time of each LSI");
  run->add_flag("--reload", options->reload, "Reload libraries that are rebuilt while the circuit runs");
  run->add_flag("--realtime", options->realtime, "Run at most in real time");
  add("check", "Report the errors of circuits.", "Circuits, *.json", "ugoki circuit check *.json", run_check);
  add("test", "Run examples with expected values (docs/lsi.md).", "Examples, *.test.json", "ugoki circuit test examples/lsi/*.test.json",
      run_test);
  add("lsis", "Print all LSIs that circuits may use, as JSON.", "", "ugoki circuit lsis", run_lsis);
  add_export_fmu(*verb, action);
}

}  // namespace ugoki::cli
