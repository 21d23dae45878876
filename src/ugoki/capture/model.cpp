#include "ugoki/capture/model.h"

#include <algorithm>

namespace ugoki::capture {

ModelPose Subject::rest() const {
  ModelPose pose;
  pose.rotations.resize(segment_count());
  pose.angles.resize(2 * segment_count());
  return pose;
}

Subject make_subject(const MarkerSet& set, const std::vector<int>& match, double size) {
  Subject s;
  s.set = &set;
  s.size = size;
  for (const ModelSegment& segment : set.segments) {
    s.offsets.push_back(segment.offset * size);
    s.first_dof.push_back(s.dofs);
    switch (segment.joint) {
      case ModelJoint::root: s.dofs += 6; break;
      case ModelJoint::ball: s.dofs += 3; break;
      case ModelJoint::universal: s.dofs += 2; break;
      case ModelJoint::hinge: s.dofs += 1; break;
      case ModelJoint::fixed: break;
    }
  }
  for (std::size_t i = 0; i < match.size(); ++i) {
    if (match[i] < 0) continue;
    s.markers.push_back(match[i]);
    s.columns.push_back(static_cast<int>(i));
    s.marker_offsets.push_back(set.markers[static_cast<std::size_t>(match[i])].at * size);
  }
  return s;
}

Vec3 usual_place(const Subject& s, std::size_t used) {
  const ModelMarker& marker = s.marker(used);
  Vec3 place = marker.at * s.size;
  if (marker.end >= 0) {
    const auto end = static_cast<std::size_t>(marker.end);
    place += (s.offsets[end] - s.segment(end).offset * s.size) * marker.share;
  }
  return place;
}

Quat joint_rotation(const Subject& subject, const ModelPose& pose, std::size_t i) {
  const ModelSegment& s = subject.segment(i);
  switch (s.joint) {
    case ModelJoint::root:
    case ModelJoint::ball: return pose.rotations[i];
    case ModelJoint::hinge: return axis_angle(s.axis, pose.angles[2 * i]);
    case ModelJoint::universal: return axis_angle(s.axis, pose.angles[2 * i]) * axis_angle(s.second_axis, pose.angles[2 * i + 1]);
    case ModelJoint::fixed: break;
  }
  return {};
}

void calc_kinematics(const Subject& subject, const ModelPose& pose, Kinematics& k) {
  const std::size_t n = subject.segment_count();
  k.R.resize(n);
  k.p.resize(n);
  k.axes.resize(static_cast<std::size_t>(subject.dofs));
  for (std::size_t i = 0; i < n; ++i) {
    const ModelSegment& s = subject.segment(i);
    const Mat3 local = to_matrix(joint_rotation(subject, pose, i));
    const auto parent = static_cast<std::size_t>(s.parent);
    k.p[i] = s.parent < 0 ? pose.p : k.p[parent] + k.R[parent] * subject.offsets[i];
    k.R[i] = s.parent < 0 ? local : k.R[parent] * local;
    auto a = static_cast<std::size_t>(subject.first_dof[i]);
    if (s.joint == ModelJoint::root)
      for (int c = 0; c < 3; ++c) k.axes[a++] = Mat3::identity().column(c);
    if (s.joint == ModelJoint::root || s.joint == ModelJoint::ball)
      for (int c = 0; c < 3; ++c) k.axes[a++] = k.R[i].column(c);
    if (s.joint == ModelJoint::hinge || s.joint == ModelJoint::universal) k.axes[a++] = k.R[parent] * s.axis;
    if (s.joint == ModelJoint::universal) k.axes[a++] = k.R[i] * s.second_axis;
  }
}

void move(const Subject& subject, std::span<const double> step, ModelPose& pose) {
  for (std::size_t i = 0; i < subject.segment_count(); ++i) {
    const ModelSegment& s = subject.segment(i);
    const double* d = step.data() + subject.first_dof[i];
    if (s.joint == ModelJoint::root) {
      pose.p += Vec3{d[0], d[1], d[2]};
      d += 3;
    }
    if (s.joint == ModelJoint::root || s.joint == ModelJoint::ball)
      pose.rotations[i] = normalized(pose.rotations[i] * exp_map({d[0], d[1], d[2]}));
    if (s.joint == ModelJoint::hinge || s.joint == ModelJoint::universal)
      pose.angles[2 * i] = std::clamp(pose.angles[2 * i] + d[0], s.lower, s.upper);
    if (s.joint == ModelJoint::universal) pose.angles[2 * i + 1] = std::clamp(pose.angles[2 * i + 1] + d[1], s.lower2, s.upper2);
  }
}

}  // namespace ugoki::capture
