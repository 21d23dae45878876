#pragma once
// Changes of the joint tree of a motion that keep the world poses of its joints. Internal to intake.

#include <span>
#include <string>
#include <vector>

#include "ugoki/motion/skeleton.h"

namespace ugoki::intake {

[[nodiscard]] bool is_below(const Skeleton& s, int i, int ancestor);

/// Poses of all joints in the world: [frames][joints].
[[nodiscard]] std::vector<std::vector<Pose>> world_of(const MeasuredMotion& motion);

/// Sets the local poses of all frames from world poses. @param world [frames][joints]
void set_world(MeasuredMotion& m, const std::vector<std::vector<Pose>>& world);

/// Poses of all joints in up to about 120 frames of the motions.
[[nodiscard]] std::vector<std::vector<Pose>> sample_poses(std::span<const MeasuredMotion> motions);

/// Diagonal [m] of the box around all joints.
[[nodiscard]] double extent_of(const std::vector<Pose>& X);

/// Diagonal [m] of the box around the joints of all trees with more than one joint. Cameras and lights beside a character, which are single
/// joints, can be far away. If there are only single joints, the box is around all of them.
[[nodiscard]] double extent_of_trees(const Skeleton& s, const std::vector<Pose>& X);

/// Distances [m] of joint i from its usual place relative to joint a, sorted. The usual place is the median of each coordinate.
[[nodiscard]] std::vector<double> deviations(const std::vector<std::vector<Pose>>& samples, std::size_t i, std::size_t a);

/// Value below which the given share of the sorted values is.
[[nodiscard]] double quantile(const std::vector<double>& sorted, double share);

/// Gives joints a new parent, where new_parent[joint] is not -1. World poses do not change. All parents change at once, because poses can
/// be computed only while parents precede their children. The joints are sorted so that they do.
void reparent(std::span<MeasuredMotion> motions, std::span<const int> new_parent);

/// Appends a joint that does not turn relative to its parent.
void append_rigid(MeasuredMotion& m, const std::string& name, int parent, const Vec3& offset, std::vector<Vec3> end_sites);

}  // namespace ugoki::intake
