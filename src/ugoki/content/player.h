#pragma once
// The player: runs executable data. The studio, the command line, native programs and the WebAssembly build use the same player.

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/circuit/devices.h"
#include "ugoki/circuit/interpreter.h"
#include "ugoki/content/display_frame.h"
#include "ugoki/content/executable.h"
#include "ugoki/lsi/world.h"
#include "ugoki/naturalness/measure_list.h"

namespace ugoki::content {

/// An input of the user between two steps. It has an effect from step `step` on.
struct PlayerInput {
  std::uint64_t step = 0;
  lsi::EventRecord record;                           ///< the event, if `held` is null
  std::shared_ptr<const circuit::DeviceState> held;  ///< new state of keyboard, mouse and gamepads; null: the input is `record`
};

/// Measures of the naturalness of a character's motion since the start. For passive characters, release_time and feet_on_ground are -1 and
/// the other values 0.
struct PlayerMeasures {
  double tracking_rms_deg = 0;     ///< deg, RMS deviation of the joints from the reference while the character tracks it
  double assist_rms_bw = 0;        ///< RMS root assist, body weights (moments are divided by the root's height)
  double assist_force_rms_bw = 0;  ///< RMS force of the root assist alone, body weights
  double assist_max_bw = 0;        ///< maximum root assist, body weights
  double foot_skate_cm = 0;        ///< mean net slip of a foot per stance
  double foot_skate_worst_cm = 0;  ///< maximum net slip in one stance
  double penetration_mm = 0;       ///< maximum penetration depth into the ground
  double penetration_rms_mm = 0;
  bool fell = false;
  double release_time = -1;  ///< time at which control released the character, s; -1: never
  int feet_on_ground = -1;   ///< number of feet that are on the ground now; -1: the character has no feet
  // Values of the present instant; naturalness updates them about 120 times per simulated second.
  double tracking_now_deg = 0;  ///< deg, RMS deviation of the joints from the reference; 0 after the release
  double assist_now_bw = 0;     ///< root assist, body weights; 0 after the release
  double slip_now_cm = 0;       ///< maximum net slip of the present stances
  double depth_now_mm = 0;      ///< maximum depth in the ground
  /// All measures of naturalness/measure_list.h, in its order: of the run (negative: naturalness::reason_words()) and of the present
  /// instant (negative: no value).
  std::array<double, naturalness::measure_count> totals = {}, now = {};
};

/// A touch (contact interval) of two links that began or ended during a step.
struct PlayerTouch {
  double time = 0;     ///< time at the end of the step, s
  bool ended = false;  ///< false: touch began, `impulse` is that of the first step; true: touch ended, `impulse` is the total
  int character_a = -1, link_a = -1, character_b = -1, link_b = -1;  ///< indices; character -1 and link -1: the ground
  Vec3 point;                                                        ///< m, world: contact point when the touch began
  Vec3 impulse;                                                      ///< N s, world, acts on link a
  double duration = 0;                                               ///< s, duration of the touch
  /// Number of further touches that began or ended in this step and are not listed; then only `time` and `words` are set. 0: this is a
  /// touch.
  std::size_t omitted = 0;
  std::string words;  ///< description for display: "hand left of anna touched box, 12 N s"
};

/// How well the contacts of a step, or of several steps, were solved: sums over the steps and over all dynamics LSIs of the circuit.
struct PlayerStepQuality {
  std::uint64_t not_converged = 0;  ///< groups of touching bodies whose contacts were not solved to the tolerance
  std::uint64_t split_steps = 0;    ///< steps that were split into substeps
  std::uint64_t substeps = 0;       ///< substeps of all steps; a step that is not split counts as one
  std::uint64_t failures = 0;       ///< failed stages of steps (docs/design/contact.md, section "Report")
  PlayerStepQuality& operator+=(const PlayerStepQuality& next);
};

/// Options that the host program (the program that contains the player) sets.
struct PlayerOptions {
  std::shared_ptr<const circuit::Library> library;  ///< LSIs (function blocks) that circuits may use; null: lsi::standard_library()
  circuit::Activity* activity = nullptr;            ///< records which LSI runs; must outlive the player; may be null
  /// Threads for LSIs and for the systems of a step; must outlive the player; null: the calling thread only. Results have the same bits.
  circuit::Executor* executor = nullptr;
};

/// The characters and events of executable data in the form that the LSIs of a circuit use.
[[nodiscard]] lsi::World make_world(const Executable& content);

class Player {
 public:
  /// Reads and checks executable data and builds the circuit and the world. Keeps no reference to `ugx`.
  /// @param name name of the data in messages
  [[nodiscard]] static Result<Player> open(std::span<const std::byte> ugx, std::string_view name = "executable data",
                                           PlayerOptions options = {});

