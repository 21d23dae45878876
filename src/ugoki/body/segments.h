#pragma once
// Segment parameters of the human body as numbers.
// Source: P. de Leva, "Adjustments to Zatsiorsky-Seluyanov's segment inertia parameters", J. Biomechanics 29 (1996)
// 1223-1230, tables 1 and 4: 100 men (mean 1.741 m, 73.0 kg) and 15 women (1.735 m, 61.9 kg).

#include "ugoki/body/body.h"

namespace ugoki::body {

/// One segment. Lengths are between the paper's end points: thigh hip-knee, shank knee-ankle, foot heel-toe tip,
/// upper arm shoulder-elbow, forearm elbow-wrist, hand wrist-third knuckle, head vertex-cervicale, trunk parts
/// cervicale-xiphion, xiphion-omphalion, omphalion-mid-hip.
struct Segment {
  double mass;        ///< share of the body's mass
  double centre;      ///< centre of mass from the first end point, in lengths
  double sagittal;    ///< radius of gyration about the front-to-back axis through the centre, in lengths
  double transverse;  ///< about the side-to-side axis
  double longitudinal;
  double length;  ///< share of the body's height
};

struct SegmentTable {
  Segment head, upper_trunk, middle_trunk, lower_trunk, upper_arm, forearm, hand, thigh, shank, foot;
};

/// The table for one sex, or the average of both. The masses (limbs counted twice) sum to 1.
[[nodiscard]] SegmentTable segment_table(Sex sex);

}  // namespace ugoki::body
