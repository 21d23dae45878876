#pragma once
// The legs of a mechanism as the measures of naturalness see them: pairs of legs, knees, leg links, head, height of the centre of mass.

#include <vector>

#include "ugoki/motion_edit/feet.h"

namespace ugoki::naturalness {

struct Leg {
  motion_edit::FootLimb limb;
  int other = -1;                       ///< index of the leg on the other side; -1: none
  int hip = -1, knee = -1;              ///< links whose joints are hip and knee; -1: the leg has no knee
  std::vector<int> dofs;                ///< velocity indices of the joints between root and foot, the foot's and the toes' included
  std::vector<std::size_t> foot_slots;  ///< indices in find_feet() of the links of this foot
};

struct BodyLegs {
  std::vector<Leg> legs;
  std::vector<int> feet;         ///< find_feet()
  std::vector<int> leg_of_link;  ///< [links] index of the foot to which a link belongs; -1: none
  std::vector<char> in_leg;      ///< [links] 1: the link belongs to a leg, its foot or toes
  std::vector<char> in_trunk;    ///< [links] 1: the link is the head or between it and the base
  int head = -1;                 ///< link with the label "head"; -1: none
  double centre_height = 1;      ///< m: height of the centre of mass above the lowest point in the neutral position
  bool floating = false;         ///< the root is free
  [[nodiscard]] bool biped() const { return legs.size() == 2 && legs[0].other == 1; }
};

[[nodiscard]] BodyLegs find_legs(const Mechanism& mechanism);

}  // namespace ugoki::naturalness
