#include "ugoki/naturalness/measure_list.h"

#include <array>
#include <limits>

namespace ugoki::naturalness {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();

/// Limits of a measure of which only large values are bad.
constexpr Limits below(double good, double bad) { return {-inf, -inf, good, bad}; }

constexpr std::array<MeasureInfo, measure_count> list = {{
    {MeasureId::tracking, "tracking_deg", "Tracking", "deg", Total::rms, 1, below(2.5, 5), below(2.5, 5), true,
     "Angle between the joints and the motion of the track"},
    {MeasureId::assist, "root_assist_bw", "Root assist", "bw", Total::rms, 3, below(0.05, 0.15), below(0.05, 0.15), true,
     "External force and moment on the root that the motion needs in addition to its contacts"},
    {MeasureId::fall, "fell", "Fall", "", Total::maximum, 0, below(0, 0), below(0, 0), false,
     "The root is far below its reference, or tilted from it by more than 57 degrees"},
    {MeasureId::slip, "foot_slip_cm", "Foot skate", "cm", Total::mean, 2, below(1, 3), below(1, 3), false,
     "Distance that a standing foot slides in one stance"},
    {MeasureId::penetration, "penetration_mm", "Penetration", "mm", Total::maximum, 1, below(5, 30), below(5, 30), false,
     "Depth of the body in the ground"},
    {MeasureId::hover, "hover_mm", "Hovering", "mm", Total::rms, 1, below(4, 7), below(5, 20), true,
     "Height of a standing foot above the ground"},
    {MeasureId::root_force, "root_force_percent", "Missing force", "%", Total::rms, 1, below(5, 10), below(5, 10), true,
     "Force that the contacts cannot supply, of the maximum ground force"},
    {MeasureId::root_moment, "root_moment_percent", "Missing moment", "%", Total::rms, 1, below(1, 5), below(1, 5), true,
     "Moment that the contacts cannot supply, of the maximum ground force times the height of the centre of mass"},
    {MeasureId::flight_gravity, "flight_gravity_percent", "Gravity in flight", "%", Total::rms, 1, below(5, 20), below(5, 20), false,
     "Difference of the acceleration of the centre of mass in a flight from gravity"},
    {MeasureId::flight_speed, "flight_speed_percent", "Speed in flight", "%", Total::rms, 1, below(3, 20), below(3, 20), false,
     "Change of the horizontal speed of the centre of mass in a flight"},
    {MeasureId::angular_momentum, "angular_momentum", "Angular momentum", "", Total::rms, 3, below(0.05, 0.1), below(0.05, 0.1), true,
     "Angular momentum of a walk about its centre of mass, divided by mass, speed and height of the centre of mass"},
    {MeasureId::ground_force, "ground_force_bw", "Ground force", "bw", Total::maximum, 2, below(3, 3.5), below(3, 3.5), false,
     "Vertical force of the ground on all feet"},
    {MeasureId::step_force,
     "step_force_bw",
     "Force of a step",
     "bw",
     Total::mean,
     2,
     {0.9, 1.0, 1.25, 1.5},
     {0.8, 1.0, 1.25, 1.6},
     false,
     "Peak of the vertical force on one foot in a walk"},
    {MeasureId::force_shape, "force_shape_percent", "Force irregularity", "%", Total::rms, 1, below(25, 40), below(25, 50), false,
     "Deviation of the vertical force on a foot from the smooth course of a stance"},
    {MeasureId::force_humps,
     "force_humps",
     "Force humps",
     "",
     Total::mean,
     2,
     {0, 0.11, 0.7, 1},
     {0, 0.11, 0.7, 1.5},
     false,
     "Shape factor of the vertical force on a foot in a walk; above 0.11 it has two humps"},
    {MeasureId::jerk, "jerk", "Jerk", "", Total::maximum, 2, below(0.97, 1), below(2, 3), false,
     "Jerk of the links, of the bound of recordings"},
    {MeasureId::jerk_ratio, "jerk_ratio", "Jerk ratio", "", Total::maximum, 2, below(1.4, 2), below(2, 4), false,
     "Jerk of the links, of the jerk of the reference"},
    {MeasureId::torque, "torque_over_percent", "Torque over limit", "%", Total::share, 1, below(0, 2), below(80, 100), false,
     "Share of the time in which a joint torque is above its limit; over time: the largest torque, of its limit"},
    {MeasureId::step_symmetry, "step_asymmetry_percent", "Step asymmetry", "%", Total::mean, 1, below(10, 20), below(20, 40), false,
     "Difference of time and length of left and right steps"},
    {MeasureId::stance_symmetry, "stance_asymmetry_percent", "Stance asymmetry", "%", Total::mean, 1, below(10, 20), below(20, 40), false,
     "Difference of the duration of left and right stances"},
    {MeasureId::torque_symmetry, "torque_asymmetry_percent", "Torque asymmetry", "%", Total::mean, 1, below(10, 20), below(20, 40), false,
     "Difference of the torques of left and right legs"},
    {MeasureId::work, "work", "Joint work", "", Total::mean, 3, below(0.15, 0.3), below(0.3, 0.6), false,
     "Positive work of the joints, divided by weight and distance"},
    {MeasureId::clearance,
     "toe_clearance_mm",
     "Toe clearance",
     "mm",
     Total::mean,
     0,
     {2, 10, 50, 100},
     {2, 10, 50, 120},
     false,
     "Height of the lowest point of the foot in the middle of a swing in a walk"},
    {MeasureId::knee, "knee_touchdown_deg", "Knee at touch-down", "deg", Total::mean, 1, below(28, 40), below(28, 50), false,
     "Angle of the knee when the foot touches the ground in a walk"},
    {MeasureId::head_acceleration, "head_acceleration_g", "Head acceleration", "g", Total::rms, 2, below(0.3, 0.5), below(0.3, 0.8), true,
     "Acceleration of the head in a walk"},
}};

}  // namespace

