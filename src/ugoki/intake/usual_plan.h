#pragma once
// The body plan that most motions of a file and its names show. Internal to intake.

#include <optional>
#include <span>

#include "ugoki/body/recognise.h"

namespace ugoki::intake {

/// The human in the longest of the motions that show one, if two thirds of at least three motions do and the joints have a person's names:
/// in the longest motion of a file the person can lie or crawl (all animations one after another, the last one a death).
/// @param motions all on the same skeleton
[[nodiscard]] std::optional<body::Character> human_in_most(std::span<const MeasuredMotion> motions);

/// The four-legged animal that a recognised human is, if names in the file state a species: all motions together show one (it is upright in
/// the longest, a jump or a dance), or its trunk is level in most frames (a rig with the names of a person's joints). std::nullopt: it
/// walks upright, as cartoon animals do.
/// @param motions all on the same skeleton  @param human recognised in the longest of them
[[nodiscard]] std::optional<body::Character> animal_of_species(std::span<const MeasuredMotion> motions, const body::Character& human);

}  // namespace ugoki::intake
