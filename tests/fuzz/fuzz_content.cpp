// Fuzz targets of executable data (*.ugx): the reader, and the player for some steps.
#include <cmath>
#include <cstring>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "fuzz_targets.h"
#include "ugoki/base/check.h"
#include "ugoki/base/hash.h"
#include "ugoki/circuit/circuit.h"
#include "ugoki/content/default_circuit.h"
#include "ugoki/content/executable.h"
#include "ugoki/content/player.h"
#include "ugoki/content/ugx.h"

namespace ugoki {
namespace {

std::uint64_t load64(const std::vector<std::byte>& file, std::size_t at) {
  std::uint64_t x = 0;
  std::memcpy(&x, file.data() + at, 8);
  return x;
}
void store_hash(std::vector<std::byte>& file, std::size_t at, std::size_t begin, std::size_t size) {
  Hash64 hash;
  hash.add_bytes(file.data() + begin, size);
  const std::uint64_t sum = hash.value();
  std::memcpy(file.data() + at, &sum, 8);
}

/// The container with its size and all checksums corrected, so that the reader gets past these checks.
std::vector<std::byte> repaired(std::vector<std::byte> file) {
  if (file.size() < 64) return file;
  const std::uint64_t size = file.size();
  std::memcpy(file.data() + 16, &size, 8);
  const std::uint64_t count = load64(file, 8) >> 32;
  if (count > (size - 64) / 64) return file;
  for (std::size_t at = 64; at < 64 + 64 * count; at += 64) {
    const std::uint64_t begin = load64(file, at + 32), bytes = load64(file, at + 40);
    if (begin > size || bytes > size - begin) continue;
    if (std::memcmp(file.data() + at, "motion/", 7) == 0 && bytes >= 32) store_hash(file, begin + 24, begin + 32, bytes - 32);
    store_hash(file, at + 48, begin, bytes);
  }
  store_hash(file, 24, 64, 64 * count);
  return file;
}

/// Builds a container from an input that lists sections, each after a line "=====NAME".
std::vector<std::byte> assembled(std::string_view text) {
  constexpr std::string_view divider = "=====";
  content::UgxWriter writer;
  std::set<std::string, std::less<>> names;
  while (text.starts_with(divider)) {
    const std::size_t line = text.find('\n');
    if (line == std::string_view::npos) break;
    const std::string name(text.substr(divider.size(), line - divider.size()));
    text.remove_prefix(line + 1);
    const std::string_view section = text.substr(0, text.find(divider));
    text.remove_prefix(section.size());
    if (name.empty() || name.size() > 31 || !names.insert(name).second) continue;
    if (name == "placements") {  // the numbers are given as text
      std::vector<std::byte> numbers;
      for (std::size_t at = 0; at + 8 <= section.size(); at += 8) {
        const double x = std::strtod(std::string(section.substr(at, 8)).c_str(), nullptr);
        const auto* p = reinterpret_cast<const std::byte*>(&x);
        numbers.insert(numbers.end(), p, p + 8);
      }
      writer.add(name, std::move(numbers));
    } else if (name == "circuit" && section.starts_with("default")) {  // the generated circuit would fill most of an input
      writer.add(name, content::default_circuit({}));
    } else {
      writer.add(name, section);
    }
  }
  return repaired(writer.finish());
}

void check_error(const Error& error) {
  UGOKI_CHECK(!error.problems.empty());
  for (const Problem& p : error.problems) UGOKI_CHECK(!p.location.empty() && !p.message.empty());
}

}  // namespace

void fuzz_ugx(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto* begin = reinterpret_cast<const std::byte*>(data);
  const std::vector<std::byte> bytes = text.starts_with("=====") ? assembled(text) : repaired({begin, begin + size});
  const auto read = content::read_executable(bytes, "fuzz.ugx");
  if (!read) return check_error(read.error());
  UGOKI_CHECK(std::isfinite(read->duration) && read->step > 0 && read->frame_rate > 0 && is_finite(read->gravity));
  for (const content::ExecutableCharacter& c : read->characters) {
    UGOKI_CHECK(c.mechanism >= 0 && static_cast<std::size_t>(c.mechanism) < read->mechanisms.size());
    const Mechanism& mechanism = *read->mechanisms[static_cast<std::size_t>(c.mechanism)];
    UGOKI_CHECK(c.q0.size() == static_cast<std::size_t>(mechanism.nq()));
    for (const double x : c.q0) UGOKI_CHECK(std::isfinite(x));
    for (const content::ExecutableClip& clip : c.track) {
      UGOKI_CHECK(clip.motion >= 0 && static_cast<std::size_t>(clip.motion) < read->motions.size());
      UGOKI_CHECK(check_motion(*read->motions[static_cast<std::size_t>(clip.motion)], mechanism).empty());
    }
  }
  for (const content::ExecutableEvent& e : read->events) {
    UGOKI_CHECK(e.character >= 0 && static_cast<std::size_t>(e.character) < read->characters.size());
    const int mechanism = read->characters[static_cast<std::size_t>(e.character)].mechanism;
    UGOKI_CHECK(e.link >= 0 && e.link < read->mechanisms[static_cast<std::size_t>(mechanism)]->link_count());
  }
  if (const auto circuit = circuit::read_circuit(read->circuit, "fuzz.ugx, section circuit"); !circuit) check_error(circuit.error());
}

long ugx_runs = 0;

void fuzz_ugx_run(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto* begin = reinterpret_cast<const std::byte*>(data);
  const std::vector<std::byte> bytes = text.starts_with("=====") ? assembled(text) : repaired({begin, begin + size});
  auto player = content::Player::open(bytes, "fuzz.ugx");
  if (!player) return check_error(player.error());
  ++ugx_runs;
  content::DisplayFrame frame;
  for (int i = 0; i < 10; ++i) {
    if (const auto good = player->step(); !good) {
      check_error(good.error());
      break;
    }
    player->display_frame(frame);
  }
  UGOKI_CHECK(frame.characters.size() <= player->content().characters.size());
}

}  // namespace ugoki
