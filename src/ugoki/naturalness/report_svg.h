#pragma once
// Pictures of the measures of naturalness over time.

#include <span>
#include <string>

#include "ugoki/naturalness/report.h"

namespace ugoki::naturalness {

/// Returns an SVG picture: for each measure that has values a row with its curve, its limits (dashed), its value for the whole motion, and
/// red bands at the time spans in which it is bad. Several reports are drawn below each other.
[[nodiscard]] std::string report_svg(std::span<const Report> reports);
/// Returns an SVG picture of one measure with axes.
[[nodiscard]] std::string measure_svg(const Report& report, MeasureId id);

}  // namespace ugoki::naturalness
