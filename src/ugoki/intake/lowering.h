#pragma once
// How far a hovering character can be lowered, given that it falls no faster than gravity pulls it.

#include <cstdint>
#include <vector>

namespace ugoki::intake {

/// Returns the heights [frames] m by which a hovering character is lowered so that it stands. It never falls faster than gravity pulls:
/// limbs that are drawn up in less time than the body can fall leave the ground, and the body flies along a parabola. The lowering never
/// needs a push from the ground of more than 2.75 body weights, and is smooth within 0.1 s. A flight of the motion stays as it is if
/// gravity allows it; else it becomes lower. Method: least squares with one-sided penalties. O(frames)
/// @param lift [frames] m, height of the lowest point above the floor  @param flies [frames] 1: in a flight of the motion
/// @param centre [frames] m, height of the centre of mass  @param rate frames per second
[[nodiscard]] std::vector<double> physical_lowering(const std::vector<double>& lift, const std::vector<std::uint8_t>& flies,
                                                    const std::vector<double>& centre, double rate);

}  // namespace ugoki::intake
