#pragma once
// What the interpreter plays: content that can be stepped, saved, restored and shown.

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
#include "ugoki/mechanism/mechanism.h"
#include "ugoki/spatial/vec3.h"

namespace ugoki::studio {

struct CastMember {
  std::string id;
  int links = 0;
  friend bool operator==(const CastMember&, const CastMember&) = default;
};

/// How natural a character has moved so far.
struct CharacterSummary {
  double assist_rms_bw = 0;  ///< root-assist wrench, body weights
  double foot_skate_cm = 0;  ///< a stance, mean
  double tracking_rms_deg = 0;
  double penetration_mm = 0;  ///< worst
  bool fell = false;
};

class Simulation {
 public:
  virtual ~Simulation() = default;

  [[nodiscard]] virtual double step_size() const = 0;                     ///< s
  [[nodiscard]] virtual double duration() const = 0;                      ///< s
  [[nodiscard]] virtual double frame_rate() const = 0;                    ///< display frames a second
  [[nodiscard]] virtual const std::vector<CastMember>& cast() const = 0;  ///< in the order of the frames
  /// Index of the link named so (name or label), or -1.
  [[nodiscard]] virtual int find_link(int character, std::string_view name) const = 0;

  [[nodiscard]] virtual std::int64_t step_count() const = 0;  ///< steps done since time 0
  /// One step of dynamics. An error names what blew up; the last good state stays.
  [[nodiscard]] virtual Result<void> step() = 0;

  /// The whole state, so that restore() leads to the same bits from here on.
  virtual void save(std::vector<std::byte>& out) = 0;
  [[nodiscard]] virtual Result<void> restore(std::span<const std::byte> state) = 0;

  // Live inputs act from the next step on.
  virtual void push(int character, int link, const Vec3& force, double duration) = 0;
  virtual void grab(int character, int link, const Vec3& point, const Vec3& target) = 0;  ///< point in the link's frame
  virtual void drag(const Vec3& target) = 0;
  virtual void release() = 0;
  /// Keyboard, mouse and gamepads; they stay so until told otherwise.
  virtual void hold(const circuit::DeviceState& /*state*/) {}
  /// What the circuit reads of them; null: nothing.
  [[nodiscard]] virtual const circuit::DeviceFeed* devices() const { return nullptr; }

  /// Of the cast, in its order; empty: distances cannot be shown.
  [[nodiscard]] virtual std::vector<MechanismPtr> mechanisms() const { return {}; }
  /// Sentences about what touched what in the last step: ends of touches, but for feet on the ground.
  [[nodiscard]] virtual std::vector<std::string> touches() { return {}; }

  /// Back to time 0.
  virtual void reset() {}
  /// Goes on with the newest LSIs of the installed libraries. @return sentences about what was kept
  [[nodiscard]] virtual Result<std::vector<std::string>> change_library() { return std::vector<std::string>{}; }

  /// The circuit that runs it, to be looked at between steps; null: there is none.
  [[nodiscard]] virtual circuit::Interpreter* circuit() { return nullptr; }

  /// The state as a frame of docs/studio-protocol.md; time, number and flags but "grab active" are the caller's to set.
  virtual void encode_frame(std::vector<std::byte>& out) = 0;
  /// The tracks' poses at `time`, without physics, as such a frame.
  virtual void encode_pose(double time, std::vector<std::byte>& out) = 0;

  [[nodiscard]] virtual CharacterSummary summary(int character) = 0;
  /// How many feet bear on the ground now; 255: the character has none.
  [[nodiscard]] virtual std::uint8_t feet_on_ground(int character) = 0;
};

/// Makes a simulation from executable data (*.ugx), which it may not keep a reference to.
using SimulationOpener = Result<std::unique_ptr<Simulation>> (*)(std::span<const std::byte> executable);

}  // namespace ugoki::studio
