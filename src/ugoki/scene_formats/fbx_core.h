#pragma once
// What an FBX file tells of nodes, skins' joints and animations, checked before assimp sees it. Internal to scene_formats.

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "ugoki/base/result.h"

namespace ugoki::scene_formats {

/// A binary FBX 7.4 file of the same models, skins and animation curves, in which every connection, count and number is right. Whatever the
/// skeleton does not need is left out (materials, cameras, poses, blend shapes, the shape of meshes: each becomes one triangle, which hangs
/// on all joints of its skin), so that faults there do no harm. Errors: records that do not lie within each other, curves cut off or with
/// times that go back, models that stand below themselves.
/// @param place of the problems: the file's name
[[nodiscard]] Result<std::string> fbx_core(std::span<const std::byte> bytes, std::string_view place);

}  // namespace ugoki::scene_formats
