// One simulation step of content in the WebAssembly player (headless Chromium) and in the native player, by processor time. "ratio" is the
// speed of WebAssembly relative to native code. The players run by turns, because the speed of a shared processor changes within seconds.

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cinttypes>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <stdexcept>

#include "contents.h"
#include "table.h"
#include "ugoki/base/number.h"
#include "ugoki/content/generate.h"
#include "ugoki/content/player.h"
#include "ugoki/files/files.h"
#include "ugoki/samples/samples.h"

namespace ugoki::benchmarks {
namespace {

constexpr long steps = 1000;
constexpr int rounds = 4;
constexpr int runs = 5;  // of each player in a round

struct Run {
  double seconds = std::numeric_limits<double>::infinity();  ///< minimum processor time of a run
  std::string hash;

  void take(const Run& other) { *this = {std::min(seconds, other.seconds), other.hash}; }
};

double processor_seconds() {
  rusage use{};
  ::getrusage(RUSAGE_SELF, &use);
  const auto seconds = [](const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); };
  return seconds(use.ru_utime) + seconds(use.ru_stime);
}

template <class T>
T required(Result<T> r) {
  if (!r) throw std::runtime_error(r.error().text());
  return std::move(*r);
}

Run run_native(content::Player& player) {
  Run out;
  for (int i = 0; i <= runs; ++i) {
    player.reset();
    const double before = processor_seconds();
    for (long k = 0; k < steps; ++k)
      if (const Result<void> done = player.step(); !done) throw std::runtime_error(done.error().text());
    if (i > 0) out.seconds = std::min(out.seconds, processor_seconds() - before);
  }
  std::array<char, 17> hash{};
  std::snprintf(hash.data(), hash.size(), "%016" PRIx64, player.state_hash());
  out.hash = hash.data();
  return out;
}

Run run_wasm(const std::string& file) {
  const std::string command = std::string("node '") + UGOKI_WASM_RUN + "' '" + UGOKI_WASM_PLAYER + "' '" + file + "' " +
                              std::to_string(steps) + " " + std::to_string(runs);
  std::FILE* answer = ::popen(command.c_str(), "r");
  if (answer == nullptr) throw std::runtime_error("Node.js, which starts the browser, cannot be started.");
  Run out;
  std::array<char, 17> hash{};
  const int read = std::fscanf(answer, "%lf %16s", &out.seconds, hash.data());
  if (::pclose(answer) != 0 || read != 2) throw std::runtime_error("The WebAssembly player failed; see the message above.");
  out.hash = hash.data();
  return out;
}

/// The sample's human alone, walking, with 1000 simulation steps per s.
golden::GoldenContent make_fine_walk() {
  const samples::Sample sample = samples::make_sample();
  content::Scenario s = required(content::read_scenario(sample.document, "sample"));
  std::erase_if(s.characters, [](const content::ScenarioCharacter& c) { return c.id != "human"; });
  s.events.clear();
  s.step = 0.001;
  return {"human", required(content::generate(s, sample.resources))};
}

void rows(Table& table) {
  std::vector<golden::GoldenContent> contents = golden::make_contents();
  contents.push_back(make_fine_walk());
  const std::filesystem::path file = std::filesystem::temp_directory_path() / ("ugoki-wasm-bench-" + std::to_string(::getpid()) + ".ugx");
  for (const golden::GoldenContent& c : contents) {
    if (!is_selected(c.name)) continue;
    content::Player player = required(content::Player::open(c.ugx, c.name));
    if (const Result<void> written = files::write_file(file.string(), std::span<const std::byte>(c.ugx)); !written)
      throw std::runtime_error(written.error().text());
    Run wasm, native;
    for (int round = 0; round < rounds; ++round) {
      wasm.take(run_wasm(file.string()));
      native.take(run_native(player));
      if (wasm.hash != native.hash) throw std::runtime_error(c.name + ": the states differ: " + wasm.hash + ", " + native.hash);
    }
    std::filesystem::remove(file);
    const double reserve = static_cast<double>(steps) * player.step_size() / wasm.seconds;
    table.add({c.name + ", " + to_fixed(1 / player.step_size(), 0) + " steps per s",
               1e9 * wasm.seconds / steps,
               "native player",
               1e9 * native.seconds / steps,
               0,
               {{"real_time_factor", reserve}},
               to_fixed(reserve, 1) + " x real time in WebAssembly"});
  }
}
const RowRegistration registration(100, rows);

}  // namespace
}  // namespace ugoki::benchmarks
