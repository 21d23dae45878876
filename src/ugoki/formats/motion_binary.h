#pragma once
// Binary form of motions for databases: little-endian, versioned, with a checksum. docs/formats.md describes the layout.

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/motion/motion.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::formats {

/// Returns `motion` as bytes, from which read_motion restores every number bit for bit. O(coordinates).
[[nodiscard]] std::vector<std::byte> write_motion(const Motion& motion);
/// Reads bytes of write_motion. Errors have the location "name: byte N". Allocations are bounded by the size of the data.
/// @param name identifies the data in error messages
[[nodiscard]] Result<Motion> read_motion(std::span<const std::byte> bytes, std::string_view name);

/// The same as write_motion and read_motion, for a measured motion with its skeleton.
[[nodiscard]] std::vector<std::byte> write_measured_motion(const MeasuredMotion& motion);
[[nodiscard]] Result<MeasuredMotion> read_measured_motion(std::span<const std::byte> bytes, std::string_view name);

}  // namespace ugoki::formats
