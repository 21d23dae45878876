#pragma once
// Plot of push roses beside published pushes that people and other controllers withstand.

#include <span>
#include <string>

namespace ugoki::bench {

/// Pushes of one motion in one direction, at several phases of the cycle.
struct RosePoint {
  double impulse = 0;  ///< N s/kg: impulse of each push divided by the body mass
  double angle = 0;    ///< rad: direction of the push from the direction of the walk, positive to the left
  int survived = 0, tries = 0;
};

/// Returns an SVG picture: the direction of the walk is up, and the distance from the middle is the impulse.
[[nodiscard]] std::string rose_svg(std::span<const RosePoint> points);

}  // namespace ugoki::bench
