#pragma once
// Plays a simulation: transport, recording, seeking, live inputs. Independent of processes and sockets. The caller supplies the clock.
//
// Two modes: edit mode shows the poses of the tracks without physics; simulate mode computes the physics.
//
// In simulate mode one simulation is at the head (the end of the recording). The shown time may be before the head, for example while
// the user scrubs through recorded frames. Playing shows the recorded frames up to the head, then computes new steps there. A live input
// before the head discards the recording after the shown time: the last checkpoint before that time is restored, and the simulation is
// computed from there up to that time.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/circuit/devices.h"
#include "ugoki/studio/circuit_breakpoints.h"
#include "ugoki/studio/circuit_watch.h"
#include "ugoki/studio/closest_pairs.h"
#include "ugoki/studio/recording.h"
#include "ugoki/studio/simulation.h"

namespace ugoki::studio {

inline constexpr double min_play_speed = 0.05, max_play_speed = 8;  ///< limits of the playback speed; 1 is real time

/// Receives the interpreter's frames and messages. Implementations must not wait for a reader.
class InterpreterSink {
 public:
  virtual ~InterpreterSink() = default;
  virtual void frame(std::span<const std::byte> bytes) = 0;
  virtual void message(std::string json) = 0;  ///< an event of docs/studio-protocol.md
};

enum class PlayMode : std::uint8_t { edit, simulate };

class Interpreter {
 public:
  /// @param seconds returns the clock time, s; only differences are used
  Interpreter(SimulationOpener opener, InterpreterSink& sink, std::function<double()> seconds);

  /// Replaces the content by other executable data. The shown time is kept. In simulate mode the new content is simulated up to that
  /// time if this takes less than about 3 s; otherwise its simulation starts at 0. Recorded live inputs are kept if the characters
  /// and the step size are the same. On an error the old content stays.
  [[nodiscard]] Result<void> load(std::span<const std::byte> executable);

  [[nodiscard]] Result<void> set_mode(PlayMode mode);
  [[nodiscard]] Result<void> play(std::optional<double> speed);  ///< starts at time 0 if the end is shown
  [[nodiscard]] Result<void> pause();
  [[nodiscard]] Result<void> step_frames(int frames);  ///< moves the shown time by this number of display frames (< 0: back) and pauses
  /// Computes one step of dynamics from the shown time and pauses. A recorded step is recomputed with the recorded inputs.
  [[nodiscard]] Result<void> step_tick();
  [[nodiscard]] Result<void> seek(double time);
  [[nodiscard]] Result<void> restart();
  /// Reloads an installed LSI library that changed on disk and continues with its LSIs. @return sentences for the user's log
  [[nodiscard]] std::vector<std::string> change_library();
  /// Pulls a link by a spring to `target`. @param link the link's index (as text), name or label @param point [m] in the link's frame
  /// @param target [m] in the world frame
  [[nodiscard]] Result<void> grab(std::string_view character, std::string_view link, const Vec3& point, const Vec3& target);
  /// Moves the target of the current grab. @param target [m] in the world frame
  [[nodiscard]] Result<void> drag(const Vec3& target);
  [[nodiscard]] Result<void> release();
  /// Removes the pull that began at `time` [s] from the recorded inputs, because the scenario now contains it as an event.
  [[nodiscard]] Result<void> forget_pull(double time);
  /// Applies a constant force [N], world frame, at a link's centre of mass for `duration` [s]. @param link as for grab()
  [[nodiscard]] Result<void> push(std::string_view character, std::string_view link, const Vec3& force, double duration);
  /// Changes the state of keyboard, mouse and gamepads. The state is kept in every mode and applied to steps that are computed while
  /// playing. While recorded frames are shown, only pressing a key or button that the circuit reads has an effect: it discards the
  /// recording after the shown time.
  [[nodiscard]] Result<void> input(const circuit::DeviceChange& change);

  /// Sets the part of the scenario that play() plays. Playing begins at `from` if the shown time is at `to` or at the end of the content.
  /// At `to`, playing ends, or with `loop` continues at `from`. Beyond `to`, playing ends at the end of the content.
  /// @param to [s] infinity, or a time after the end: the end of the content
  void set_range(double from, double to, bool loop);

  /// Sends the measures of all recorded frames in the next events `measures`, for a page that has none of them.
  void resend_measures();

  /// Sends the event `recorded`: the joints of these links of a character in the recorded frames, as displacements from the neutral
  /// position.
  [[nodiscard]] Result<void> report_recorded(std::string_view character, const std::vector<std::string>& links);

  /// Sets which values of the running circuit are reported in events `values`.
  void watch(WatchRequest request);

  /// Sets the breakpoints (syntax: circuit::read_breakpoint). Playing stops after a step that meets a breakpoint and sends the event
  /// `breakpoint`. While a breakpoint is active, playing recomputes recorded steps. A breakpoint on an output that the circuit does not
  /// have becomes active when a circuit with this output is loaded.
  void set_breakpoints(std::vector<std::string> conditions);

  /// Does the work that is due, for a few milliseconds. @return time until more work is due, s; infinity: not before a call of another
  /// member function
  double work();

