#pragma once
// A mechanism prepared for gaits: standing posture, legs with soles, trunk and arms. Internal to gait.

#include <optional>

#include "ugoki/gait/pattern.h"
#include "ugoki/motion_edit/feet.h"
#include "ugoki/retarget/rig.h"

namespace ugoki::gait {

/// One leg. Frames: H is the heading frame (x forward, y left, z up); F the frame of the foot's link.
struct WalkerLeg {
  int link = -1;           ///< the foot
  int hip = -1;            ///< first link of the chain
  std::vector<int> chain;  ///< links from the hip to the foot
  double length = 0;       ///< m: maximum distance from the hip to `point`
  LegPlace place;
  bool point_foot = false;                 ///< the sole is a point; the orientation of the foot is free
  Vec3 point;                              ///< m, in F: point that inverse kinematics moves
  Mat3 R_HF;                               ///< orientation of the foot that is flat on the ground
  Vec3 sole;                               ///< m, in F: middle of the sole, on the ground
  Vec3 heel, toe;                          ///< m, in F: centres of the rounded back and front edges of the sole
  double heel_radius = 0, toe_radius = 0;  ///< m
  Vec3 home;                               ///< m, in H: the middle of the sole while the character stands, from the centre of mass; z = 0
  int limb = -1;                           ///< limb of the rig (retarget::LimbName) with thigh and shank; -1: none
  double hip_ahead = 0;                    ///< m, in H: x of the hip, from the centre of mass
  double hip_side = 0;                     ///< m, in H: y of the hip
  std::vector<int> toes;                   ///< links of the toes, which stay level while the heel rises
  std::vector<Vec3> points;                ///< m, in F: low points of the sole
  std::vector<double> radii;               ///< m
};

struct Walker {
  MechanismPtr mechanism;
  std::optional<retarget::Rig> rig;  ///< nothing: no anatomy was found
  bool biped = false;
  std::vector<double> q_stand;   ///< [nq] posture from which inverse kinematics starts; faces +x
  Mat3 R_HA = Mat3::identity();  ///< heading of the neutral position: from anatomical axes to the world
  Mat3 R_root;                   ///< orientation of the root while the character stands and faces +x
  std::vector<WalkerLeg> legs;
  double hip_height = 0;     ///< m
  double centre_height = 0;  ///< m: height of the centre of mass while the character stands
  double mass = 0;           ///< kg
  std::vector<std::string> notes;
};

/// Errors: see make_gait.
[[nodiscard]] Result<Walker> make_walker(const MechanismPtr& mechanism);

}  // namespace ugoki::gait
