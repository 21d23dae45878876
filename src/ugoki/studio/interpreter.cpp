#include "ugoki/studio/interpreter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "ugoki/base/check.h"
#include "ugoki/base/hash.h"
#include "ugoki/base/number.h"
#include "ugoki/content/display_frame.h"
#include "ugoki/json/json.h"
#include "ugoki/studio/frame.h"

namespace ugoki::studio {
namespace {

using Json = nlohmann::json;

constexpr double display_rate = 60;      // ticks of the display per second
constexpr double slice_seconds = 0.004;  // maximum time in one call of work(), s: a quarter of a display tick, so requests wait little
constexpr double max_lag = 0.25;         // s; when playing lags behind the clock by more than this, it slows down and does not catch up
constexpr double cheap_seconds = 3;      // maximum time for recomputing the simulation after an edit, s; otherwise it starts at 0
constexpr double transport_period = 0.5, summary_period = 0.25;  // times between two reports, s

Error make_error(ErrorCode code, std::string location, std::string message, std::string remedy) {
  return {code, std::move(location), std::move(message), std::move(remedy)};
}

/// True if simulating `seconds` of content takes at most cheap_seconds of clock time. It is then done without asking the user.
bool is_cheap_to(double seconds, double realtime_factor) { return seconds <= cheap_seconds * realtime_factor; }

}  // namespace

Interpreter::Interpreter(SimulationOpener opener, InterpreterSink& sink, std::function<double()> seconds)
    : opener_(opener), sink_(sink), seconds_(std::move(seconds)) {}

std::int64_t Interpreter::step_at(double time) const { return std::llround(time / simulation_->step_size()); }
double Interpreter::time_of(std::int64_t step) const { return static_cast<double>(step) * simulation_->step_size(); }
double Interpreter::head_time() const { return time_of(simulation_->step_count()); }
double Interpreter::simulated() const { return simulation_ ? head_time() : 0; }

std::uint64_t Interpreter::head_digest() const {
  std::vector<std::byte> state;
  if (simulation_) simulation_->save(state);
  Hash64 hash;
  hash.add_bytes(state.data(), state.size());
  return hash.value();
}

double Interpreter::realtime_factor() const {
  constexpr double unknown = 10;  // speed, as a multiple of real time, that is assumed until steps have been measured
  return computed_seconds_ > 0 && simulation_ ? computed_steps_ * simulation_->step_size() / computed_seconds_ : unknown;
}

Result<void> Interpreter::require_content() const {
  if (simulation_) return {};
  return fail(make_error(ErrorCode::structure, "transport", "No content is loaded.", "Fix the errors listed in the log, then play again."));
}

Result<void> Interpreter::load(std::span<const std::byte> executable) {
  Result<std::unique_ptr<Simulation>> opened = opener_(executable);
  if (!opened) return fail(std::move(opened.error()));
  const bool same_cast = simulation_ && simulation_->cast() == (*opened)->cast() && simulation_->step_size() == (*opened)->step_size();
  const std::vector<LiveInput> inputs = same_cast && recording_ ? recording_->inputs() : std::vector<LiveInput>();
  const double pace = realtime_factor();
  const bool was_playing = playing_;

  attach_circuit(nullptr);
  simulation_ = std::move(*opened);
  attach_circuit(simulation_->circuit());
  closest_pairs_.reset();
  begin_recording();
  for (const LiveInput& input : inputs) recording_->add_input(input);
  shown_ = std::clamp(shown_, 0.0, simulation_->duration());
  playing_ = was_playing;
  status_ = playing_ ? "playing" : "ready";
  if (mode_ == PlayMode::edit) {
    show_edit(shown_);
  } else if (is_cheap_to(shown_, pace)) {
    set_goal(Goal::seek, step_at(shown_));
  } else {
    playing_ = false;
    show_head();
    sink_.message(
        Json{{"event", "log"}, {"level", "info"}, {"text", "The content was changed. Its simulation starts again at 0 s."}}.dump());
  }
  anchor();
  report_transport();
  report_devices();
  return {};
}

Result<void> Interpreter::set_mode(PlayMode mode) {
  if (Result<void> r = require_content(); !r) return r;
  if (mode == mode_) return {};
  mode_ = mode;
  playing_ = false;
  goal_ = Goal::none;
  status_ = "ready";
  if (mode_ == PlayMode::edit) {
    show_edit(shown_);
  } else if (shown_ <= head_time() + 0.5 * simulation_->step_size()) {
    show_recorded(shown_);
  } else if (!blown_up_ && is_cheap_to(shown_ - head_time(), realtime_factor())) {
    set_goal(Goal::seek, step_at(shown_));
  } else {
    show_head();  // playing continues at the end of the recording
  }
  report_transport();
  return {};
}

Result<void> Interpreter::play(std::optional<double> speed) {
  if (Result<void> r = require_content(); !r) return r;
  if (speed) {
    if (!(*speed >= min_play_speed && *speed <= max_play_speed)) {
      return fail(make_error(ErrorCode::range, "speed", "The speed must be from 0.05 to 8.", "1 is real time."));
    }
    speed_ = *speed;
  }
  if (blown_up_ && shown_ >= head_time()) {
    return fail(make_error(ErrorCode::structure, "transport", "The simulation cannot continue: " + status_,
                           "Restart the simulation, or change the content."));
  }
  if (shown_ >= play_end() - 0.5 * simulation_->step_size()) return_to_begin();
  if (mode_ == PlayMode::simulate && !playing_ && goal_ == Goal::none && breakpoints_.active())
    if (Result<void> r = rewind_to_shown(); !r) return r;
  if (goal_ == Goal::tick) goal_ = Goal::none;
  playing_ = true;
  status_ = "playing";
  anchor();
  report_transport();
  return {};
}

Result<void> Interpreter::pause() {
  if (Result<void> r = require_content(); !r) return r;
  goal_ = Goal::none;
  if (playing_ || status_ == "simulating") {
    playing_ = false;
    status_ = "paused";
    if (mode_ == PlayMode::simulate && shown_ >= head_time() - 1.5 * simulation_->step_size())
      show_head();
    else if (mode_ == PlayMode::simulate)
      show_recorded(shown_);
    else
      show_edit(shown_);
  }
  report_transport();
  report_summary();
  return {};
}

Result<void> Interpreter::step_frames(int frames) {
  if (Result<void> r = require_content(); !r) return r;
  playing_ = false;
  const double now = goal_ == Goal::seek ? time_of(goal_step_) : shown_;
  return seek((std::round(now * simulation_->frame_rate()) + frames) / simulation_->frame_rate());
}

Result<void> Interpreter::seek(double time) {
  if (Result<void> r = require_content(); !r) return r;
  if (!std::isfinite(time))
    return fail(make_error(ErrorCode::range, "time", "The time to seek must be a finite number.", "Give the time in seconds."));
  const double to = std::clamp(time, 0.0, simulation_->duration());
  goal_ = Goal::none;
  status_ = playing_ ? "playing" : "paused";
  if (mode_ == PlayMode::edit) {
    show_edit(to);
  } else if (step_at(to) <= simulation_->step_count()) {
    show_recorded(to);
  } else if (blown_up_) {
    show_head();
    status_ = "stopped";
  } else {
    set_goal(Goal::seek, step_at(to));
  }
  anchor();
  report_transport();
  return {};
}

Result<void> Interpreter::restart() {
  if (Result<void> r = require_content(); !r) return r;
  goal_ = Goal::none;
  recording_->truncate(0);
  measures_sent_ = 0;
  measures_cut_ = true;
  if (Result<void> r = simulation_->restore(recording_->checkpoint_before(0).state); !r) return r;
  watch_.changed();
  breakpoints_.rearm();
  next_input_ = 0;
  quality_step_ = 0;
  replay_until_ = 0;
  held_.mouse.wheel = 0;
  blown_up_ = false;
  shown_ = 0;
  status_ = playing_ ? "playing" : "ready";
  mode_ == PlayMode::edit ? show_edit(0) : show_head();
  anchor();
  report_transport();
  report_summary();
  return {};
}

std::vector<std::string> Interpreter::change_library() {
  if (!simulation_) return {"The installed LSIs changed."};
  attach_circuit(nullptr);  // the watched outputs belong to the circuit that is replaced
  Result<std::vector<std::string>> kept = simulation_->change_library();
  attach_circuit(simulation_->circuit());
  if (!kept)
    return {"The installed LSIs changed and no longer fit the content. The content continues with the old ones. " + kept.error().text()};
  if (blown_up_) {  // the new library may have fixed the failed LSI: allow playing to continue from the last good state
    blown_up_ = false;
    status_ = playing_ ? "playing" : "ready";
  }
  // Old checkpoints have the state layout of the old LSIs. Replace them by the new initial state and the state at the head.
  std::vector<std::byte> first, head;
  simulation_->save(head);
  simulation_->reset();
  simulation_->save(first);
  if (Result<void> r = simulation_->restore(head); !r) return {r.error().text()};
  recording_->replace_checkpoints(std::move(first), simulation_->step_count(), std::move(head));
  report_transport();
  report_devices();
  std::vector<std::string> sentences = {"The installed LSIs changed. The content continues with the new ones."};
  sentences.insert(sentences.end(), kept->begin(), kept->end());
  return sentences;
}

void Interpreter::begin_recording() {
  recording_.emplace(simulation_->step_size(), simulation_->frame_rate(), static_cast<int>(simulation_->cast().size()));
  blown_up_ = false;
  goal_ = Goal::none;
  next_input_ = 0;
  replay_until_ = 0;
  quality_ = {};
  quality_step_ = 0;
  measures_sent_ = 0;
  measures_cut_ = true;
  record_head();
}

Result<void> Interpreter::truncate(std::int64_t step) {
  const Recording::Checkpoint& checkpoint = recording_->checkpoint_before(step);
  if (Result<void> r = simulation_->restore(checkpoint.state); !r) return r;
  watch_.changed();
  if (checkpoint.step == 0) breakpoints_.rearm();
  next_input_ = recording_->first_input(checkpoint.step);
  recording_->truncate(step);
  if (recording_->frame_count() < measures_sent_) {
    measures_sent_ = recording_->frame_count();
    measures_cut_ = true;
  }
  blown_up_ = false;
  while (simulation_->step_count() < step) {
    if (!advance_head()) return fail(make_error(ErrorCode::structure, "transport", status_, "Restart the simulation."));
  }
  quality_step_ = step;
  return {};
}

bool Interpreter::advance_head() {
  apply_due_inputs();
  if (Result<void> r = simulation_->step(); !r) {
    stop(r.error());
    return false;
  }
  watch_.stepped();
  count_quality();
  if (playing_ && goal_ != Goal::seek) report_touches();
  record_head();
  if (recording_->full()) {
    stop(make_error(ErrorCode::range, "recording", "The recording is full (1 GiB).", "Restart the simulation."));
    return false;
  }
  return true;
}

void Interpreter::record_head() {
  const std::int64_t step = simulation_->step_count();
  if (recording_->checkpoint_due(step)) simulation_->save(recording_->add_checkpoint(step));
  if (step < recording_->next_frame_step()) return;
  simulation_->encode_frame(frame_);
  const auto characters = static_cast<int>(simulation_->cast().size());
  std::vector<std::uint8_t> feet;
  std::vector<MomentMeasures> measures;
  for (int c = 0; c < characters; ++c) {
    feet.push_back(simulation_->feet_on_ground(c));
    measures.push_back(simulation_->moment(c));
  }
  set_frame_header(frame_, time_of(step), 0, 0);
  recording_->add_frame(frame_, feet, measures);
}

void Interpreter::set_goal(Goal goal, std::int64_t step) {
  goal_ = goal;
  goal_step_ = step;
  if (goal == Goal::seek) status_ = "simulating";
}

bool Interpreter::work_on_goal() {
  const double begin = seconds_();
  const std::int64_t first = simulation_->step_count();
  double now = begin;
  bool good = true;
  if (goal_ == Goal::tick) {
    apply_due_inputs();
    good = first < replay_until_ || record_held_devices().has_value();
  }
  breakpoint_met_ = false;
  while (good && !breakpoint_met_ && simulation_->step_count() < goal_step_ && now - begin < slice_seconds) {
    good = advance_head();
    breakpoint_met_ = good && goal_ == Goal::tick && breakpoints_.met();
    now = seconds_();
  }
  // Exponential average of the pace, over about the last second of computing.
  const double fade = computed_seconds_ > 1 ? 0.98 : 1;
  computed_seconds_ = computed_seconds_ * fade + (now - begin);
  computed_steps_ = computed_steps_ * fade + static_cast<double>(simulation_->step_count() - first);
  summary_due_ = true;
  return !good || breakpoint_met_ || simulation_->step_count() >= goal_step_;
}

double Interpreter::work() {
  constexpr double never = std::numeric_limits<double>::infinity();
  if (!simulation_) return never;
  if (goal_ == Goal::seek) {
    if (work_on_goal()) {
      goal_ = Goal::none;
      if (!blown_up_) status_ = playing_ ? "playing" : "paused";
      show_head();
      anchor();
      report_transport();
      report_summary();
    } else {
      report_in_time();
      report_values();
      return 0;
    }
  }
  const double values_wait = report_values();
  if (!playing_) {
    if (summary_due_ && seconds_() - summary_reported_ >= summary_period) report_summary();
    return std::min(summary_due_ ? summary_period : never, values_wait);
  }

  const double due = anchor_seconds_ + static_cast<double>(ticks_) / display_rate;
  const double now = seconds_();
  if (goal_ != Goal::tick) {
    if (now < due) {
      report_in_time();
      return due - now;
    }
    if (now - due > max_lag) anchor();  // computing is slower than the clock: continue from the shown time
    tick();
  }
  if (goal_ == Goal::tick && work_on_goal()) {
    goal_ = Goal::none;
    if (breakpoint_met_) {
      playing_ = false;
      status_ = "paused";
    }
    show_head();
    if (breakpoint_met_) {
      report_transport();
      report_breakpoint();
      report_summary();
    } else if (shown_ >= play_end() - 0.5 * simulation_->step_size()) {
      finish_play();
    }
  }
  report_in_time();
  return 0;
}

void Interpreter::tick() {
  const double end = play_end();
  const double time = std::min(anchor_time_ + static_cast<double>(ticks_) / display_rate * speed_, end);
  ++ticks_;
  const bool last = time >= end;
  if (mode_ == PlayMode::edit) {
    show_edit(time);
    if (last) finish_play();
  } else if (step_at(time) <= simulation_->step_count()) {
    show_recorded(time);
    if (last) finish_play();
  } else if (blown_up_) {
    show_head();
    finish_play();
  } else {
    set_goal(Goal::tick, step_at(time));
  }
}

void Interpreter::show_edit(double time) {
  shown_ = time;
  simulation_->encode_pose(time, frame_);
  send(frame_, time, false);
}

void Interpreter::show_recorded(double time) {
  // After the last recorded frame only the state at the head can be shown.
  if (step_at(time) > recording_->step_of_frame(recording_->frame_count() - 1) && step_at(time) == simulation_->step_count())
    return show_head();
  if (!playing_) {
    const std::span<const std::byte> kept = recording_->frame(recording_->frame_near(time));
    frame_.assign(kept.begin(), kept.end());
    shown_ = frame_time(frame_);
    return send(frame_, shown_, false);
  }
  // Slow motion, for example, shows times between two recorded frames: interpolate the poses.
  const double position = std::clamp(time * recording_->rate(), 0.0, static_cast<double>(recording_->frame_count() - 1));
  const auto before = static_cast<std::size_t>(position);
  const std::span<const std::byte> kept = recording_->frame(before);
  frame_.assign(kept.begin(), kept.end());
  if (before + 1 < recording_->frame_count()) blend_poses(frame_, recording_->frame(before + 1), position - static_cast<double>(before));
  shown_ = time;
  send(frame_, time, false);
}

void Interpreter::show_head() {
  shown_ = head_time();
  simulation_->encode_frame(frame_);
  send(frame_, shown_, true);
}

void Interpreter::send(std::span<std::byte> bytes, double time, bool live) {
  std::uint32_t flags = playing_ ? content::frame_playing : 0u;
  if (mode_ == PlayMode::simulate) flags |= content::frame_simulate | (live ? content::frame_live : 0u);
  set_frame_header(bytes, time, static_cast<std::uint32_t>(time * simulation_->frame_rate() + 0.5), flags);
  if (show_closest_ && !closest_pairs_) closest_pairs_ = std::make_unique<ClosestPairs>(simulation_->mechanisms());
  sink_.frame(show_closest_ ? closest_pairs_->append_to(bytes) : bytes);
}

void Interpreter::report_touches() {
  constexpr int max_touches = 40;  // messages between two summaries, so that a falling heap of bodies does not flood the log
  for (const std::string& touch : simulation_->touches()) {
    if (++touches_reported_ > max_touches) return;
    sink_.message(Json{{"event", "log"}, {"level", "info"}, {"text", touch}}.dump(-1, ' ', false, Json::error_handler_t::replace));
  }
}

void Interpreter::count_quality() {
  const std::int64_t step = simulation_->step_count();
  if (step <= quality_step_) return;
  quality_step_ = step;
  if (quality_.substeps == 0) quality_begin_ = time_of(step - 1);
  quality_ += simulation_->step_quality();
}

/// Logs how many groups of contacts were not solved, how many stages of steps failed, and how many steps were split, if any is not zero.
void Interpreter::report_quality() {
  constexpr double period = 1;  // s: minimum time between two messages while playing, so that a large heap does not flood the log
  const bool faulty = quality_.not_converged + quality_.failures > 0;
  if (!faulty && quality_.split_steps == 0) return;
  if (playing_ && quality_reported_ >= 0 && seconds_() - quality_reported_ < period) return;
  std::string text = to_fixed(quality_begin_, 2) + " to " + to_fixed(head_time(), 2) + " s: ";
  if (faulty)
    text += std::to_string(quality_.not_converged) + " groups of contacts were not solved to the tolerance and " +
            std::to_string(quality_.failures) + " stages of steps failed; a shorter step may help. ";
  text += std::to_string(quality_.split_steps) + " steps were split into substeps.";
  sink_.message(Json{{"event", "log"}, {"level", faulty ? "warning" : "info"}, {"text", text}}.dump());
  quality_reported_ = seconds_();
  quality_ = {};
}

void Interpreter::anchor() {
  anchor_seconds_ = seconds_();
  anchor_time_ = shown_;
  ticks_ = 1;  // the next tick shows the frame after this one
}

double Interpreter::play_end() const {
  const double duration = simulation_->duration();
  return shown_ <= range_to_ + 0.5 * simulation_->step_size() ? std::min(range_to_, duration) : duration;
}

double Interpreter::play_begin() const { return range_from_ < std::min(range_to_, simulation_->duration()) ? range_from_ : 0; }

void Interpreter::set_range(double from, double to, bool loop) {
  range_from_ = std::max(0.0, from);
  range_to_ = to;
  loop_ = loop;
  if (simulation_) report_transport();
}

/// Shows the begin of the range. In simulate mode, a begin after the head becomes a goal that the simulation is computed up to.
void Interpreter::return_to_begin() {
  const double begin = play_begin();
  if (mode_ == PlayMode::edit) {
    show_edit(begin);
  } else if (step_at(begin) <= simulation_->step_count()) {
    shown_ = begin;
    show_recorded(begin);
  } else {
    set_goal(Goal::seek, step_at(begin));
  }
}

void Interpreter::finish_play() {
  const bool stopped = blown_up_ && mode_ == PlayMode::simulate;
  if (loop_ && !stopped) {
    return_to_begin();
    if (mode_ == PlayMode::simulate && goal_ == Goal::none && breakpoints_.active())
      if (Result<void> r = rewind_to_shown(); !r) return stop(r.error());
    anchor();
    report_transport();
    return report_summary();
  }
  playing_ = false;
  if (stopped)
    report_stop();  // repeated, so that the user sees why the recording ends here
  else
    status_ = "end";
  report_transport();
  report_summary();
}

void Interpreter::stop(const Error& error) {
  blown_up_ = true;
  playing_ = false;
  stop_ = error;
  report_stop();
  report_transport();
}

void Interpreter::report_stop() {
  status_ = stop_.text();
  while (!status_.empty() && status_.back() == '\n') status_.pop_back();
  const Json event{{"event", "stopped"}, {"reason", status_}, {"problems", json::error_json(stop_)["problems"]}};
  sink_.message(event.dump(-1, ' ', false, Json::error_handler_t::replace));
}

void Interpreter::watch(WatchRequest request) {
  const bool other = request.closest != show_closest_;
  show_closest_ = request.closest;
  watch_.set(std::move(request));
  if (!other || !simulation_ || playing_) return;
  if (mode_ == PlayMode::edit)
    show_edit(shown_);
  else
    show_recorded(shown_);
}

double Interpreter::report_values() {
  if (!watch_.dirty()) return std::numeric_limits<double>::infinity();
  const double now = seconds_();
  if (const double wait = values_reported_ + CircuitWatch::period - now; wait > 0 && wait <= CircuitWatch::period) return wait;
  values_reported_ = now;
  sink_.message(watch_.report(now));
  return std::numeric_limits<double>::infinity();
}

void Interpreter::report_in_time() {
  const double now = seconds_();
  if (now - transport_reported_ >= transport_period) report_transport();
  if (summary_due_ && now - summary_reported_ >= summary_period) report_summary();
}

}  // namespace ugoki::studio
