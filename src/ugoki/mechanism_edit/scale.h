#pragma once
// Scales the size and mass of a mechanism.

#include <span>
#include <vector>

#include "ugoki/mechanism_edit/edited.h"

namespace ugoki {

/// Scale factors of one link.
struct LinkScale {
  double along = 1;   ///< factor of lengths along the bone
  double across = 1;  ///< factor of lengths perpendicular to the bone
  double mass = 1;    ///< factor of the mass
};

struct ScaleOptions {
  double length = 1;   ///< factor of all lengths, above 0
  double mass = 0;     ///< kg, new total mass; 0: density is kept, so the mass is scaled with the volume
  bool stout = false;  ///< if `mass` is given; true: density is kept and links get thicker or thinner; false: proportions are kept and
                       ///< the density changes
};

/// Scales all lengths, masses and moments of inertia, and the joint parameters by dynamic similarity under the same gravity (Alexander and
/// Jayes 1983). With length factor l and mass factor m: times scale by sqrt(l), forces by m, torques and rotational stiffness by m l,
/// rotational damping by m l sqrt(l), armature by m l^2; for displacements stiffness by m / l, damping by m / sqrt(l), armature by m. The
/// scaled motion then needs the scaled torques.
/// Errors: a factor that is not finite or not above 0; a new mass for a mechanism without mass.
[[nodiscard]] Result<Edited> scale(const Mechanism& mechanism, const ScaleOptions& options);

/// Scales each link by its own factors. The joints on a link, its shapes and its inertia follow the affine map
/// A = across 1 + (along - across) u u^T about the link's origin, where u is the direction of its bone (bone_directions). The second
/// moments of mass about the origin are P' = mass A P A, exact for any body. Meshes are mapped exactly. Other shapes keep their type and
/// are approximated: a sphere gets the mapped volume, boxes and ellipsoids the factor along each of their axes, capsules and cylinders the
/// factor along their axis and the geometric mean of the two factors across. Joint forces scale with `along` of the parent link (for joints
/// to the world: of the link itself) and with the factor of the total mass.
/// @param scales [links]
[[nodiscard]] Result<Edited> scale_links(const Mechanism& mechanism, std::span<const LinkScale> scales);

/// Direction of each link's bone: unit vector in the link's frame, from its origin to the joint of the child whose subtree has the largest
/// mass. Without such a child, to its centre of mass; zero if it has no mass either. [links]
[[nodiscard]] std::vector<Vec3> bone_directions(const Mechanism& mechanism);

}  // namespace ugoki
