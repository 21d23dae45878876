#pragma once
// A figure made ready for retargeting: anatomical axes in every link, places of hips and soles, how it stands.

#include <array>
#include <string>
#include <vector>

#include "ugoki/motion_edit/feet.h"
#include "ugoki/retarget/chain_solver.h"
#include "ugoki/retarget/figure.h"

namespace ugoki::retarget {

/// One limb with what inverse kinematics needs.
struct LimbRig {
  bool found = false;
  int root = -1;               ///< first link of the upper section: its origin is the hip or the shoulder
  int knee = -1;               ///< hinge between upper and lower section that bends it; -1: a ball, or several axes
  double knee_sign = 1;        ///< 1: positive angles flex it
  std::vector<int> chain;      ///< links from the root (on fore legs the shoulder blade) to `end`
  std::vector<int> upper;      ///< those of them that are above the knee
  std::vector<int> ankle;      ///< the last of them that turn about the led place and so do not move it
  std::vector<int> movers;     ///< the others, which do
  int end = -1;                ///< the link that stands on the ground or holds: foot, paw, hand
  Vec3 end_point;              ///< m, the place of `end` that is led, in its frame: its origin, or the only place that bears
  bool point_foot = false;     ///< it stands on a single place; its orientation is free
  bool end_is_ankle = false;   ///< the led place is where the lower section ends, so that the limb is solved in closed form
  Vec3 bend_axis;              ///< unit, in the root section's last link: positive turns flex knee or elbow
  double length = 0;           ///< m, upper and lower section
  Vec3 stand;                  ///< m, from root to the led place while it stands, in anatomical axes
  Vec3 stand_tip;              ///< m, the same to the place where the toes begin
  int tip = -1;                ///< link whose origin that place is; -1: none
  motion_edit::FootLimb sole;  ///< places that bear; a single one at the origin of `end` if the file has no shape there
  bool has_sole = false;
};

struct Rig {
  MechanismPtr mechanism;
  Figure figure;
  std::vector<Mat3> F;      ///< [links] anatomical axes of the link, in its own frame
  std::vector<Mat3> G;      ///< [links] these axes in the world while the figure stands facing X
  std::vector<Vec3> along;  ///< [links] unit, the direction of the link's section in its own frame; zero: it has none
  std::vector<double> q_stand;
  std::array<LimbRig, limb_count> limbs;
  double hip_height = 0;  ///< m above the soles while it stands: of the middle between the hips
  double leg_length = 0;  ///< m, mean of the legs
  std::vector<std::string> notes;

  [[nodiscard]] const LimbRig& limb(LimbName name) const { return limbs[static_cast<std::size_t>(name)]; }
};

/// @param soles of the mapping: links that stand on the ground, with the places of their soles in the link's frame
struct SoleSpec {
  std::string link;
  std::vector<Vec3> points;
};
[[nodiscard]] Result<Rig> make_rig(MechanismPtr mechanism, const FigureNames& names = {}, const std::vector<SoleSpec>& soles = {});

}  // namespace ugoki::retarget
