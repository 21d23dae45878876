// Writes golden contents as executable data, or prints their state hashes.
//   ugoki_golden_hashes contents FOLDER    writes FOLDER/NAME.ugx for each content
//   ugoki_golden_hashes hashes [STEPS]     prints hashes.txt, up to STEPS steps of each content

#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include "contents.h"
#include "ugoki/content/player.h"

int main(int count, char** arguments) {
  using namespace ugoki;
  if (count == 3 && std::strcmp(arguments[1], "contents") == 0) {
    for (const golden::GoldenContent& c : golden::make_contents()) {
      std::ofstream file(std::string(arguments[2]) + "/" + c.name + ".ugx", std::ios::binary);
      file.write(reinterpret_cast<const char*>(c.ugx.data()), static_cast<std::streamsize>(c.ugx.size()));
      if (!file) return 1;
    }
    return 0;
  }
  if (count < 2 || count > 3 || std::strcmp(arguments[1], "hashes") != 0) {
    std::fprintf(stderr, "usage: ugoki_golden_hashes contents FOLDER | hashes [STEPS]\n");
    return 2;
  }
  const long last = count == 3 ? std::atol(arguments[2]) : golden::checkpoints[std::size(golden::checkpoints) - 1];
  std::printf("# State hashes of the golden contents: name, steps, hash. How to renew them: docs/design/step.md.\n");
  for (const golden::GoldenContent& c : golden::make_contents()) {
    Result<content::Player> player = content::Player::open(c.ugx, c.name);
    for (const long checkpoint : golden::checkpoints) {
      if (checkpoint > last) break;
      while (player && player->step_count() < static_cast<std::uint64_t>(checkpoint))
        if (const Result<void> done = player->step(); !done) {
          std::fprintf(stderr, "%s: %s\n", c.name.c_str(), done.error().text().c_str());
          return 1;
        }
      if (!player) {
        std::fprintf(stderr, "%s: %s\n", c.name.c_str(), player.error().text().c_str());
        return 1;
      }
      std::printf("%s %ld %016" PRIx64 "\n", c.name.c_str(), checkpoint, player->state_hash());
    }
  }
  return 0;
}
