#pragma once
// Points at which a character is held, for example its hands on a bar. Balance control treats them as supports beside the feet.

#include "ugoki/spatial/rotation.h"
#include "ugoki/spatial/vec3.h"

namespace ugoki::control {

/// A grip (contact::Grip), as the character on one of its two sides sees it.
struct HeldPoint {
  int link = -1;           ///< link of this character
  Vec3 p;                  ///< m, world: the held point
  Vec3 velocity, turning;  ///< m/s, rad/s, world: velocity and angular velocity of the held point's place on the other side
  bool rigid = false;      ///< the orientation of the link is held as well
  bool fixed = true;       ///< the grip carries the character: the other side cannot move, or moves by forces of its own
  double mass = 0;         ///< kg: share of the mass of a passive object that this point carries; a share counts as a mass at the point
};

}  // namespace ugoki::control
