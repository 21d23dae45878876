#pragma once
// Up axis, unit of length, travel and height of a motion, from the posture, the size and the steps of its character.

#include <optional>
#include <string>
#include <vector>

#include "ugoki/body/body.h"
#include "ugoki/body/recognise.h"
#include "ugoki/motion/missing_travel.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::intake {

/// Finds the up axis of the file from the posture of a human character: trunk and legs point along this axis in most frames.
/// @return the axis (unit, along a coordinate axis); nothing if z is up or no axis is clearly up
[[nodiscard]] std::optional<Vec3> up_by_posture(const body::Character& character);

/// Unit of length, m per present metre, that gives a human character a usual height. @param trusted the unit is given by the file
/// If no usual unit does, the unit gives a height of 1.7 m.
/// @return nothing if the height is plausible
[[nodiscard]] std::optional<double> unit_by_height(const body::Character& character, double metres_per_unit, bool trusted);
/// Travel of a character that walks in place (on a treadmill, or an animation without travel): its standing feet slide while the character
/// stays. Does not exist if the character travels, or its standing feet do not move.
[[nodiscard]] MissingTravel find_missing_travel(const body::Character& character, const MeasuredMotion& motion);
/// Displaces the roots. @param shift [frames] m
void add_travel(MeasuredMotion& motion, const std::vector<Vec3>& shift);

/// A change of a motion.
struct Change {
  std::string sentence;
  bool far = false;  ///< the legs bend much more than in the file
};
/// Gives jumps the timing of free fall (gravity_time.h), and lowers the root of a person or animal that hovers (hovering_heights).
/// @param body the body that was made from the motion  @return the changes, for the report
[[nodiscard]] std::vector<Change> suit_to_gravity(MeasuredMotion& measured, const body::Body& body);

}  // namespace ugoki::intake
