#include "simulate.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <ctime>
#include <memory>

#include "output.h"
#include "ugoki/content/inputs.h"
#include "ugoki/files/files.h"
#include "ugoki/lsi/standard_library.h"
#include "ugoki/plugin/guard.h"
#include "ugoki/plugin/live_library.h"
#include "ugoki/plugin/shelf.h"
#include "ugoki/plugin/thread_pool.h"

namespace ugoki::cli {

content::PlayerMeasures RunReport::worst() const {
  const bool any_tracks = std::any_of(characters.begin(), characters.end(), [](const CharacterReport& c) { return c.tracks; });
  content::PlayerMeasures w;
  for (const CharacterReport& c : characters) {
    if (any_tracks && !c.tracks) continue;
    const content::PlayerMeasures& m = c.measures;
    w.tracking_rms_deg = std::max(w.tracking_rms_deg, m.tracking_rms_deg);
    w.assist_rms_bw = std::max(w.assist_rms_bw, m.assist_rms_bw);
    w.assist_force_rms_bw = std::max(w.assist_force_rms_bw, m.assist_force_rms_bw);
    w.assist_max_bw = std::max(w.assist_max_bw, m.assist_max_bw);
    w.foot_skate_cm = std::max(w.foot_skate_cm, m.foot_skate_cm);
    w.foot_skate_worst_cm = std::max(w.foot_skate_worst_cm, m.foot_skate_worst_cm);
    w.penetration_mm = std::max(w.penetration_mm, m.penetration_mm);
    w.penetration_rms_mm = std::max(w.penetration_rms_mm, m.penetration_rms_mm);
    w.fell = w.fell || m.fell;
    if (m.release_time >= 0) w.release_time = w.release_time < 0 ? m.release_time : std::min(w.release_time, m.release_time);
  }
  return w;
}

namespace {

/// Processor time used by all threads of this program, s.
double processor_time() {
  timespec t{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace

Result<HostedPlayer> open_hosted(std::span<const std::byte> ugx, const std::string& name, int threads) {
  content::PlayerOptions host;
  std::shared_ptr<plugin::LiveLibrary> libraries;
  if (!plugin::read_shelf(plugin::default_shelf()).empty()) {
    libraries = std::make_shared<plugin::LiveLibrary>(lsi::standard_library(), plugin::default_shelf());
    for (const std::string& m : libraries->take_messages()) print_message(m);
    host.library = libraries->library();
    host.activity = &plugin::process_activity();
  }
  std::shared_ptr<plugin::ThreadPool> pool;
  if (threads > 1) pool = std::make_shared<plugin::ThreadPool>(threads);
  host.executor = pool.get();
  Result<content::Player> player = content::Player::open(ugx, name, host);
  if (!player) return fail(std::move(player.error()));
  return HostedPlayer{std::move(libraries), std::move(pool), std::move(*player)};
}

Result<RunReport> simulate(std::span<const std::byte> ugx, const std::string& name, const RunOptions& options) {
  using Clock = std::chrono::steady_clock;
  Result<HostedPlayer> hosted = open_hosted(ugx, name, options.threads);
  if (!hosted) return fail(std::move(hosted.error()));
  content::Player* const player = &hosted->player;
  const content::Executable& content = player->content();
  RunReport report;
  report.name = content.name;
  report.step = player->step_size();
  report.frame_rate = content.frame_rate;
  const double duration = options.duration > 0 ? options.duration : content.duration;
  const auto steps = options.steps > 0 ? options.steps : static_cast<std::uint64_t>(std::llround(duration / report.step));
  if (!options.inputs.empty()) {
    const Result<std::string> text = files::read_file(options.inputs);
    if (!text) return fail(text.error());
    Result<std::vector<content::PlayerInput>> inputs = content::read_inputs(*text, content, options.inputs);
    if (!inputs) return fail(std::move(inputs.error()));
    player->schedule(std::move(*inputs));
  }
  const double frame_time = 1 / content.frame_rate;
  std::vector<std::byte> frames, encoded;
  content::DisplayFrame frame;
  std::vector<content::PlayerTouch> touches;
  std::uint32_t frame_number = 0;
  const auto record = [&] {
    player->display_frame(frame);
    content::encode_frame(frame, frame_number++, content::frame_simulate, encoded);
    frames.insert(frames.end(), encoded.begin(), encoded.end());
  };
  // naturalness updates its measures about 120 times per second (lsi/execution_circuit.cpp)
  const auto every = static_cast<std::uint64_t>(std::max(1.0, std::floor(1 / (120 * report.step) + 0.5)));
  std::vector<std::array<double, 3>> capped(content.characters.size(), {0, 0, -1});  // samples, of these at the limit, first time
  std::vector<naturalness::Recorder> recorders(options.over_time ? content.characters.size() : 0);
  catch_interrupt();
  Progress progress("run " + name);
  if (!options.frames.empty()) record();
  constexpr std::uint64_t chunk = 64;  // steps between two checks for Ctrl+C and updates of the progress bar
  for (std::uint64_t done = 0; done < steps;) {
    std::uint64_t until = std::min(steps, done + chunk);
    if (!options.frames.empty())
      until = std::clamp(static_cast<std::uint64_t>(std::llround(frame_number * frame_time / report.step)), done + 1, steps);
    const auto began = Clock::now();
    const double processor_began = processor_time();
    for (; done < until; ++done) {
      if (Result<void> good = player->step(); !good) return fail(std::move(good.error()));
      report.quality += player->step_quality();
      player->touches(touches);
      report.touch_count += touches.size();
      for (content::PlayerTouch& t : touches)
        if (report.touches.size() < RunReport::max_touches) report.touches.push_back(std::move(t));
      if (done % every == 0)
        for (std::size_t i = 0; i < capped.size(); ++i) {
          const content::PlayerMeasures m = player->measures(static_cast<int>(i));
          if (i < recorders.size()) recorders[i].add(m.now);
          if (m.release_time >= 0) continue;
          auto& [samples, full, first] = capped[i];
          samples += 1;
          if (m.assist_now_bw < 0.999 * content.characters[i].control.assist_limit) continue;
          full += 1;
          if (first < 0) first = player->time();
        }
    }
    report.wall += std::chrono::duration<double>(Clock::now() - began).count();
    report.processor += processor_time() - processor_began;
    if (!options.frames.empty() && static_cast<double>(done) * report.step >= frame_number * frame_time - 0.5 * report.step) record();
    if (interrupted()) return fail(interrupted_error());
    progress.show(static_cast<double>(done) / static_cast<double>(steps));
  }
  progress.clear();
  report.steps = player->step_count();
  report.duration = player->time();
  report.state_hash = player->state_hash();
  for (std::size_t i = 0; i < content.characters.size(); ++i) {
    const content::ExecutableCharacter& c = content.characters[i];
    report.characters.push_back({c.id,
                                 c.name,
                                 content.mechanisms[static_cast<std::size_t>(c.mechanism)]->mass(),
                                 c.control.mode != content::ControlMode::passive && !c.track.empty(),
                                 player->measures(static_cast<int>(i)),
                                 {},
                                 {}});
    report.characters.back().capped_share = capped[i][0] > 0 ? capped[i][1] / capped[i][0] : 0;
    report.characters.back().capped_from = capped[i][2];
    report.characters.back().assist_limit = c.control.assist_limit;
    if (options.over_time)
      report.characters.back().over_time =
          recorders[i].finish(report.characters.back().measures.totals, c.name, 1 / (static_cast<double>(every) * report.step));
    for (const Link& link : content.mechanisms[static_cast<std::size_t>(c.mechanism)]->links())
      report.characters.back().links.push_back(link.name);
  }
  if (!options.frames.empty())
    if (Result<void> written = files::write_file(options.frames, std::span<const std::byte>(frames)); !written)
      return fail(std::move(written.error()));
  return report;
}

int with_libraries(bool as_json, const std::function<int()>& work) {
  if (plugin::read_shelf(plugin::default_shelf()).empty()) return work();
  const Result<int> done = plugin::run_guarded(work);
  return done ? *done : print_error(done.error(), as_json);
}

}  // namespace ugoki::cli
