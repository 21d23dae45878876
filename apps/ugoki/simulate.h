#pragma once
// Running content to its end, measured: what `run` and `judge` share.

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/content/player.h"

namespace ugoki::cli {

struct CharacterReport {
  std::string id, name;
  double mass = 0;  ///< kg
  bool tracks = false;
  content::PlayerMeasures measures;
  std::vector<std::string> links;  ///< names
};

struct RunReport {
  std::string name;
  double duration = 0;  ///< s simulated
  std::uint64_t steps = 0;
  double step = 0;         ///< s
  double frame_rate = 60;  ///< display frames a second
  double wall = 0;         ///< s spent in steps alone
  double processor = 0;    ///< s of processor time in steps alone: less than `wall` on a busy machine
  std::uint64_t state_hash = 0;
  std::vector<CharacterReport> characters;
  std::vector<content::PlayerTouch> touches;  ///< that began or ended, at most most_touches
  std::uint64_t touch_count = 0;              ///< all of them
  static constexpr std::size_t most_touches = 10'000;

  /// The worst of all characters that follow a track; of all if none does.
  [[nodiscard]] content::PlayerMeasures worst() const;
  [[nodiscard]] double steps_per_second() const { return wall > 0 ? static_cast<double>(steps) / wall : 0; }
  [[nodiscard]] double realtime_factor() const { return wall > 0 ? duration / wall : 0; }
  [[nodiscard]] double processor_realtime_factor() const { return processor > 0 ? duration / processor : 0; }
};

struct RunOptions {
  double duration = 0;  ///< s; 0: the content's
  std::string frames;   ///< file for display frames; empty: none
};

/// Runs executable data from its beginning, with a progress bar; Ctrl+C ends it without a half-written file.
[[nodiscard]] Result<RunReport> simulate(std::span<const std::byte> ugx, const std::string& name, const RunOptions& options);

/// Does `work`; where libraries of LSIs are installed, which content may use, in a process that they cannot take along.
/// @return exit status
int with_libraries(bool as_json, const std::function<int()>& work);

}  // namespace ugoki::cli
