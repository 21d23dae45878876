#pragma once
// Segment parameters of the human body: mass, centre of mass, radii of gyration, length.
// Source: P. de Leva, "Adjustments to Zatsiorsky-Seluyanov's segment inertia parameters", J. Biomechanics 29 (1996)
// 1223-1230, tables 1 and 4: 100 men (mean 1.741 m, 73.0 kg) and 15 women (1.735 m, 61.9 kg).

#include "ugoki/body/body.h"

namespace ugoki::body {

/// One segment. Lengths are between the end points of the publication: thigh hip-knee, shank knee-ankle, foot heel-toe tip,
/// upper arm shoulder-elbow, forearm elbow-wrist, hand wrist-third knuckle, head vertex-cervicale, trunk parts
/// cervicale-xiphion, xiphion-omphalion, omphalion-mid-hip.
struct Segment {
  double mass;          ///< share of the body's mass, one side
  double centre;        ///< distance of the centre of mass from the first end point, share of the length
  double sagittal;      ///< radius of gyration about the front-to-back axis through the centre of mass, share of the length
  double transverse;    ///< radius of gyration about the side-to-side axis through the centre of mass, share of the length
  double longitudinal;  ///< radius of gyration about the long axis, share of the length
  double length;        ///< share of the body's height
};

/// Parameters of all segments.
struct SegmentTable {
  Segment head, upper_trunk, middle_trunk, lower_trunk, upper_arm, forearm, hand, thigh, shank, foot;
};

/// Table for one sex, or the average of both sexes. The masses (limbs counted twice) sum to 1 within 0.002.
[[nodiscard]] SegmentTable segment_table(Sex sex);

}  // namespace ugoki::body
