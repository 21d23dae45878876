#pragma once
// Model skeleton of one subject (a marker set with calibrated lengths and marker offsets) and its kinematics. Internal to capture.

#include <span>
#include <vector>

#include "ugoki/capture/marker_set.h"

namespace ugoki::capture {

/// Joint coordinates of a subject in one frame.
struct ModelPose {
  Vec3 p;                       ///< m, position of the root
  std::vector<Quat> rotations;  ///< [segments] rotation in the parent's frame; used for ball joints and the root
  std::vector<double> angles;   ///< [2 * segments] rad; hinge i: angles[2 i]; universal joint i: angles[2 i], angles[2 i + 1]
};

/// A marker set calibrated to one subject.
struct Subject {
  const MarkerSet* set = nullptr;    ///< not owned
  double size = 1;                   ///< size relative to the model
  std::vector<Vec3> offsets;         ///< [segments] m, position of the joint relative to the parent's joint, in the parent's frame
  std::vector<int> markers;          ///< [used markers] index into set->markers
  std::vector<int> columns;          ///< [used markers] index of the marker in the recording
  std::vector<Vec3> marker_offsets;  ///< [used markers] m, position in the segment's frame
  std::vector<int> first_dof;        ///< [segments] index of the joint's first DOF among all DOFs
  int dofs = 0;                      ///< total number of DOFs

  [[nodiscard]] const ModelSegment& segment(std::size_t i) const { return set->segments[i]; }
  [[nodiscard]] const ModelMarker& marker(std::size_t used) const { return set->markers[static_cast<std::size_t>(markers[used])]; }
  [[nodiscard]] std::size_t segment_count() const { return set->segments.size(); }
  /// Returns the pose with all joints at rest and the root at the origin.
  [[nodiscard]] ModelPose rest() const;
};

/// Returns a subject of the given relative size before calibration. @param match result of match_labels @param set must outlive the subject
[[nodiscard]] Subject make_subject(const MarkerSet& set, const std::vector<int>& match, double size);

/// Usual position [m] of a used marker in its segment's frame. Markers near the far end of a segment follow the segment's length.
[[nodiscard]] Vec3 usual_place(const Subject& subject, std::size_t used);

/// World poses of all segments, and the world axes of all DOFs.
struct Kinematics {
  std::vector<Mat3> R;     ///< [segments] orientation
  std::vector<Vec3> p;     ///< [segments] m, position of the joint
  std::vector<Vec3> axes;  ///< [DOFs] unit vectors; the root's first three are translations along X, Y, Z
};
/// Computes `k` for a pose. O(segments).
void calc_kinematics(const Subject& subject, const ModelPose& pose, Kinematics& k);

/// Rotation of segment i's joint in the parent's frame.
[[nodiscard]] Quat joint_rotation(const Subject& subject, const ModelPose& pose, std::size_t i);

/// Adds `step` [DOFs] (m along or rad about the DOFs' axes) to the pose; angles are clamped to their limits.
void move(const Subject& subject, std::span<const double> step, ModelPose& pose);

/// World position [m] of a used marker. @param used index in Subject::markers
[[nodiscard]] inline Vec3 marker_position(const Subject& subject, const Kinematics& k, std::size_t used) {
  const auto s = static_cast<std::size_t>(subject.marker(used).segment);
  return k.p[s] + k.R[s] * subject.marker_offsets[used];
}

}  // namespace ugoki::capture
