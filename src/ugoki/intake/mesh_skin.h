#pragma once
// Textures of a mesh file: the surface as the skin of a mesh body. Internal to intake.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/mechanism/skin.h"
#include "ugoki/scene_formats/mesh_scene.h"

namespace ugoki::intake {

/// Returns the surface with its textures and colours; all vertices follow one bone. Null if no part has a texture, or if the surface
/// exceeds the limits of skins, which `checks` then reports.
/// @param vertices [scene.vertices] m, in the frame of the body
[[nodiscard]] SkinPtr make_mesh_skin(const scene_formats::MeshScene& scene, const std::vector<Vec3>& vertices, std::string_view location,
                                     std::vector<std::string>& checks);

}  // namespace ugoki::intake
