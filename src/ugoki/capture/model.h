#pragma once
// A model skeleton of one subject: a marker set with its lengths and marker places fitted, and its kinematics. Internal to capture.

#include <span>
#include <vector>

#include "ugoki/capture/marker_set.h"

namespace ugoki::capture {

/// Positions of all joints in one frame.
struct ModelPose {
  Vec3 p;                       ///< m, of the root
  std::vector<Quat> rotations;  ///< [segments] of balls and the root, in the parent's frame
  std::vector<double> angles;   ///< [2 segments] rad, of hinges and universals
};

struct Subject {
  const MarkerSet* set = nullptr;
  double size = 1;                 ///< times the model's own size
  std::vector<Vec3> offsets;       ///< [segments] m
  std::vector<int> markers;        ///< [used] index into set->markers
  std::vector<int> columns;        ///< [used] index of the marker in the recording
  std::vector<Vec3> places;        ///< [used] m, in the segment's frame
  std::vector<int> first_freedom;  ///< [segments] index of the joint's first freedom
  int freedoms = 0;

  [[nodiscard]] const ModelSegment& segment(std::size_t i) const { return set->segments[i]; }
  [[nodiscard]] const ModelMarker& marker(std::size_t used) const { return set->markers[static_cast<std::size_t>(markers[used])]; }
  [[nodiscard]] std::size_t segment_count() const { return set->segments.size(); }
  [[nodiscard]] ModelPose rest() const;
};

/// The model at `size` times its own, with the labels of the recording attached.
[[nodiscard]] Subject make_subject(const MarkerSet& set, const std::vector<int>& match, double size);

/// World poses of all segments, and the world axes of all freedoms.
struct Kinematics {
  std::vector<Mat3> R;     ///< [segments]
  std::vector<Vec3> p;     ///< [segments] m
  std::vector<Vec3> axes;  ///< [freedoms] unit; the root's first three are translations along X, Y, Z
};
void calc_kinematics(const Subject& subject, const ModelPose& pose, Kinematics& k);

/// Rotation of segment i's joint in the parent's frame.
[[nodiscard]] Quat joint_rotation(const Subject& subject, const ModelPose& pose, std::size_t i);

/// Moves by `step` [freedoms] (m, rad about the freedoms' axes); angles stay within their limits.
void move(const Subject& subject, std::span<const double> step, ModelPose& pose);

/// Place of a used marker in the world.
[[nodiscard]] inline Vec3 marker_place(const Subject& subject, const Kinematics& k, std::size_t used) {
  const auto s = static_cast<std::size_t>(subject.marker(used).segment);
  return k.p[s] + k.R[s] * subject.places[used];
}

}  // namespace ugoki::capture