  [[nodiscard]] PlayMode mode() const { return mode_; }
  [[nodiscard]] bool playing() const { return playing_; }
  [[nodiscard]] double time() const { return shown_; }
  [[nodiscard]] double simulated() const;
  [[nodiscard]] std::uint64_t head_digest() const;  ///< hash of the whole simulation state at the head; for tests

 private:
  enum class Goal : std::uint8_t { none, tick, seek };

  [[nodiscard]] Result<void> require_content() const;
  [[nodiscard]] Result<LiveInput> link_input(std::string_view character, std::string_view link) const;
  [[nodiscard]] Result<void> live_input(LiveInput input);
  [[nodiscard]] Result<void> record_held_devices();
  [[nodiscard]] std::vector<std::size_t> pull_inputs(std::optional<std::int64_t> step) const;
  void report_pull(const std::vector<std::size_t>& indices);
  void apply(const LiveInput& input);
  void apply_due_inputs();
  [[nodiscard]] double realtime_factor() const;
  void attach_circuit(circuit::Interpreter* circuit);
  void log_warning(const std::string& warning);
  [[nodiscard]] Result<void> rewind_to_shown();
  void report_breakpoint();
  void begin_recording();
  [[nodiscard]] Result<void> truncate(std::int64_t step);
  [[nodiscard]] bool advance_head();  ///< computes one step; false: the simulation failed or the recording is full, and playing was stopped
  void record_head();
  void set_goal(Goal goal, std::int64_t step);
  bool work_on_goal();  ///< true: the step goal_step_ was reached or computing stopped before it
  void tick();
  void show_edit(double time);
  void show_recorded(double time);
  void show_head();
  void report_touches();
  void count_quality();
  void report_quality();
  void send(std::span<std::byte> bytes, double time, bool live);
  void anchor();
  void finish_play();
  void return_to_begin();
  [[nodiscard]] double play_begin() const;  ///< time at which playing starts, s
  [[nodiscard]] double play_end() const;    ///< time at which playing that has reached shown_ ends, s
  void report_measures();
  void stop(const Error& error);
  void report_stop();
  void report_transport();
  void report_summary();
  void report_devices();
  void report_in_time();
  /// Reports watched values if they are due. @return time until they are due, s; infinity: none changed
  double report_values();
  [[nodiscard]] std::int64_t step_at(double time) const;
  [[nodiscard]] double time_of(std::int64_t step) const;
  [[nodiscard]] double head_time() const;

  SimulationOpener opener_;
  InterpreterSink& sink_;
  std::function<double()> seconds_;

  std::unique_ptr<Simulation> simulation_;
  std::optional<Recording> recording_;
  PlayMode mode_ = PlayMode::edit;
  bool playing_ = false;
  bool blown_up_ = false;  ///< true: the step after the head failed, or the recording is full
  double speed_ = 1;
  double shown_ = 0;                                                            ///< time of the frame that the pages show, s
  double range_from_ = 0, range_to_ = std::numeric_limits<double>::infinity();  ///< s, see set_range()
  bool loop_ = false;                                                           ///< true: playing continues at the begin of the range
  std::size_t measures_sent_ = 0;                                               ///< number of recorded frames whose measures the pages have
  bool measures_cut_ = true;  ///< true: the pages have measures of frames that are no longer recorded
  Goal goal_ = Goal::none;
  std::int64_t goal_step_ = 0;  ///< step up to which the simulation is to be computed
  circuit::DeviceState held_;   ///< current state of keyboard, mouse and gamepads
  std::optional<circuit::DeviceUse> reported_devices_;
  std::size_t next_input_ = 0;                   ///< index of the first recorded input that the simulation has not applied yet
  double anchor_seconds_ = 0, anchor_time_ = 0;  ///< clock time and shown time from which display ticks are counted, s
  std::int64_t ticks_ = 0;                       ///< number of display ticks since anchor_seconds_
  double computed_seconds_ = 0;                  ///< clock time spent in recent steps, s; decays exponentially
  double computed_steps_ = 0;                    ///< number of recent steps; decays like computed_seconds_
  double transport_reported_ = -1, summary_reported_ = -1;
  bool summary_due_ = false;
  CircuitWatch watch_;
  CircuitBreakpoints breakpoints_;
  bool breakpoint_met_ = false;    ///< true: the last call of work_on_goal() ended at a breakpoint
  std::int64_t replay_until_ = 0;  ///< before this step the recorded inputs are used instead of the current device state
  bool show_closest_ = false;
  std::unique_ptr<ClosestPairs> closest_pairs_;  ///< created when closest points are first shown
  int touches_reported_ = 0;                     ///< number of touches reported since the last summary
  content::PlayerStepQuality quality_;           ///< sum over the steps since the last message of report_quality()
  double quality_begin_ = 0;                     ///< simulated time at the beginning of the first of these steps, s
  double quality_reported_ = -1;                 ///< clock time of the last message of report_quality(), s; -1: none
  std::int64_t quality_step_ = 0;                ///< number of the last counted step; steps up to it are not counted again when recomputed
  double values_reported_ = -1;
  std::string status_ = "ready";
  Error stop_;  ///< the reason why blown_up_ is set
  std::vector<std::byte> frame_;
};

}  // namespace ugoki::studio
