#pragma once
// The player: runs executable data. The same in the studio, on the command line, in a native program and in WebAssembly.

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

namespace ugoki::content {

/// Something that a user does, at a boundary between two steps: it acts from step `step` on.
struct PlayerInput {
  std::uint64_t step = 0;
  lsi::EventRecord record;
  std::shared_ptr<const circuit::DeviceState> held;  ///< keyboard, mouse and gamepads from now on; null: `record` is what happens
};

/// How natural a character has moved since the start. Zeros for passive characters.
struct PlayerMeasures {
  double tracking_rms_deg = 0;     ///< joints against reference, while it tracks
  double assist_rms_bw = 0;        ///< root assist in body weights (moments count at the lever of the root's height)
  double assist_force_rms_bw = 0;  ///< its force alone
  double assist_max_bw = 0;
  double foot_skate_cm = 0;  ///< mean path of a standing foot
  double foot_skate_worst_cm = 0;
  double penetration_mm = 0;  ///< worst depth in the ground
  double penetration_rms_mm = 0;
  bool fell = false;
  double let_go_time = -1;  ///< s; -1: it has not let go
  int feet_on_ground = -1;  ///< now; -1: it has no feet
};

/// A touch of two links that began or ended in a step.
struct PlayerTouch {
  double time = 0;     ///< s, of the step's end
  bool ended = false;  ///< true: it is over, and `impulse` is that of the whole touch; otherwise that of its first step
  int character_a = -1, link_a = -1, character_b = -1, link_b = -1;  ///< -1, -1: the ground
  Vec3 point;                                                        ///< m, world: where it began
  Vec3 impulse;                                                      ///< N s, world, on link a
  double duration = 0;                                               ///< s
  std::string words;                                                 ///< for people: "hand left of anna touched box, 12 N s"
};

/// What the host of a player may give beyond the content.
struct PlayerOptions {
  std::shared_ptr<const circuit::Library> library;  ///< all LSIs that the circuit may use; null: lsi::standard_library()
  circuit::Activity* activity = nullptr;            ///< where to note which LSI runs; outlives the player
};

/// The characters and events of executable data as the LSIs of a circuit see them.
[[nodiscard]] lsi::World make_world(const Executable& content);

class Player {
 public:
  /// Reads and checks executable data and builds everything; keeps no reference to the bytes.
  /// @param name for messages
  [[nodiscard]] static Result<Player> open(std::span<const std::byte> ugx, std::string_view name = "executable data",
                                           PlayerOptions options = {});

  Player(Player&&) noexcept;
  Player& operator=(Player&&) noexcept;
  ~Player();

  [[nodiscard]] const Executable& content() const;
  [[nodiscard]] const lsi::World& world() const;
  [[nodiscard]] double step_size() const;  ///< s

  /// One step. An error names LSI, body, joint and time; the last good state stays, and further steps give the same error
  /// until restore or reset. Allocates nothing.
  [[nodiscard]] Result<void> step();
  /// Touches that began or ended in the last step. @param out cleared and filled
  void touches(std::vector<PlayerTouch>& out) const;
  [[nodiscard]] std::uint64_t step_count() const;  ///< done since time 0
  [[nodiscard]] double time() const;               ///< s
  /// Back to time 0, inputs forgotten.
  void reset();

  // Inputs act from the next step on and are recorded. Indices as in content(); out of range: ignored.
  /// Force [N], world, at the link's centre of mass, for `duration` s.
  void push(int character, int link, const Vec3& force, double duration);
  /// A spring pulls the point [m, link's frame] towards the target [m, world] until release.
  void grab(int character, int link, const Vec3& point, const Vec3& target);
  void drag(const Vec3& target);
  void release();
  /// Sets the root's position [m], velocity [m/s] and spin [rad/s], world; for characters with a floating root.
  void throw_from(int character, const Vec3& from, const Vec3& velocity, const Vec3& spin);
  /// What the user holds in hand from now on. Recorded where it is other, for what the circuit reads, than it was.
  void hold(const circuit::DeviceState& state);
  /// Of what the circuit reads of keyboard, mouse and gamepads. Another one after change_library.
  [[nodiscard]] const circuit::DeviceFeed& devices() const;

  /// All inputs so far (since reset; restore forgets those of later steps).
  [[nodiscard]] const std::vector<PlayerInput>& inputs() const;
  /// Inputs to be given at their steps: with the inputs() of another run this one has the same bits.
  void schedule(std::vector<PlayerInput> inputs);

  /// Hash of all q and v, character by character.
  [[nodiscard]] std::uint64_t state_hash() const;
  [[nodiscard]] std::span<const double> q(int character) const;  ///< [nq]
  [[nodiscard]] std::span<const double> v(int character) const;  ///< [nv]

  /// The whole state: restore leads to the same bits from here on.
  void save(std::vector<std::byte>& bytes);
  [[nodiscard]] Result<void> restore(std::span<const std::byte> bytes);

  /// What a viewer shows now. @param frame keeps its memory
  void display_frame(DisplayFrame& frame);
  /// The tracks' poses at `time`, without physics; figures are in the state `edit`.
  void pose_at(double time, DisplayFrame& frame) const;
  [[nodiscard]] PlayerMeasures measures(int character);
  /// Index of the link that is named or labelled so, or -1.
  [[nodiscard]] int find_link(int character, std::string_view name) const;

  /// Goes on with the LSIs of another library (one of them was rebuilt), each with its state where the layout allows it. An error
  /// leaves all as it is.
  [[nodiscard]] Result<circuit::Interpreter::Adoption> change_library(std::shared_ptr<const circuit::Library> library);
  [[nodiscard]] const circuit::Library& library() const;

  /// The running circuit: probes, timing, parameters. Another one after change_library.
  [[nodiscard]] circuit::Interpreter& interpreter();

 private:
  struct Machine;
  explicit Player(std::unique_ptr<Machine> machine);
  std::unique_ptr<Machine> machine_;
};

}  // namespace ugoki::content
