#pragma once
// Measured data as stored in motion-capture files: a skeleton of joints and, for every animation frame, each joint's local translation and
// rotation. Metres, radians, Z up, X forward; at rest every joint's frame is parallel to the world's.

#include <string>
#include <vector>

#include "ugoki/spatial/spatial.h"

namespace ugoki {

/// One rotational DOF of a joint in the file.
struct MeasuredDof {
  Vec3 axis;  ///< unit, in the joint's rest frame
  bool limited = false;
  double lower = 0, upper = 0;  ///< rad, valid if limited
};

struct SkeletonJoint {
  std::string name;
  int parent = -1;                     ///< index of the parent joint, smaller than the joint's own index; -1: a root
  Vec3 offset;                         ///< m, from the parent joint at rest (roots: from the origin)
  std::vector<Vec3> end_sites;         ///< m, ends of bones without a further joint, relative to this joint at rest
  std::vector<MeasuredDof> dofs;       ///< rotation DOFs in the order of the file (outermost first); empty: a rigid joint
  bool translates = false;             ///< the translation of the joint is measured too
  std::string rotation_order = "ZXY";  ///< order of the rotation channels in the FILE's axes; used when the file is written again
};

struct Skeleton {
  std::string name;
  std::vector<SkeletonJoint> joints;
  double unit = 1;  ///< m per length unit of the file
  double mass = 0;  ///< kg; 0 if the file does not specify it
};

/// A skeleton with its measured frames.
struct MeasuredMotion {
  std::string name;    ///< from the file's name
  std::string source;  ///< file name as read
  Skeleton skeleton;
  double rate = 120;  ///< frames per second
  int frames = 0;
  std::vector<Vec3> translations;  ///< [frames][joints] m, position of the joint in its parent's frame
  std::vector<Quat> rotations;     ///< [frames][joints] orientation of the joint's frame in its parent's frame

  [[nodiscard]] int joint_count() const { return static_cast<int>(skeleton.joints.size()); }
  [[nodiscard]] double duration() const { return frames > 1 ? (frames - 1) / rate : 0; }
  /// Computes the world pose of every joint in a frame. @param X [joints, out], resized
  void calc_joint_poses(int frame, std::vector<Pose>& X) const;
};

/// World positions [m] of all joints at rest, with roots at their offset. [joints]
[[nodiscard]] std::vector<Vec3> rest_positions(const Skeleton& skeleton);

/// Height [m] of the skeleton at rest, from the lowest to the highest joint or end site.
[[nodiscard]] double rest_height(const Skeleton& skeleton);

}  // namespace ugoki
