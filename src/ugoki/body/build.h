#pragma once
// Steps of make_body that use the recognised human anatomy. Internal to body.

#include <vector>

#include "ugoki/body/anatomy.h"
#include "ugoki/body/body.h"
#include "ugoki/body/floor.h"

namespace ugoki::body {

/// Geometry of the sole of one foot at rest, in anatomical axes.
struct SoleShape {
  int foot = -1, toes = -1;    ///< skeleton joints; toes -1: none
  Vec3 foot_up, foot_forward;  ///< unit, in the foot's frame: ground normal, direction of the toes along the ground
  Vec3 toes_up, toes_forward;  ///< unit, in the toes' frame: ground normal, direction of the toes along the ground
  Vec3 ball;                   ///< m, ball of the foot relative to the ankle
  double tip = 0;              ///< m, from the ball to the tip of the toes along the ground
  double heel = 0;             ///< m, from the ankle back to the heel along the ground
  double thickness = 0;        ///< m, height of the ball above the ground
  double ankle = 0;            ///< m, height of the ankle above the ground
};

/// Size and proportions of a human body (its build), in anatomical axes. `anatomy` must outlive it.
struct Build {
  const Anatomy& anatomy;
  double height = 0, mass = 0;   ///< m, kg
  double breadth = 1;            ///< thickness of the limbs relative to that of a person of 1.75 m and 70 kg scaled to this height
  std::vector<SoleShape> soles;  ///< left, right

  /// Sole whose foot or toes is `joint`; null: none.
  [[nodiscard]] const SoleShape* sole_of(int joint) const {
    for (const SoleShape& s : soles)
      if (s.foot == joint || s.toes == joint) return &s;
    return nullptr;
  }
};

/// Heights [trunk joints + 1] that divide the trunk, in m at rest, along z of the anatomical frame A (Anatomy). Joint i of Anatomy::trunk
/// carries the part from height i to height i + 1.
[[nodiscard]] std::vector<double> trunk_heights(const Build& build);
/// Height [m] of the top of the head at rest, along z of the anatomical frame A.
[[nodiscard]] double head_top(const Build& build);

/// Mass properties [joints] of the links, with the joint as origin and the axes of the anatomical frame A. De Leva's segments are
/// distributed over the links of each segment. Left and right are exactly mirrored. The masses sum to build.mass.
[[nodiscard]] std::vector<Inertia> human_inertias(const Build& build, Sex sex);
/// Shapes of joint i's link, with the joint as origin and the axes of the anatomical frame A.
[[nodiscard]] std::vector<Shape> human_shapes(const Build& build, int i);

}  // namespace ugoki::body
