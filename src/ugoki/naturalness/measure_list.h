#pragma once
// The measures of naturalness: names, units and limits. docs/naturalness.md has definitions, sources and calibration.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace ugoki::naturalness {

enum class MeasureId : std::uint8_t {
  tracking,
  assist,
  fall,
  slip,
  penetration,
  hover,
  root_force,
  root_moment,
  flight_gravity,
  flight_speed,
  angular_momentum,
  ground_force,
  step_force,
  force_shape,
  force_humps,
  jerk,
  jerk_ratio,
  torque,
  step_symmetry,
  stance_symmetry,
  torque_symmetry,
  work,
  clearance,
  knee,
  head_acceleration
};
inline constexpr std::size_t measure_count = 25;
[[nodiscard]] constexpr std::size_t index_of(MeasureId id) { return static_cast<std::size_t>(id); }

/// Value of a measure that does not apply. All measures are at least 0; the value of a whole motion that does not apply is a negative
/// number that names the reason (value_of).
inline constexpr double no_value = -1;

/// Why a measure does not apply to a motion.
enum class Reason : std::uint8_t {
  unknown,
  only_simulated,
  only_recorded,
  no_reference,
  no_feet,
  no_stance,
  fixed_root,
  no_forces,
  no_flight,
  no_level_flight,
  no_torque_limits,
  no_torques,
  no_travel,
  no_biped,
  no_head,
  too_short,
  no_knee,
  no_sides,
  few_steps,
  no_gait,
  no_walk,
};
[[nodiscard]] constexpr double value_of(Reason reason) { return no_value - static_cast<double>(reason); }
/// The reason for a negative value, in words; empty for other values.
[[nodiscard]] std::string_view reason_words(double value);

/// How the value of a whole motion follows from the values over time.
enum class Total : std::uint8_t { rms, mean, maximum, share };
[[nodiscard]] std::string_view name_of(Total total);

/// Values inside [good_low, good_high] are good, values outside [low, high] are bad, others are fair.
struct Limits {
  double low = 0, good_low = 0, good_high = 0, high = 0;
};
enum class Grade : std::uint8_t { none, good, fair, bad };
[[nodiscard]] Grade grade(const Limits& limits, double value);
[[nodiscard]] std::string_view name_of(Grade grade);

struct MeasureInfo {
  MeasureId id = MeasureId::tracking;
  const char* key = "";   ///< name in JSON and CSV, with unit
  const char* name = "";  ///< name for display
  const char* unit = "";
  Total total = Total::rms;
  int digits = 1;            ///< decimals for display
  Limits limits;             ///< of the value of the whole motion
  Limits now;                ///< of the values over time
  bool smooth = false;       ///< true: `now` holds for the rms over `rms_time`, because single frames scatter
  const char* meaning = "";  ///< one sentence
};

/// s: duration of the root mean squares over time.
inline constexpr double rms_time = 0.25;

/// All measures; element i has the id i.
[[nodiscard]] std::span<const MeasureInfo> measure_list();
[[nodiscard]] const MeasureInfo& info_of(MeasureId id);
/// Returns the measure with this key, or null.
[[nodiscard]] const MeasureInfo* find_measure(std::string_view key);

}  // namespace ugoki::naturalness
