#pragma once
// What a COLLADA file tells of nodes, skins' joints and animations, checked before assimp sees it. Internal to scene_formats.

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "ugoki/base/result.h"

namespace ugoki::scene_formats {

/// A document of the same nodes, transformations and animation channels, in which every reference, count and number is right. Whatever the
/// skeleton does not need is left out (materials, cameras, the shape of meshes: each mesh becomes one triangle, each skin the list of the
/// joints that it hangs on), so that faults there do no harm. Errors: what the nodes, skins or channels refer to is missing, too short,
/// no number, or goes round in a circle.
/// @param place of the problems: the file's name
[[nodiscard]] Result<std::string> collada_core(std::span<const std::byte> bytes, std::string_view place);

}  // namespace ugoki::scene_formats
