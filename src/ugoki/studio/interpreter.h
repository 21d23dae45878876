#pragma once
// Plays a simulation: transport, recording, seeking, live inputs. Knows no processes, sockets or clocks; it is told the time.
//
// Simulate mode keeps one simulation at the head of the recording. What is shown may lie behind the head (scrubbing shows
// recorded frames); playing goes through the recording and on at the head. A live input behind the head makes a new future:
// the state is restored from the checkpoint before, stepped to what is shown, and the recording after it is dropped.

#include <cstddef>
#include <cstdint>
#include <functional>
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
#include "ugoki/studio/nearest_pairs.h"
#include "ugoki/studio/recording.h"
#include "ugoki/studio/simulation.h"

namespace ugoki::studio {

/// Where the interpreter's frames and messages go. Neither may wait for a reader.
class InterpreterSink {
 public:
  virtual ~InterpreterSink() = default;
  virtual void frame(std::span<const std::byte> bytes) = 0;
  virtual void message(std::string json) = 0;  ///< an event of docs/studio-protocol.md
};

enum class PlayMode : std::uint8_t { edit, simulate };

class Interpreter {
 public:
  /// @param seconds the time now, from any start; only differences count
  Interpreter(SimulationOpener opener, InterpreterSink& sink, std::function<double()> seconds);

  /// Plays other executable data from now on. The time stays; in simulate mode the content is simulated up to it again,
  /// with the live inputs if the cast is the same, where that takes less than about three seconds. An error leaves what is.
  [[nodiscard]] Result<void> load(std::span<const std::byte> executable);

  [[nodiscard]] Result<void> set_mode(PlayMode mode);
  [[nodiscard]] Result<void> play(std::optional<double> speed);  ///< from the start if it stands at the end
  [[nodiscard]] Result<void> pause();
  [[nodiscard]] Result<void> step_frames(int frames);  ///< display frames, forwards or back; pauses
  /// One step of dynamics from what is shown; pauses. Where that is recorded, it is computed again with the same inputs.
  [[nodiscard]] Result<void> step_tick();
  [[nodiscard]] Result<void> seek(double time);
  [[nodiscard]] Result<void> restart();
  /// An installed library changed on disk: the content goes on with it. @return what is to be told
  [[nodiscard]] std::vector<std::string> change_library();
  /// @param link index as text, or name, or label
  [[nodiscard]] Result<void> grab(std::string_view character, std::string_view link, const Vec3& point, const Vec3& target);
  [[nodiscard]] Result<void> drag(const Vec3& target);
  [[nodiscard]] Result<void> release();
  [[nodiscard]] Result<void> push(std::string_view character, std::string_view link, const Vec3& force, double duration);
  /// Keyboard, mouse and gamepads, remembered whatever it does; they act on steps that are computed while it plays. A press that the
  /// circuit reads acts behind the head too.
  [[nodiscard]] Result<void> input(const circuit::DeviceChange& change);

  /// What a page wants to see of the running circuit, from now on: events `values`.
  void watch(WatchRequest request);

  /// A run stops after the step that meets one of these (circuit::read_breakpoint), and the event `breakpoint` tells it. While there are
  /// any, playing computes what is recorded again. Those whose output the circuit does not have wait for a circuit that has it.
  void set_breakpoints(std::vector<std::string> conditions);

  /// Does some milliseconds of what is due. @return s until there is more to do; infinity: nothing until a call
  double work();

  [[nodiscard]] PlayMode mode() const { return mode_; }
  [[nodiscard]] bool playing() const { return playing_; }
  [[nodiscard]] double time() const { return shown_; }
  [[nodiscard]] double simulated() const;
  [[nodiscard]] std::uint64_t head_digest() const;  ///< of the whole state at the head; for tests

 private:
  enum class Goal : std::uint8_t { none, tick, seek };

  [[nodiscard]] Result<void> require_content() const;
  [[nodiscard]] Result<LiveInput> link_input(std::string_view character, std::string_view link) const;
  [[nodiscard]] Result<void> live_input(LiveInput input);
  [[nodiscard]] Result<void> hold();
  void apply(const LiveInput& input);
  void apply_due_inputs();
  [[nodiscard]] double realtime_factor() const;
  void look_at(circuit::Interpreter* circuit);
  void tell(const std::string& warning);
  [[nodiscard]] Result<void> compute_again();
  void report_breakpoint();
  void begin_recording();
  [[nodiscard]] Result<void> truncate(std::int64_t step);
  [[nodiscard]] bool advance_head();  ///< one step; false: it blew up and was stopped
  void record_head();
  void set_goal(Goal goal, std::int64_t step);
  bool work_on_goal();  ///< true: reached or given up
  void tick();
  void show_edit(double time);
  void show_recorded(double time);
  void show_head();
  void tell_touches();
  void send(std::span<std::byte> bytes, double time, bool live);
  void anchor();
  void finish_play();
  void stop(const Error& error);
  void report_stop();
  void report_transport();
  void report_summary();
  void report_devices();
  void report_in_time();
  /// s until values are to be reported; infinity: nothing of them changed.
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
  bool blown_up_ = false;
  double speed_ = 1;
  double shown_ = 0;  ///< s, what the page sees
  Goal goal_ = Goal::none;
  std::int64_t goal_step_ = 0;
  circuit::DeviceState held_;  ///< what the user holds in hand now
  std::optional<circuit::DeviceUse> told_devices_;
  std::size_t next_input_ = 0;  ///< first recorded input that the head has not seen
  double anchor_seconds_ = 0, anchor_time_ = 0;
  std::int64_t ticks_ = 0;       ///< display ticks since the anchor
  double computed_seconds_ = 0;  ///< spent in the newest steps, and how many they were
  double computed_steps_ = 0;
  double transport_reported_ = -1, summary_reported_ = -1;
  bool summary_due_ = false;
  CircuitWatch watch_;
  CircuitBreakpoints breakpoints_;
  bool met_ = false;              ///< the last work on a goal ended at a breakpoint
  std::int64_t again_until_ = 0;  ///< step up to which the recorded inputs count, not what the user holds
  bool show_nearest_ = false;
  std::unique_ptr<NearestPairs> nearest_;  ///< made when first shown
  int touches_told_ = 0;                   ///< since the last report
  double values_reported_ = -1;
  std::string status_ = "ready";
  Error stop_;  ///< why it blew up
  std::vector<std::byte> frame_;
};

}  // namespace ugoki::studio
