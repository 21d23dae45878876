#pragma once
// A mechanism of another size and mass.

#include <span>
#include <vector>

#include "ugoki/mechanism_edit/edited.h"

namespace ugoki {

/// How one link grows. Along its bone and across it lengths change by different factors; mass by a third.
struct LinkScale {
  double along = 1;   ///< lengths along the bone
  double across = 1;  ///< lengths at a right angle to it
  double mass = 1;
};

struct ScaleOptions {
  double length = 1;   ///< factor of all lengths, above 0
  double mass = 0;     ///< kg, of the whole; 0: density is kept, so the mass grows with the volume
  bool stout = false;  ///< true: density is kept where `mass` is given, and the links become as stout as that demands; false: the
                       ///< shape is kept, and density takes what the mass demands
};

/// Scales every length, mass and moment, and with them what acts in the joints, by dynamic similarity under the same gravity (Alexander and
/// Jayes 1983): with lengths l and mass m, times grow by sqrt(l), forces by m, torques and rotational stiffness by m l, rotational damping
/// by m l sqrt(l), armature by m l^2 (displacements: stiffness m / l, damping m / sqrt(l), armature m). A scaled motion then needs the
/// scaled torques. Errors: factors that are not above 0 or not finite, a mass that the mechanism lacks altogether.
[[nodiscard]] Result<Edited> scale(const Mechanism& mechanism, const ScaleOptions& options);

/// The same with factors for each link: positions of the joints on a link, its shapes and its inertia follow the affine map
/// A = across 1 + (along - across) u u^T about the link's origin, u = the direction of its bone (to the joint of its child with the most
/// mass behind it, otherwise to its centre of mass); second moments of mass about the origin P' = mass A P A, exact for any body. Shapes
/// that A does not map to their own kind take the nearest: a sphere keeps its volume, boxes and ellipsoids take the factor along each of
/// their axes, capsules and cylinders along their axis and the mean of those across; meshes are mapped exactly. Joint forces scale by each
/// link's own along and the whole's mass. @param scales [links]
[[nodiscard]] Result<Edited> scale_links(const Mechanism& mechanism, std::span<const LinkScale> scales);

/// Direction of each link's bone as scale_links takes it: unit, in the link; zero where nothing says. [links]
[[nodiscard]] std::vector<Vec3> bone_directions(const Mechanism& mechanism);

}  // namespace ugoki
