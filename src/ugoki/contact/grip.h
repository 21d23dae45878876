#pragma once
// A grip: a constraint that is made at run time and holds a point of one link, and optionally its orientation, at another link or the
// world.
//
// Let P be the gripping point on link a, T its target on link b or in the world, X' the value of X after the step. The step requires
//   P' - T' = 0,   and for a rigid grip R_a' = R_b' R_hold
// The positions after the step are nonlinear in the velocities. Their curvature is taken from the motion at the velocities before the step:
//   J v' = -(g + N) / dt,   N = g(q (+) v dt) - g(q) - dt J v       g: gap P - T, J: its Jacobian, N: part of second order
// The change of velocity is then that of a constraint force along the chord of the path (as in the method SHAKE), which keeps the energy
// of a swinging body.
// Source: Ryckaert, Ciccotti, Berendsen (1977), Numerical integration of the Cartesian equations of motion of a system with constraints.

#include <cstdint>

#include "ugoki/spatial/rotation.h"
#include "ugoki/spatial/spatial.h"

namespace ugoki::contact {

struct Grip {
  std::int32_t system_a = 0, link_a = 0;
  std::int32_t system_b = -1, link_b = -1;  ///< -1: the world
  Vec3 p_a;                                 ///< m: gripping point in the frame of link a
  Vec3 p_b;                                 ///< m: target in the frame of link b, or in the world
  Quat hold;                                ///< rigid grip: orientation of link a in the frame of link b, or in the world
  std::uint64_t rigid = 0;                  ///< 1: the orientation is held as well
  std::uint64_t key = 0;                    ///< identifies the grip from step to step, 0 ... 2^32 - 1
};

}  // namespace ugoki::contact
