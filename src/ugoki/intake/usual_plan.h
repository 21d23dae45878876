#pragma once
// The body plan that most motions of a file show. Internal to intake.

#include <optional>
#include <span>

#include "ugoki/body/recognise.h"

namespace ugoki::intake {

/// The human in the longest of the motions that show one, if two thirds of at least three motions do and the joints have a person's names:
/// in the longest motion of a file the person can lie or crawl (all animations one after another, the last one a death).
/// @param motions all on the same skeleton
[[nodiscard]] std::optional<body::Character> human_in_most(std::span<const MeasuredMotion> motions);

}  // namespace ugoki::intake
