#pragma once
// Parts of make_body that share what was recognised of a human skeleton.

#include <vector>

#include "ugoki/body/anatomy.h"
#include "ugoki/body/body.h"
#include "ugoki/body/floor.h"

namespace ugoki::body {

/// The sole of one foot in its link's frames at rest (anatomical axes).
struct SoleShape {
  int foot = -1, toes = -1;
  Vec3 foot_up, foot_forward;  ///< unit, in the foot's frame: ground normal, direction to the toes along the ground
  Vec3 toes_up, toes_forward;  ///< the same in the toes' frame
  Vec3 ball;                   ///< m, from the ankle
  double tip = 0;              ///< m, from the ball to the tip of the toes along the ground
  double heel = 0;             ///< m, from the ankle back to the heel along the ground
  double thickness = 0;        ///< m, from the ball to the ground
  double ankle = 0;            ///< m, from the ankle to the ground
};

/// What the parts of a human body are built from. All in anatomical axes.
struct Build {
  const Anatomy& anatomy;
  double height = 0, mass = 0;
  double breadth = 1;  ///< thickness of limbs against that of 1.75 m and 70 kg
  std::vector<SoleShape> soles;

  [[nodiscard]] const SoleShape* sole_of(int joint) const {
    for (const SoleShape& s : soles)
      if (s.foot == joint || s.toes == joint) return &s;
    return nullptr;
  }
};

/// The slabs of the trunk: joint i of Anatomy::trunk carries the trunk between heights [i] and [i + 1] (m, rest, A's axes).
[[nodiscard]] std::vector<double> trunk_heights(const Build& build);
/// Height at rest of the top of the head. m
[[nodiscard]] double head_top(const Build& build);

/// Mass properties of every joint's link, in A's axes at the joint: de Leva's, spread over links where a segment has
/// several; exactly mirrored left and right; summing to the mass.
[[nodiscard]] std::vector<Inertia> human_inertias(const Build& build, Sex sex);
/// Shapes of joint i's link in A's axes at the joint.
[[nodiscard]] std::vector<Shape> human_shapes(const Build& build, int i);

}  // namespace ugoki::body
