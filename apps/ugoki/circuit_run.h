#pragma once
// `ugoki circuit run`: runs a circuit of software LSIs in a guarded process and prints its outputs and probes.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/circuit/circuit.h"
#include "ugoki/plugin/live_library.h"

namespace ugoki::cli {

/// Options of the verbs of `ugoki circuit`.
struct CircuitOptions {
  std::vector<std::string> targets, libraries, probes, sets, inputs, breaks;
  std::string shelf, record, replay;
  double dt = 0.001, duration = 1, patience = 3;
  std::uint64_t every = 1;
  int threads = 1, osc = 0;
  bool timing = false, reload = false, realtime = false, json = false;
};

[[nodiscard]] Result<circuit::Circuit> load_circuit(const std::string& path);
/// Opens the standard library and the installed libraries of LSIs. Prints messages about them to stderr.
[[nodiscard]] std::shared_ptr<plugin::LiveLibrary> open_libraries(const CircuitOptions& o);

/// Runs the circuit as `ugoki circuit run` does. @return the exit status
int run_circuit(const CircuitOptions& o);

}  // namespace ugoki::cli
