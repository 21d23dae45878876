#pragma once
// Measured data as a motion-capture file holds it: a skeleton of joints and, for every frame, each joint's local
// translation and rotation. All in metres, radians, Z up, X forward; every joint's frame is parallel to the world's at rest.

#include <string>
#include <vector>

#include "ugoki/spatial/spatial.h"

namespace ugoki {

/// One rotation freedom that the file gives a joint.
struct MeasuredFreedom {
  Vec3 axis;  ///< unit, in the joint's rest frame
  bool limited = false;
  double lower = 0, upper = 0;  ///< rad, valid if limited
};

struct SkeletonJoint {
  std::string name;
  int parent = -1;                        ///< -1: a root; parents come first
  Vec3 offset;                            ///< m, from the parent joint at rest (roots: from the origin)
  std::vector<Vec3> end_sites;            ///< m, ends of the bones that start here and carry no joint, from this joint at rest
  std::vector<MeasuredFreedom> freedoms;  ///< rotation freedoms in the order of the file (outermost first); none: rigid
  bool translates = false;                ///< its translation is measured too
  std::string rotation_order = "ZXY";     ///< order of the rotation channels in the file, in the FILE's axes; for writing back
};

struct Skeleton {
  std::string name;
  std::vector<SkeletonJoint> joints;
  double unit = 1;  ///< m per length unit of the file
  double mass = 0;  ///< kg if the file tells, otherwise 0
};

/// A skeleton with its measured frames.
struct MeasuredMotion {
  std::string name;    ///< from the file's name
  std::string source;  ///< file name as read
  Skeleton skeleton;
  double rate = 120;  ///< frames a second
  int frames = 0;
  std::vector<Vec3> translations;  ///< [frames][joints] m, of the joint from its parent joint, in the parent's frame
  std::vector<Quat> rotations;     ///< [frames][joints] of the joint's frame in the parent's frame

  [[nodiscard]] int joint_count() const { return static_cast<int>(skeleton.joints.size()); }
  [[nodiscard]] double duration() const { return frames > 1 ? (frames - 1) / rate : 0; }
  /// World pose of every joint in a frame. @param X [joints, out]
  void calc_joint_poses(int frame, std::vector<Pose>& X) const;
};

/// World positions of all joints at rest, roots at their offset. [joints]
[[nodiscard]] std::vector<Vec3> rest_positions(const Skeleton& skeleton);

/// Height [m] of the standing person or animal whose skeleton this is, from the lowest to the highest joint or end site at rest.
[[nodiscard]] double rest_height(const Skeleton& skeleton);

}  // namespace ugoki
