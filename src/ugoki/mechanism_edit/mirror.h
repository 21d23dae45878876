#pragma once
// Mirror image of a mechanism.

#include <span>

#include "ugoki/mechanism_edit/edited.h"

namespace ugoki {

struct MirrorOptions {
  int normal = 1;          ///< normal of the mirror plane through the world's origin: 0 x, 1 y (left and right), 2 z
  bool swap_sides = true;  ///< exchange left and right in names and labels (mirrored_names.h)
};

/// Reflects every frame, inertia, shape and joint: X' = S X S with S = 1 - 2 n n^T and the plane's normal n, so that rotations remain
/// rotations. For a joint axis a, angles keep their values about the axis -S a, and displacements keep their values along S a. If one axis
/// has an angle and a displacement (cylindrical), or three components share a frame (planar, spherical), some coordinates and their limits
/// change sign (mirror_position). Mirroring twice gives the original, bit by bit, except that data precomputed for collision analysis is
/// dropped.
/// Errors: a height field with a mirror plane normal to z.
[[nodiscard]] Result<Edited> mirror(const Mechanism& mechanism, const MirrorOptions& options = {});

/// Computes the position of mirror(mechanism) that is the mirror image of q. @param q, q_mirrored [nq]; may alias
void mirror_position(const Mechanism& mechanism, std::span<const double> q, std::span<double> q_mirrored,
                     const MirrorOptions& options = {});

}  // namespace ugoki
