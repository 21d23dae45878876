#pragma once
// Runs executable data from beginning to end and measures it; shared by `run` and `judge`.

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/content/player.h"
#include "ugoki/naturalness/report.h"

namespace ugoki::plugin {
class LiveLibrary;
class ThreadPool;
}  // namespace ugoki::plugin

namespace ugoki::cli {

/// Results of a run for one character.
struct CharacterReport {
  std::string id, name;
  double mass = 0;      ///< mass of the character, kg
  bool tracks = false;  ///< true: the character follows a track by motion control
  content::PlayerMeasures measures;
  std::vector<std::string> links;  ///< names of the character's links
  naturalness::Report over_time;   ///< all measures over time, with RunOptions::over_time
  double capped_share = 0;         ///< share of the time until the release in which the root assist was at its limit
  double capped_from = -1;         ///< s, first time at which the root assist was at its limit; -1: never
  double assist_limit = 0;         ///< body weights
};

/// Results of a run.
struct RunReport {
  std::string name;
  double duration = 0;  ///< simulated time, s
  std::uint64_t steps = 0;
  double step = 0;         ///< step size of the dynamics, s
  double frame_rate = 60;  ///< display frames per second
  double wall = 0;         ///< wall-clock time spent in steps, s
  double processor = 0;    ///< processor time spent in steps, s; less than `wall` on a busy machine
  std::uint64_t state_hash = 0;
  std::vector<CharacterReport> characters;
  content::PlayerStepQuality quality;         ///< sum over all steps
  std::vector<content::PlayerTouch> touches;  ///< touches that began or ended; the first max_touches of them
  std::uint64_t touch_count = 0;              ///< number of all touches that began or ended
  static constexpr std::size_t max_touches = 10'000;

  /// For each measure, the worst value of all characters that follow a track. If none follows a track, the worst of all characters.
  [[nodiscard]] content::PlayerMeasures worst() const;
  [[nodiscard]] double steps_per_second() const { return wall > 0 ? static_cast<double>(steps) / wall : 0; }
  [[nodiscard]] double realtime_factor() const { return wall > 0 ? duration / wall : 0; }
  [[nodiscard]] double processor_realtime_factor() const { return processor > 0 ? duration / processor : 0; }
};

struct RunOptions {
  double duration = 0;      ///< simulated time of the run, s; 0: the duration of the content
  std::string frames;       ///< file to which display frames are written; empty: none
  std::string inputs;       ///< file of recorded inputs (docs/export.md); empty: none
  std::uint64_t steps = 0;  ///< number of steps, instead of `duration`; 0: use `duration`
  int threads = 1;          ///< number of threads; the result does not depend on it
  bool over_time = false;   ///< record the measures of naturalness over time
};

/// Runs executable data from the beginning, with a progress bar. Ctrl+C stops the run and returns an error; no incomplete file is left.
[[nodiscard]] Result<RunReport> simulate(std::span<const std::byte> ugx, const std::string& name, const RunOptions& options);

/// A player that may use the installed libraries of LSIs.
struct HostedPlayer {
  std::shared_ptr<plugin::LiveLibrary> libraries;  ///< the installed libraries; null: none is installed
  std::shared_ptr<plugin::ThreadPool> threads;     ///< threads of the simulation; null: the calling thread only
  content::Player player;
};
[[nodiscard]] Result<HostedPlayer> open_hosted(std::span<const std::byte> ugx, const std::string& name, int threads = 1);

/// Calls `work`. If libraries of LSIs are installed, calls it in a child process, so that a crash of a library is reported.
/// @return exit status of `work`
int with_libraries(bool as_json, const std::function<int()>& work);

}  // namespace ugoki::cli
