#pragma once
// Motions as bytes, for databases: little-endian, versioned, checksummed. The layout is described in docs/formats.md.

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/motion/motion.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::formats {

/// Every bit of the motion. O(numbers).
[[nodiscard]] std::vector<std::byte> write_motion(const Motion& motion);
/// Errors name the byte. Memory is taken only for what the bytes hold.
[[nodiscard]] Result<Motion> read_motion(std::span<const std::byte> bytes, std::string_view name);

/// The same for measured data with its skeleton.
[[nodiscard]] std::vector<std::byte> write_measured_motion(const MeasuredMotion& motion);
[[nodiscard]] Result<MeasuredMotion> read_measured_motion(std::span<const std::byte> bytes, std::string_view name);

}  // namespace ugoki::formats
