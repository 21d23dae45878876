#include "ugoki/content/terrain.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace ugoki::content {
namespace {

constexpr int min_cells = 16, max_cells = 256;  // along one side
constexpr double cells_in_grain = 10;           // grid cells of one wavelength of the first octave
constexpr double base = 0.2;                    // m, thickness below height 0
constexpr int octaves = 3;

/// A number from 0 to 1 for a point of a lattice (hash of splitmix64).
double lattice(std::int64_t x, std::int64_t y, std::uint64_t seed) {
  std::uint64_t h = seed * 0x9e3779b97f4a7c15 + static_cast<std::uint64_t>(x) * 0xbf58476d1ce4e5b9 + static_cast<std::uint64_t>(y);
  for (const std::uint64_t factor : {std::uint64_t{0xbf58476d1ce4e5b9}, std::uint64_t{0x94d049bb133111eb}}) h = (h ^ (h >> 29)) * factor;
  return static_cast<double>((h ^ (h >> 32)) >> 11) * 0x1p-53;
}

double smooth(double t) { return t * t * t * (t * (6 * t - 15) + 10); }  // with continuous curvature

/// Interpolates the lattice of cells of size 1.
double value_noise(double x, double y, std::uint64_t seed) {
  const double fx = std::floor(x), fy = std::floor(y), u = smooth(x - fx), v = smooth(y - fy);
  const auto i = static_cast<std::int64_t>(fx), j = static_cast<std::int64_t>(fy);
  const double below = lattice(i, j, seed) * (1 - u) + lattice(i + 1, j, seed) * u;
  const double above = lattice(i, j + 1, seed) * (1 - u) + lattice(i + 1, j + 1, seed) * u;
  return below * (1 - v) + above * v;
}

int grid_points(double length, double grain) {
  return static_cast<int>(std::clamp(std::ceil(length * cells_in_grain / grain), 1.0 * min_cells, 1.0 * max_cells)) + 1;
}

/// Share of the height at a distance [m] from the border: 0 at the border, 1 from `margin` on.
double rise(double distance, double margin) {
  const double t = std::clamp(distance / margin, 0.0, 1.0);
  return t * (2 - t);
}

}  // namespace

HeightFieldPtr make_terrain(const Vec3& size, double grain, int seed) {
  HeightField field;
  field.columns = grid_points(size.x, grain);
  field.rows = grid_points(size.y, grain);
  field.half_x = 0.5 * size.x;
  field.half_y = 0.5 * size.y;
  field.base = base;
  const double margin = std::min(grain, 0.25 * std::min(size.x, size.y));
  double low = 1e9, high = -1e9;
  for (int r = 0; r < field.rows; ++r)
    for (int c = 0; c < field.columns; ++c) {
      const double x = size.x * c / (field.columns - 1), y = size.y * r / (field.rows - 1);
      double sum = 0, amplitude = 1, wave = grain;
      for (int k = 0; k < octaves; ++k, amplitude *= 0.5, wave *= 0.5)
        sum += amplitude * value_noise(x / wave, y / wave, static_cast<std::uint64_t>(seed) * octaves + static_cast<std::uint64_t>(k));
      low = std::min(low, sum);
      high = std::max(high, sum);
      field.heights.push_back(sum);
    }
  double top = 0;
  std::size_t at = 0;
  for (int r = 0; r < field.rows; ++r)
    for (int c = 0; c < field.columns; ++c, ++at) {
      const double x = size.x * c / (field.columns - 1), y = size.y * r / (field.rows - 1);
      const double share = rise(std::min({x, size.x - x, y, size.y - y}), margin);
      field.heights[at] = high > low ? (field.heights[at] - low) / (high - low) * share : 0;
      top = std::max(top, field.heights[at]);
    }
  for (double& h : field.heights) h = top > 0 ? size.z * h / top : 0;
  return make_height_field(std::move(field), "terrain").value();
}

}  // namespace ugoki::content
