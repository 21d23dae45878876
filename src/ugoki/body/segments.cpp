#include "ugoki/body/segments.h"

namespace ugoki::body {
namespace {

// m, mean heights of the subjects; the published lengths are divided by them.
constexpr double male_height = 1.741, female_height = 1.735;

constexpr SegmentTable male = {
    .head = {0.0694, 0.5002, 0.303, 0.315, 0.261, 0.2429 / male_height},
    .upper_trunk = {0.1596, 0.5066, 0.505, 0.320, 0.465, 0.2421 / male_height},
    .middle_trunk = {0.1633, 0.4502, 0.482, 0.383, 0.468, 0.2155 / male_height},
    .lower_trunk = {0.1117, 0.6115, 0.615, 0.551, 0.587, 0.1457 / male_height},
    .upper_arm = {0.0271, 0.5772, 0.285, 0.269, 0.158, 0.2817 / male_height},
    .forearm = {0.0162, 0.4574, 0.276, 0.265, 0.121, 0.2689 / male_height},
    .hand = {0.0061, 0.7900, 0.628, 0.513, 0.401, 0.0862 / male_height},
    .thigh = {0.1416, 0.4095, 0.329, 0.329, 0.149, 0.4222 / male_height},
    .shank = {0.0433, 0.4395, 0.251, 0.246, 0.102, 0.4340 / male_height},
    .foot = {0.0137, 0.4415, 0.257, 0.245, 0.124, 0.2581 / male_height},
};
constexpr SegmentTable female = {
    .head = {0.0668, 0.4841, 0.271, 0.295, 0.261, 0.2437 / female_height},
    .upper_trunk = {0.1545, 0.5050, 0.466, 0.314, 0.449, 0.2280 / female_height},
    .middle_trunk = {0.1465, 0.4512, 0.433, 0.354, 0.415, 0.2053 / female_height},
    .lower_trunk = {0.1247, 0.4920, 0.433, 0.402, 0.444, 0.1815 / female_height},
    .upper_arm = {0.0255, 0.5754, 0.278, 0.260, 0.148, 0.2751 / female_height},
    .forearm = {0.0138, 0.4559, 0.261, 0.257, 0.094, 0.2643 / female_height},
    .hand = {0.0056, 0.7474, 0.531, 0.454, 0.335, 0.0780 / female_height},
    .thigh = {0.1478, 0.3612, 0.369, 0.364, 0.162, 0.3685 / female_height},
    .shank = {0.0481, 0.4352, 0.267, 0.263, 0.092, 0.4323 / female_height},
    .foot = {0.0129, 0.4014, 0.299, 0.279, 0.139, 0.2283 / female_height},
};

Segment average(const Segment& a, const Segment& b) {
  return {0.5 * (a.mass + b.mass),
          0.5 * (a.centre + b.centre),
          0.5 * (a.sagittal + b.sagittal),
          0.5 * (a.transverse + b.transverse),
          0.5 * (a.longitudinal + b.longitudinal),
          0.5 * (a.length + b.length)};
}

}  // namespace

SegmentTable segment_table(Sex sex) {
  if (sex == Sex::male) return male;
  if (sex == Sex::female) return female;
  return {average(male.head, female.head),
          average(male.upper_trunk, female.upper_trunk),
          average(male.middle_trunk, female.middle_trunk),
          average(male.lower_trunk, female.lower_trunk),
          average(male.upper_arm, female.upper_arm),
          average(male.forearm, female.forearm),
          average(male.hand, female.hand),
          average(male.thigh, female.thigh),
          average(male.shank, female.shank),
          average(male.foot, female.foot)};
}

}  // namespace ugoki::body
