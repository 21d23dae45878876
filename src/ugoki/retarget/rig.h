#pragma once
// A character prepared for retargeting: anatomical axes of every link, geometry of the limbs, soles, standing posture.

#include <array>
#include <string>
#include <vector>

#include "ugoki/motion_edit/feet.h"
#include "ugoki/retarget/anatomy.h"
#include "ugoki/retarget/chain_solver.h"

namespace ugoki::retarget {

/// Geometry of one limb, as inverse kinematics needs it.
struct LimbRig {
  bool found = false;
  int root = -1;               ///< first link of the upper section: its origin is the hip or the shoulder
  int knee = -1;               ///< link whose hinge bends the limb between upper and lower section; -1: a ball joint, or several axes
  double knee_sign = 1;        ///< 1: positive angles flex the knee; -1: negative angles flex it
  std::vector<int> chain;      ///< links from the root (on fore legs from the shoulder blade) to `end`
  std::vector<int> upper;      ///< links of the chain above the knee
  std::vector<int> ankle;      ///< last links of the chain: they rotate about the end point and do not move it
  std::vector<int> movers;     ///< links of the chain that are not in `ankle`: they move the end point
  int end = -1;                ///< link that stands on the ground or holds objects: foot, paw, hand
  Vec3 end_point;              ///< m, in the frame of `end`: point moved to the goal; the frame's origin, or the sole's only point
  bool point_foot = false;     ///< true: the sole is a single point, so the foot's orientation is free
  bool end_is_ankle = false;   ///< the end point is the end of the lower section: the limb is solved in closed form
  Vec3 bend_axis;              ///< unit, in the frame of the upper section's last link; positive rotations flex knee or elbow
  double length = 0;           ///< m, sum of the lengths of upper and lower section
  Vec3 stand;                  ///< m, from root to end point in the standing posture, in anatomical axes
  Vec3 stand_tip;              ///< m, from root to the origin of the toes in the standing posture, in anatomical axes
  int tip = -1;                ///< first link of the toes; -1: none
  motion_edit::FootLimb sole;  ///< points that bear on the ground; a single point at the origin of `end` if the foot has no shape
  bool has_sole = false;       ///< true: the sole comes from shapes or from the mapping; false: it is a default
};

/// A character prepared by make_rig.
struct Rig {
  MechanismPtr mechanism;
  Anatomy anatomy;
  std::vector<Mat3> F;          ///< [links] anatomical axes of the link, in its own frame
  std::vector<Mat3> G;          ///< [links] world orientation of the axes F while the character stands and faces X
  std::vector<Vec3> along;      ///< [links] unit vector, own frame: direction of the link's limb section; zero: not in a limb
  std::vector<double> q_stand;  ///< [nq] standing posture, within the joint limits
  std::array<LimbRig, limb_count> limbs;
  double hip_height = 0;           ///< m, height of the midpoint between the hips above the soles in the standing posture
  double leg_length = 0;           ///< m, mean length of both legs
  std::vector<std::string> notes;  ///< sentences about assumptions

  [[nodiscard]] const LimbRig& limb(LimbName name) const { return limbs[static_cast<std::size_t>(name)]; }
};

/// Sole of one foot from a mapping file.
struct SoleSpec {
  std::string link;
  std::vector<Vec3> points;  ///< m, points that bear on the ground, in the link's frame
};
/// Prepares a character. @param names, soles from the mapping; empty: found automatically. Errors: the errors of find_anatomy.
[[nodiscard]] Result<Rig> make_rig(MechanismPtr mechanism, const AnatomyNames& names = {}, const std::vector<SoleSpec>& soles = {});

}  // namespace ugoki::retarget
