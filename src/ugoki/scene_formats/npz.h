#pragma once
// Reads arrays of NumPy from .npz files (zip of .npy). Internal to scene_formats.

#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::scene_formats {

/// A numeric array in row-major order.
struct NpyArray {
  std::vector<std::size_t> shape;
  std::vector<double> values;
  [[nodiscard]] std::size_t columns() const { return shape.empty() ? 1 : shape.back(); }
  [[nodiscard]] std::size_t rows() const { return columns() > 0 ? values.size() / columns() : 0; }
};

/// Arrays by name, without the extension .npy.
using Npz = std::map<std::string, NpyArray, std::less<>>;

/// Reads the arrays `wanted` of an .npz file that exist in it. Arrays of other types than numbers (text, Python objects) are left out.
/// Errors: not a zip, damaged or encrypted entries, wrong headers, numbers that are not finite or above 1e9, more than 400 million numbers.
[[nodiscard]] Result<Npz> read_npz(std::span<const std::byte> bytes, std::string_view location, std::span<const std::string_view> wanted);

/// Reads one array from the bytes of an .npy file. An array of another type than numbers has no values and the shape {0}.
[[nodiscard]] Result<NpyArray> read_npy(std::string_view bytes, std::string_view location);

}  // namespace ugoki::scene_formats