std::span<const MeasureInfo> measure_list() { return list; }
const MeasureInfo& info_of(MeasureId id) { return list[index_of(id)]; }
const MeasureInfo* find_measure(std::string_view key) {
  for (const MeasureInfo& info : list)
    if (key == info.key) return &info;
  return nullptr;
}

Grade grade(const Limits& limits, double value) {
  if (!(value >= 0)) return Grade::none;
  if (value < limits.low || value > limits.high) return Grade::bad;
  return value < limits.good_low || value > limits.good_high ? Grade::fair : Grade::good;
}

std::string_view reason_words(double value) {
  static constexpr std::array<std::string_view, 21> words = {"no value",
                                                             "only for simulated characters that follow a track",
                                                             "for simulations, the jerk ratio is measured instead",
                                                             "no reference motion",
                                                             "no feet",
                                                             "no foot stands",
                                                             "the root is fixed",
                                                             "ground forces are not known",
                                                             "no flight of 0.1 s",
                                                             "no horizontal flight",
                                                             "the joints have no torque limits",
                                                             "torques are not known",
                                                             "the character does not travel",
                                                             "only for two legs",
                                                             "no head",
                                                             "the motion is too short",
                                                             "no knee",
                                                             "no left and right leg",
                                                             "fewer than three whole steps",
                                                             "no whole stance in a gait",
                                                             "no walking"};
  if (!(value < 0)) return "";
  const double index = no_value - value;
  return index < static_cast<double>(words.size()) ? words[static_cast<std::size_t>(index)] : words[0];
}

std::string_view name_of(Grade grade) {
  switch (grade) {
    case Grade::good: return "good";
    case Grade::fair: return "fair";
    case Grade::bad: return "bad";
    default: return "none";
  }
}
std::string_view name_of(Total total) {
  switch (total) {
    case Total::rms: return "rms";
    case Total::mean: return "mean";
    case Total::maximum: return "maximum";
    default: return "share";
  }
}

}  // namespace ugoki::naturalness
