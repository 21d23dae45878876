#pragma once
// Reduces a COLLADA document to its nodes, joints of skins and animations, and checks them before assimp reads them. Internal to
// scene_formats.

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "ugoki/base/result.h"

namespace ugoki::scene_formats {

/// Returns a COLLADA document with the same nodes, transformations and animation channels, in which every reference, count and number has
/// been checked. Data that the skeleton does not need are removed, so that defects in them do no harm: materials, cameras, mesh data (each
/// mesh becomes one triangle, each skin a list of its weighted joints). Errors: nodes, skins or channels refer to data that are missing,
/// too short or not numbers, or <instance_node> elements form a cycle.
/// @param location name of the file, for error messages
[[nodiscard]] Result<std::string> collada_core(std::span<const std::byte> bytes, std::string_view location);

/// Index of the up axis that a COLLADA document states: 0 x, 1 y, 2 z; 1 if it states none.
[[nodiscard]] int collada_up_axis(std::string_view document);

}  // namespace ugoki::scene_formats
