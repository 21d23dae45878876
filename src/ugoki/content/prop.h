#pragma once
// Props: bodies made from a few numbers (boxes, ramps, stairs, ...) or from a mesh, which stand fixed in the world or move as passive
// bodies. docs/scenario.md describes the JSON form.

#include <string>
#include <string_view>

#include "ugoki/base/result.h"
#include "ugoki/mechanism/mechanism.h"

namespace ugoki::content {

///   box       length x, width y, height z
///   ramp      rises along x over the length x to the height z
///   stairs    `steps` steps that rise along x over the length x to the height z
///   cylinder  upright: diameter x, height z
///   sphere    diameter x
///   bar       horizontal bar along y between two posts: diameter x, width y between the posts, height z of its axis
///   mesh      the surface of the mechanism `mesh` (is_mesh_body()), scaled
///   terrain   hills (make_terrain()) on a length x and a width y, up to the height z; fixed in the world
enum class PropShape { box, ramp, stairs, cylinder, sphere, bar, mesh, terrain };
[[nodiscard]] std::string_view name_of(PropShape shape);

/// What of a mesh collides.
///   hull     the convex hull of the whole mesh
///   parts    the convex hull of each of its connected parts
///   surface  its triangles, from both sides
enum class MeshCollision { hull, parts, surface };
[[nodiscard]] std::string_view name_of(MeshCollision collision);

/// The frame of a prop has its origin in the centre of the bottom.
struct Prop {
  static constexpr double min_size = 0.005, max_size = 1000;  ///< m
  static constexpr int max_steps = 200;
  static constexpr double max_mass = 1e6;  ///< kg
  static constexpr double min_scale = 1e-4, max_scale = 1e4;
  static constexpr double min_grain = 0.05, max_grain = 100;  ///< m
  static constexpr int max_seed = 999'999;
  PropShape shape = PropShape::box;
  Vec3 size = {1, 1, 1};                          ///< m; components that the shape does not use are ignored
  int steps = 5;                                  ///< number of steps (stairs)
  double grain = 2;                               ///< m, about the distance from a hill to the next hollow (terrain)
  int seed = 1;                                   ///< another seed gives other hills, 0 to max_seed (terrain)
  std::string mesh = {};                          ///< id of a mechanism that is a mesh body (mesh)
  Vec3 scale = {1, 1, 1};                         ///< factors on the lengths along the axes of the mesh (mesh)
  MeshCollision collision = MeshCollision::hull;  ///< (mesh)
  Vec3 tilt;               ///< deg, from -180 to 180: rotation about x, then about the rotated y, then z, of the prop in its frame
  double mass = 0;         ///< kg; 0: fixed in the world
  double friction = 0.8;   ///< Coulomb coefficient, 0 to 10
  double restitution = 0;  ///< 0 to 1
  friend bool operator==(const Prop&, const Prop&) = default;
};

/// Reports values out of range.
void check_prop(const Prop& prop, const std::string& location, Error& problems);

/// Id of the mechanism of a prop. It depends only on the prop's values; ids of other mechanisms do not begin with "prop.".
[[nodiscard]] std::string prop_mechanism_id(const Prop& prop);
/// Whether a mechanism's id is that of a prop.
[[nodiscard]] bool is_prop_mechanism(std::string_view id);
/// Whether a mechanism is a mesh body: one fixed link "body" with a mass, whose shapes are meshes. The visible shapes show the mesh. The
/// invisible ones are its convex hull, which collides, and the hulls of its connected parts, which do not. The origin is in the centre of
/// the bottom. With textures, it has a skin.
[[nodiscard]] bool is_mesh_body(const Mechanism& mechanism);
/// The mechanism of a prop: one link with the name "body". With a mass, its joint is floating and its density is uniform; otherwise it is
/// fixed.
/// @param prop must be valid (check_prop())  @param mesh the mechanism `prop.mesh`, a mesh body; null for other shapes
[[nodiscard]] MechanismPtr make_prop(const Prop& prop, const MechanismPtr& mesh = nullptr);

}  // namespace ugoki::content
