#pragma once
// Heights of uneven ground, computed from a few numbers.

#include "ugoki/mechanism/geometry.h"

namespace ugoki::content {

/// Returns hills between 0 and `size.z`, which begin at height 0 at the border: value noise (three octaves, each of half the wavelength and
/// half the amplitude of the one before). Equal arguments give equal bits on every machine.
/// @param size m, extents along x and y, and height of the highest hill @param grain m, about the distance from a hill to the next hollow:
/// the wavelength of the first octave
/// @param seed another seed gives other hills  O(grid points), at most 257 x 257
[[nodiscard]] HeightFieldPtr make_terrain(const Vec3& size, double grain, int seed);

}  // namespace ugoki::content
