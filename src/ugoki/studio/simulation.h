#pragma once
// Interface of the content that the interpreter plays: it can be stepped, saved, restored and shown.

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
#include "ugoki/content/player.h"
#include "ugoki/mechanism/mechanism.h"
#include "ugoki/naturalness/measure_list.h"
#include "ugoki/spatial/vec3.h"

namespace ugoki::studio {

/// A character of the content.
struct CastMember {
  std::string id;
  int links = 0;
  friend bool operator==(const CastMember&, const CastMember&) = default;
};

/// Quality measures of a character's motion since time 0.
struct CharacterSummary {
  double assist_rms_bw = 0;     ///< root-assist wrench, RMS in body weights
  double foot_skate_cm = 0;     ///< mean net displacement of a foot during one stance, cm
  double tracking_rms_deg = 0;  ///< RMS of the joints' tracking error, degrees
  double penetration_mm = 0;    ///< maximum penetration, mm
  bool fell = false;
};

/// Measures of a character's motion at one instant, by naturalness::MeasureId; negative: no value.
using MomentMeasures = std::array<float, naturalness::measure_count>;
/// Measures of a character's motion since time 0, by naturalness::MeasureId; negative: naturalness::reason_words().
using RunMeasures = std::array<double, naturalness::measure_count>;

class Simulation {
 public:
  virtual ~Simulation() = default;

  [[nodiscard]] virtual double step_size() const = 0;                     ///< time step of the dynamics, s
  [[nodiscard]] virtual double duration() const = 0;                      ///< duration of the content, s
  [[nodiscard]] virtual double frame_rate() const = 0;                    ///< display frame rate, 1/s
  [[nodiscard]] virtual const std::vector<CastMember>& cast() const = 0;  ///< characters, in the order of display frames
  /// Index of the link with this name or label, or -1.
  [[nodiscard]] virtual int find_link(int character, std::string_view name) const = 0;

  [[nodiscard]] virtual std::int64_t step_count() const = 0;  ///< number of steps done since time 0
  /// Hash of all positions and velocities, as `ugoki run` prints it.
  [[nodiscard]] virtual std::uint64_t state_hash() const { return 0; }
  /// Computes one step of dynamics. On an error the state before the step is kept; the error names the cause.
  [[nodiscard]] virtual Result<void> step() = 0;

  /// Writes the whole state to `out`. After restore() with these bytes, the simulation continues with bit-identical results.
  virtual void save(std::vector<std::byte>& out) = 0;
  [[nodiscard]] virtual Result<void> restore(std::span<const std::byte> state) = 0;

  // Live inputs. They act from the next step on. Forces in N, durations in s, targets in the world frame, m.
  virtual void push(int character, int link, const Vec3& force, double duration) = 0;
  virtual void grab(int character, int link, const Vec3& point, const Vec3& target) = 0;  ///< `point` [m] in the link's frame
  virtual void drag(const Vec3& target) = 0;
  virtual void release() = 0;
  /// Sets the state of keyboard, mouse and gamepads, valid until the next call.
  virtual void hold(const circuit::DeviceState& /*state*/) {}
  /// The device inputs that the circuit reads; null: it reads none.
  [[nodiscard]] virtual const circuit::DeviceFeed* devices() const { return nullptr; }

  /// The mechanisms of the characters, in the order of cast(); empty: closest points cannot be shown.
  [[nodiscard]] virtual std::vector<MechanismPtr> mechanisms() const { return {}; }
  /// Messages about touches that ended in the last step: contacts between characters or with the ground, except of feet with the ground.
  [[nodiscard]] virtual std::vector<std::string> touches() { return {}; }

  /// How well the contacts of the last step were solved.
  [[nodiscard]] virtual content::PlayerStepQuality step_quality() const { return {}; }

  /// Sets the simulation back to time 0.
  virtual void reset() {}
  /// Replaces the LSIs by the newest versions of the installed libraries and keeps their state. @return messages about LSIs whose state
  /// could not be kept completely
  [[nodiscard]] virtual Result<std::vector<std::string>> change_library() { return std::vector<std::string>{}; }

  /// The running circuit, to be read between steps; null: there is none.
  [[nodiscard]] virtual circuit::Interpreter* circuit() { return nullptr; }

  /// Writes the state as a display frame (docs/studio-protocol.md). The caller sets time, number and all flags except "grab active".
  virtual void encode_frame(std::vector<std::byte>& out) = 0;
  /// Writes the poses of the tracks at `time` [s], without physics, as a display frame.
  virtual void encode_pose(double time, std::vector<std::byte>& out) = 0;

  [[nodiscard]] virtual CharacterSummary summary(int character) = 0;
  [[nodiscard]] virtual MomentMeasures moment(int /*character*/) { return {}; }     ///< measures of the present instant
  [[nodiscard]] virtual RunMeasures run_measures(int /*character*/) { return {}; }  ///< measures since time 0
  /// Number of feet that bear on the ground now; 255: the character has no feet.
  [[nodiscard]] virtual std::uint8_t feet_on_ground(int character) = 0;
};

/// Creates a simulation from executable data (*.ugx). The simulation must not keep a reference to the data.
using SimulationOpener = Result<std::unique_ptr<Simulation>> (*)(std::span<const std::byte> executable);

}  // namespace ugoki::studio