  Player(Player&&) noexcept;
  Player& operator=(Player&&) noexcept;
  ~Player();

  [[nodiscard]] const Executable& content() const;
  [[nodiscard]] const lsi::World& world() const;
  [[nodiscard]] double step_size() const;  ///< s

  /// Runs one step. An error names LSI, body, joint and time. After an error the last valid state is kept, and further steps return the
  /// same error until restore() or reset(). Does not allocate.
  [[nodiscard]] Result<void> step();
  /// Lists the touches that began or ended in the last step. @param out is cleared first
  void touches(std::vector<PlayerTouch>& out) const;
  /// Returns how well the last step was solved.
  [[nodiscard]] PlayerStepQuality step_quality() const;
  [[nodiscard]] std::uint64_t step_count() const;  ///< steps since time 0
  [[nodiscard]] double time() const;               ///< s
  /// Returns to time 0 and clears inputs(); scheduled inputs are kept and are applied again.
  void reset();

  // Inputs have an effect from the next step on and are recorded in inputs(). Indices refer to content(). An input with an index out of
  // range or with a value that is not finite is ignored.
  /// Applies a force [N], world, at the link's centre of mass for `duration` [s].
  void push(int character, int link, const Vec3& force, double duration);
  /// Attaches a spring that pulls the point [m, link's frame] towards the target [m, world] until release().
  void grab(int character, int link, const Vec3& point, const Vec3& target);
  /// Moves the target [m, world] of the spring.
  void drag(const Vec3& target);
  /// Removes the spring.
  void release();
  /// Sets the root's position [m], velocity [m/s] and spin [rad/s] in the world. Only for characters with a floating root.
  void throw_from(int character, const Vec3& from, const Vec3& velocity, const Vec3& spin);
  /// Sets the state of keyboard, mouse and gamepads. Recorded only if a key, button or axis changes that the circuit reads. A key or button
  /// that is pressed and released between two steps is released one step later, so that a step reads every press.
  void hold(const circuit::DeviceState& state);
  /// Returns the keys, buttons and axes that the circuit reads. change_library() updates them.
  [[nodiscard]] const circuit::DeviceFeed& devices() const;

  /// Returns all inputs since the start or the last reset(). restore() removes the inputs of later steps.
  [[nodiscard]] const std::vector<PlayerInput>& inputs() const;
  /// Sets inputs that are applied at their steps. With the inputs() of another run, this run gives bitwise equal results.
  void schedule(std::vector<PlayerInput> inputs);

  /// Returns a hash of q and v of all characters.
  [[nodiscard]] std::uint64_t state_hash() const;
  [[nodiscard]] std::span<const double> q(int character) const;  ///< [nq] position coordinates
  [[nodiscard]] std::span<const double> v(int character) const;  ///< [nv] velocities

  /// Writes the complete state to `bytes`. After restore() with these bytes, the run continues with bitwise equal results.
  void save(std::vector<std::byte>& bytes);
  [[nodiscard]] Result<void> restore(std::span<const std::byte> bytes);

  /// Computes the current display frame. @param frame is overwritten; its memory is reused
  void display_frame(DisplayFrame& frame);
  /// Computes the poses of the tracks at `time` [s], without physics. All characters are in the state `edit`.
  void pose_at(double time, DisplayFrame& frame) const;
  /// Writes the present values of content().variables. Variables whose LSIs are not in the circuit were removed from this list.
  void variable_values(std::vector<double>& values);
  [[nodiscard]] PlayerMeasures measures(int character);
  /// Returns the index of the link with the name or label `name`; -1: none.
  [[nodiscard]] int find_link(int character, std::string_view name) const;

  /// Continues the run with the LSIs of another library, for example after an LSI was rebuilt. An LSI keeps its state if the layout of the
  /// state allows this. If the circuit cannot be built, the player is unchanged. @return which states were kept
  [[nodiscard]] Result<circuit::Interpreter::Adoption> change_library(std::shared_ptr<const circuit::Library> library);
  [[nodiscard]] const circuit::Library& library() const;

  /// Returns the interpreter of the running circuit, for probes, timing and parameters. change_library() replaces the interpreter's
  /// circuit.
  [[nodiscard]] circuit::Interpreter& interpreter();

 private:
  struct Machine;
  explicit Player(std::unique_ptr<Machine> machine);
  std::unique_ptr<Machine> machine_;
};

}  // namespace ugoki::content
