#pragma once
// Reduces an FBX file to its nodes, joints of skins and animations, and checks them before assimp reads them. Internal to scene_formats.

#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <string_view>

#include "ugoki/base/result.h"
#include "ugoki/spatial/vec3.h"

namespace ugoki::scene_formats {

/// Returns a binary FBX 7.4 file with the same models, skins and animation curves, in which every connection, count and number has been
/// checked. Data that the skeleton does not need are removed, so that defects in them do no harm: materials, cameras, poses, blend shapes,
/// mesh data (each mesh becomes one triangle, which is bound to all joints of its skin). Errors: records that exceed their parent record,
/// truncated curves, key times that decrease, models that are their own ancestors.
/// @param location name of the file, for error messages
/// @param mesh_ends if not null, receives the far ends of the bones (fbx_mesh_ends())
[[nodiscard]] Result<std::string> fbx_core(std::span<const std::byte> bytes, std::string_view location,
                                           std::map<std::string, Vec3>* mesh_ends = nullptr);

}  // namespace ugoki::scene_formats
