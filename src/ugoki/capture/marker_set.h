#pragma once
// Marker sets: which labels sit where on which segment of a model skeleton.

#include <string>
#include <vector>

#include "ugoki/motion/markers.h"
#include "ugoki/spatial/spatial.h"

namespace ugoki::capture {

enum class ModelJoint : unsigned char { root, ball, hinge, universal, fixed };

/// A segment of the model and the joint where it starts. Rest: the person stands with the arms out to the sides, palms forward; an
/// animal stands. All frames are parallel to the world's: X forward, Y left, Z up. Lengths are those of the model's own size.
struct ModelSegment {
  std::string name;
  int parent = -1;
  Vec3 offset;        ///< m, from the parent's joint
  Vec3 offset_sigma;  ///< m, standard deviation over people (or animals) of this size; 0: known
  ModelJoint joint = ModelJoint::ball;
  Vec3 axis, second_axis;            ///< unit; hinge: the first, universal: both, the first one outermost
  double lower = 0, upper = 0;       ///< rad, limits of the first axis
  double lower2 = 0, upper2 = 0;     ///< rad, of the second
  double stiffness_sigma = 1e3;      ///< rad: how far from rest the joint usually is; spreads a bend over joints no marker tells apart
  int mirror = -1;                   ///< the same segment on the other side
  std::vector<Vec3> end_sites = {};  ///< m
};

struct ModelMarker {
  std::vector<std::string> labels;  ///< names in use for it, in capital letters
  int segment = 0;
  Vec3 at;           ///< m, in the segment's frame
  double sigma = 0;  ///< m, how exactly it is placed
  double noise = 1;  ///< how far skin moves it against the bone, times PoseOptions::marker_sigma
};

struct MarkerSet {
  std::string name;  ///< for people
  std::vector<ModelSegment> segments;
  std::vector<ModelMarker> markers;
};

/// Human body with the labels of Plug-in Gait, CMU and their kin.
[[nodiscard]] const MarkerSet& human_markers();
/// Four-legged animal with key points on its joints (Snout, SpineF, ShoulderL, HipR ...).
[[nodiscard]] const MarkerSet& quadruped_key_points();

/// Index into set.markers for each label of the recording; -1 where the set does not know it. Case, blanks, '_' and '-' do not count.
[[nodiscard]] std::vector<int> match_labels(const MarkerSet& set, const std::vector<std::string>& labels);

}  // namespace ugoki::capture
