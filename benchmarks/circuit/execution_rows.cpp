// Overhead of the circuit of the sample content: the interpreter is compared with a hand-written loop of the same calls in the same order.
// The loop has its own memory; it has no checks, names or rates.

#include <cstring>

#include "table.h"
#include "ugoki/circuit/machine.h"
#include "ugoki/content/generate.h"
#include "ugoki/content/player.h"
#include "ugoki/content/scenario.h"
#include "ugoki/lsi/standard_library.h"
#include "ugoki/samples/samples.h"

namespace ugoki::benchmarks {
namespace {

using Machine = circuit::Interpreter::Machine;

void require(bool good, const std::string& what) {
  if (!good) throw std::runtime_error(what);
}

content::Player open_sample() {
  const samples::Sample sample = samples::make_sample();
  const Result<content::Scenario> scenario = content::read_scenario(sample.document, "sample");
  require(scenario.has_value(), "the sample cannot be read");
  const Result<std::vector<std::byte>> ugx = content::generate(*scenario, sample.resources);
  require(ugx.has_value(), "the sample cannot be generated");
  Result<content::Player> player = content::Player::open(*ugx);
  require(player.has_value(), "the sample cannot be played");
  return std::move(*player);
}

/// One tick as a hand-written loop.
void tick_by_hand(Machine& m) {
  for (const circuit::Job& job : m.jobs)
    if (job.every == 1 || m.tick.index % job.every == 0) job.run(job.call);
  std::memcpy(m.bytes() + m.front.begin, m.bytes() + m.back.begin, m.front.size());
  ++m.tick.index;
  m.tick.time = static_cast<double>(m.tick.index) * m.tick.dt;
}

void rows(Table& table) {
  content::Player player = open_sample();
  const Result<circuit::Circuit> circuit = circuit::read_circuit(player.content().circuit);
  require(circuit.has_value(), "the circuit cannot be read");
  Error problems;
  const circuit::BuildOptions options{.dt = player.step_size(), .check_finite = true};
  circuit::FlatCircuit flat = circuit::flatten(*circuit, lsi::standard_library(), problems);
  circuit::Plan plan = circuit::make_plan(flat, &player.world(), options.dt, problems);
  const std::unique_ptr<Machine> hand = circuit::make_machine(std::move(flat), std::move(plan), options, problems);
  require(problems.empty(), problems.text());
  circuit::Interpreter& ours = player.interpreter();

  constexpr int steps = 25;  // short, so that the minimum of many repetitions is not disturbed by other processes
  const auto run_ours = [&] {
    ours.reset();
    for (int i = 0; i < steps; ++i) ours.tick();
  };
  const auto run_hand = [&] {
    hand->initialise();
    for (int i = 0; i < steps; ++i) tick_by_hand(*hand);
  };
  run_ours();
  run_hand();
  const auto state = [](const circuit::PinView& v) { return std::vector<double>(v.numbers().begin(), v.numbers().end()); };
  const int status = hand->find_unit("status");
  require(status >= 0, "the circuit has no status");
  require_same(state(*ours.find_output("status.state")),
               state(hand->view({status, hand->units[static_cast<std::size_t>(status)].lsi_class->find_output("state")})), 0,
               "execution circuit");
  const std::vector<double> ns = measure({run_ours, run_hand}, 6);
  table.add({"a tick of the sample's execution circuit", ns[0] / steps, "the same calls by hand", ns[1] / steps});
}

const RowRegistration registration(200, rows);

}  // namespace
}  // namespace ugoki::benchmarks
