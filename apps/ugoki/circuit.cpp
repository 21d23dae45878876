// `ugoki circuit`: checks and tests circuits of software LSIs from the command line. `run` is in circuit_run.cpp.

#include <chrono>
#include <memory>

#include "circuit_run.h"
#include "fmu.h"
#include "output.h"
#include "ugoki/circuit/class_json.h"
#include "ugoki/circuit/example.h"
#include "ugoki/circuit/interpreter.h"
#include "ugoki/circuit/units.h"
#include "ugoki/files/files.h"
#include "ugoki/plugin/guard.h"
#include "verb.h"

namespace ugoki::cli {
namespace {

using circuit::Interpreter;

using Options = CircuitOptions;

int guarded(const Options& o, int (*work)(const Options&)) {
  const Result<int> done =
      plugin::run_guarded([&] { return work(o); }, std::chrono::milliseconds(static_cast<std::int64_t>(o.patience * 1000)));
  return done ? *done : print_error(done.error(), o.json);
}

/// Builds circuits without running them and reports their errors and warnings. Warnings do not change the exit status.
int run_check(const Options& o) {
  return guarded(o, [](const Options& options) {
    const std::shared_ptr<plugin::LiveLibrary> live = open_libraries(options);
    Error problems, warnings;
    for (const std::string& path : options.targets) {
      Error found, doubts;
      if (const Result<circuit::Circuit> circuit = load_circuit(path); !circuit) {
        found = circuit.error();
      } else if (Result<Interpreter> made =
                     Interpreter::build(*circuit, *live->library(), nullptr,
                                        {.dt = options.dt, .check_finite = true, .activity = &plugin::process_activity()});
                 !made) {
        found = std::move(made.error());
      } else {
        doubts.problems = circuit::check_units(*circuit, *live->library());
      }
      const auto move_to = [&path](Error& from, Error& to) {
        for (Problem& p : from.problems) {
          if (p.location.starts_with("circuit/")) p.location.replace(0, 7, path + ":");  // "circuit/..." becomes "FILE:..."
          to.problems.push_back(std::move(p));
        }
      };
      const bool good = found.empty();
      const std::size_t first = warnings.problems.size();
      move_to(found, problems);
      move_to(doubts, warnings);
      if (options.json) continue;
      for (std::size_t i = first; i < warnings.problems.size(); ++i) print_line("warning: " + warnings.problems[i].text());
      if (good) print_line("good  " + path);
    }
    if (!problems.empty()) return print_error(problems, options.json);
    if (options.json)
      print_json({{"good", true}, {"circuits", options.targets.size()}, {"warnings", json::error_json(warnings)["problems"]}});
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
      const Result<void> passed =
          example ? circuit::check_example(*example, *live->library(), path, nullptr, &plugin::process_activity()) : fail(example.error());
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
    print_json(circuit::library_json(*open_libraries(options)->library()));
    return 0;
  });
}

}  // namespace

void add_circuit_verb(Verb app, Action& action) {
  auto options = std::make_shared<Options>();
  Verb verb = app.add_subcommand("circuit", "Run, check and test circuits of software LSIs.");
  verb.require_subcommand(1);
  const auto add = [&](const char* name, const char* doc, const char* target, const char* example, int (*run)(const Options&)) {
    Verb sub = verb.add_subcommand(name, doc);
    if (*target) sub.add_option("files", options->targets, target).required();
    sub.add_option("--lsi", options->libraries, "A library of LSIs (*.so) to use without installing it");
    sub.add_option("--shelf", options->shelf, "Folder of installed libraries (default: $UGOKI_LSI or ~/.local/share/ugoki/lsi)");
    sub.add_option("--patience", options->patience, "Seconds that one LSI may run in a tick before the program stops it")
        .check(range(0.1, 3600.0))
        .capture_default_str();
    sub.add_flag("--json", options->json, "Print one JSON object");
    sub.footer(std::string("Example:\n  ") + example);
    sub.callback([options, run, &action] { action = [options, run] { return run(*options); }; });
    return sub;
  };
  Verb run = add("run", "Run a circuit and print its outputs.", "The circuit, *.json",
                 "ugoki circuit run counter.json --duration 2 --probe limit.out --json", run_circuit);
  run.add_option("--dt", options->dt, "Seconds between ticks").check(number_from(1e-9, 1e6)).capture_default_str();
  run.add_option("--duration", options->duration, "Seconds to run").check(range(0.0, 1e9)).capture_default_str();
  run.add_option("--probe", options->probes, "Record this output at each tick: id.pin");
  run.add_option("--every", options->every, "Record probes at each n-th tick only").check(range(1, 1000000));
  run.add_option("--set", options->sets, "Set a parameter: id.parameter=value");
  run.add_option("--input", options->inputs, "Set an input of the circuit: name=value or name=x,y,z");
  run.add_option("--break", options->breaks, "Stop when a condition becomes true: \"id.pin > 3\", \"id.pin[2] < 0\", \"id.pin changes\"");
  run.add_option("--record", options->record, "Record all external inputs to this file");
  run.add_option("--replay", options->replay, "Replay the inputs recorded in this file");
  run.add_option("--threads", options->threads, "Number of threads for independent LSIs").check(range(1, 64));
  run.add_option("--osc", options->osc, "Receive OSC on this UDP port of 127.0.0.1, for the LSIs `osc`").check(range(1, 65535));
  run.add_flag("--timing", options->timing, "Measure the time of each LSI");
  run.add_flag("--reload", options->reload, "Reload libraries that are rebuilt while the circuit runs");
  run.add_flag("--realtime", options->realtime, "Run at most in real time");
  add("check", "Report the errors of circuits.", "Circuits, *.json", "ugoki circuit check *.json", run_check);
  add("test", "Run examples with expected values (docs/lsi.md).", "Examples, *.test.json", "ugoki circuit test examples/lsi/*.test.json",
      run_test);
  add("lsis", "Print all LSIs that circuits may use, as JSON.", "", "ugoki circuit lsis", run_lsis);
  add_export_fmu(verb, action);
}

}  // namespace ugoki::cli
