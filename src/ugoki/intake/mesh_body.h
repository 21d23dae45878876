#pragma once
// Makes a mesh body, from which the studio makes props, from the triangles of a mesh file.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/mechanism/mechanism.h"
#include "ugoki/scene_formats/mesh_scene.h"

namespace ugoki::intake {

inline constexpr std::size_t max_hull_parts = 256;  ///< a mesh with more connected parts has no hulls of its parts

/// A mesh body with what the user should know about it.
struct MeshBody {
  /// content::is_mesh_body(); its mass is that of its volume at 1000 kg/m^3. With textures, the surface is also its skin.
  MechanismPtr mechanism;
  std::vector<std::string> colors;  ///< [visible shapes] "#rrggbb"; empty: the file gives none
  Vec3 size;                        ///< m, of the box around it
  double volume = 0;                ///< m^3, of the surface; of the convex hull if the surface is open
  bool closed = false;              ///< the surface encloses a volume
  std::size_t triangles = 0;
  std::size_t parts = 0;                     ///< hulls of connected parts in the mechanism; 1: only that of the whole
  std::vector<std::string> changed, checks;  ///< sentences: repairs; what to check
};

/// Makes the body. The origin is moved to the centre of the bottom. Flat parts get a thickness of 2 mm for their hulls.
/// Errors (at `location`): the mesh is smaller than 1 mm or larger than 10 km, has no triangle with an area, and those of hulls.
[[nodiscard]] Result<MeshBody> make_mesh_body(const scene_formats::MeshScene& scene, const std::string& name, std::string_view location);

}  // namespace ugoki::intake
