// Writes the sample content as executable data, runs it natively and prints state hashes.
// The WebAssembly player must give the same hashes.
//   ugoki_wasm_reference SAMPLE.ugx STEPS EVERY     prints "step hash" for each checkpoint

#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "ugoki/content/generate.h"
#include "ugoki/content/player.h"
#include "ugoki/samples/samples.h"

namespace {

int failed(const ugoki::Error& error) {
  std::fprintf(stderr, "%s\n", error.text().c_str());
  return 1;
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 4) {
    std::fprintf(stderr, "usage: ugoki_wasm_reference SAMPLE.ugx STEPS EVERY\n");
    return 2;
  }
  const long steps = std::atol(arguments[2]), every = std::atol(arguments[3]);
  if (steps < 1 || every < 1) return 2;
  using namespace ugoki;
  const samples::Sample sample = samples::make_sample();
  const Result<content::Scenario> scenario = content::read_scenario(sample.document, "sample");
  if (!scenario) return failed(scenario.error());
  const Result<std::vector<std::byte>> ugx = content::generate(*scenario, sample.resources);
  if (!ugx) return failed(ugx.error());
  std::ofstream(arguments[1], std::ios::binary)
      .write(reinterpret_cast<const char*>(ugx->data()), static_cast<std::streamsize>(ugx->size()));

  Result<content::Player> player = content::Player::open(*ugx, "sample");
  if (!player) return failed(player.error());
  for (long step = 1; step <= steps; ++step) {
    if (const Result<void> done = player->step(); !done) return failed(done.error());
    if (step % every == 0 || step == steps) std::printf("%ld %016" PRIx64 "\n", step, player->state_hash());
  }
  return 0;
}
