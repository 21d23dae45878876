#pragma once
// Marker sets: labels of markers, and their positions on the segments of a model skeleton.

#include <string>
#include <vector>

#include "ugoki/motion/markers.h"
#include "ugoki/spatial/spatial.h"

namespace ugoki::capture {

enum class ModelJoint : unsigned char { root, ball, hinge, universal, fixed };

/// A segment of the model and the joint at its start. Rest posture: a person stands with arms sideways and palms forward; an animal stands.
/// At rest all segment frames are parallel to the world: X forward, Y left, Z up. Lengths are those of the model, not of a subject.
struct ModelSegment {
  std::string name;
  int parent = -1;    ///< index in MarkerSet::segments; -1: root
  Vec3 offset;        ///< m, position of the segment's joint relative to the parent's joint, in the parent's frame
  Vec3 offset_sigma;  ///< m, standard deviation over people (or animals) of this size; 0: the offset is exact
  ModelJoint joint = ModelJoint::ball;
  Vec3 axis, second_axis;            ///< unit; hinge: axis; universal: axis (outer) and second_axis (inner)
  double lower = 0, upper = 0;       ///< rad, limits of the first axis
  double lower2 = 0, upper2 = 0;     ///< rad, limits of the second axis
  double stiffness_sigma = 1e3;      ///< rad, standard deviation from rest; divides a rotation among joints that markers cannot distinguish
  int mirror = -1;                   ///< index of the segment on the other side of the body; -1: none
  std::vector<Vec3> end_sites = {};  ///< m, in the segment's frame
};

/// A marker of a marker set.
struct ModelMarker {
  std::vector<std::string> labels;  ///< labels in use, in capital letters; the first one is the most common
  int segment = 0;                  ///< index in MarkerSet::segments
  Vec3 at;                          ///< m, position in the segment's frame
  double sigma = 0;                 ///< m, standard deviation of the position on the body
  double noise = 1;                 ///< factor on PoseOptions::marker_sigma, for the motion of the skin relative to the bone
  int end = -1;                     ///< index of the segment at the far end of the marker's segment; -1: none
  double share = 0;                 ///< 0 to 1: share of a change of the end segment's offset by which the marker moves (1: beside that joint)
};

/// A model skeleton with its markers.
struct MarkerSet {
  std::string name;  ///< for display
  std::vector<ModelSegment> segments;
  std::vector<ModelMarker> markers;
};

/// Human body with markers on the skin: labels of Plug-in Gait, CGM2, Helen Hayes, IOR, CAST, OpenSim, CMU, OptiTrack Baseline.
[[nodiscard]] const MarkerSet& human_markers();
/// Human body with key points at the joint centres: labels of COCO, OpenPose, HALPE and similar sets.
[[nodiscard]] const MarkerSet& human_key_points();
/// Four-legged animal with key points on its joints (Snout, SpineF, ShoulderL, HipR ...).
[[nodiscard]] const MarkerSet& quadruped_key_points();

/// Returns the index into set.markers for each label of the recording; -1: not in the set. Case, blanks, '_', '-', '.', a prefix before ':'
/// and a prefix that all labels share are ignored. "Left" and "right" may be written out, at the beginning or the end ("left_knee", "Knee
/// Left", "knee.L").
[[nodiscard]] std::vector<int> match_labels(const MarkerSet& set, const std::vector<std::string>& labels);

}  // namespace ugoki::capture
