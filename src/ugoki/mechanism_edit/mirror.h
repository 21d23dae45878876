#pragma once
// The mirror image of a mechanism.

#include <span>

#include "ugoki/mechanism_edit/edited.h"

namespace ugoki {

struct MirrorOptions {
  int normal = 1;          ///< the mirror is the plane through the world's origin at a right angle to this axis: 0 x, 1 y (the usual), 2 z
  bool swap_sides = true;  ///< exchange left and right in names and labels (mirrored_names.h)
};

/// Every frame, inertia, shape and joint reflected: X' = S X S with S = 1 - 2 n n^T, which leaves rotations rotations. Rotations keep their
/// coordinate and turn about -S a; displacements keep theirs along S a. Where an axis serves both (cylindrical) or three components share a
/// frame (planar, spherical) some coordinates change sign, with their limits (mirror_position). Mirrored twice it is the original, bit by
/// bit, but for what collision analysis prepared for meshes, which is dropped.
/// Errors: a height field in a mirror at a right angle to its own z.
[[nodiscard]] Result<Edited> mirror(const Mechanism& mechanism, const MirrorOptions& options = {});

/// The position of mirror(mechanism) that is the mirror image of q. @param q, q_mirrored [nq], may alias
void mirror_position(const Mechanism& mechanism, std::span<const double> q, std::span<double> q_mirrored,
                     const MirrorOptions& options = {});

}  // namespace ugoki
