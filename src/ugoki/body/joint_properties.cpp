// Ranges of motion, passive resistance and strength of human joints. docs/design/body.md lists the sources and their accuracy.

#include <algorithm>

#include "ugoki/body/joints.h"

namespace ugoki::body {
namespace {

constexpr double degree = pi / 180;
std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Passive properties of one joint for a body of 70 kg.
struct Passive {
  double damping;    ///< N m s/rad
  double stiffness;  ///< N m/rad
  double effort;     ///< N m, maximum torque of the muscles
  double armature;   ///< kg m^2, added inertia that keeps light links well conditioned
};

Passive passive_of(Part part) {
  switch (part) {
    case Part::pelvis:
    case Part::trunk: return {6, 120, 400, 0};
    case Part::neck:
    case Part::head: return {0.8, 8, 80, 0};
    case Part::hip:
    case Part::thigh: return {3, 4, 350, 0};
    case Part::shank: return {1.5, 2, 320, 0};
    case Part::foot: return {1.0, 5, 280, 0.002};
    case Part::toes: return {0.3, 8, 80, 0.002};
    case Part::shoulder: return {2, 40, 150, 0.002};
    case Part::upper_arm: return {1.2, 1.5, 150, 0};
    case Part::forearm: return {0.5, 0.5, 110, 0.0005};
    case Part::hand: return {0.1, 0.6, 30, 0.0005};
    case Part::fingers: return {0.03, 0.3, 10, 0.0005};
    case Part::thumb: return {0.03, 0.3, 10, 0.0005};
    case Part::other: return {1, 0, 400, 0};
  }
  return {1, 0, 400, 0};
}

/// Range of motion of a joint.
struct Range {
  Vec3 lower, upper;  ///< degrees, rotation vector in anatomical axes (x forward, y left, z up), left side
};

/// Range of motion relative to the rest posture: legs and trunk upright, arms stretched out sideways.
/// @param open degrees by which the thigh is abducted, or the upper arm lowered, in the skeleton's rest posture
Range range_of(Part part, double open) {
  switch (part) {
    case Part::trunk: return {{-30, -20, -30}, {30, 45, 30}};
    case Part::neck:
    case Part::head: return {{-35, -35, -45}, {35, 45, 45}};
    case Part::thigh: return {{-30 - open, -125, -45}, {50 - open, 30, 45}};
    case Part::shank: return {{-8, -5, -15}, {8, 150, 15}};
    case Part::foot: return {{-30, -30, -30}, {30, 50, 30}};
    case Part::toes: return {{-10, -60, -10}, {10, 40, 10}};
    case Part::shoulder: return {{-15, -20, -25}, {40, 20, 25}};
    case Part::upper_arm: return {{-100 + open, -120, -135}, {90 + open, 120, 50}};
    case Part::forearm: return {{-150, -150, -150}, {150, 150, 150}};
    case Part::hand: return {{-80, -80, -80}, {80, 80, 80}};
    case Part::fingers: return {{-100, -100, -100}, {100, 100, 100}};
    case Part::thumb: return {{-70, -70, -70}, {70, 70, 70}};
    default: return {{-90, -90, -90}, {90, 90, 90}};
  }
}

}  // namespace

void set_joint_properties(Joint& joint, const Anatomy& anatomy, const SkeletonJoint& source, int i, double mass) {
  const SidedPart sided = anatomy.parts[at(i)];
  const Passive passive = passive_of(sided.part);
  const double strength = mass / 70;
  const int nv = joint.nv();
  if (joint.type == JointType::floating) return;
  for (int k = 0; k < nv; ++k) {
    Dof& f = joint.dofs[at(k)];
    f.damping = passive.damping * strength;
    f.stiffness = passive.stiffness * strength;
    f.effort = passive.effort * strength;
    f.armature = passive.armature;
  }
  const bool own_dofs = static_cast<int>(source.dofs.size()) == nv && joint.type != JointType::spherical;
  bool from_file = own_dofs && nv > 0;
  for (const MeasuredDof& f : source.dofs) from_file = from_file && f.limited;
  if (from_file) {
    for (int k = 0; k < nv; ++k) {
      joint.dofs[at(k)].lower = source.dofs[at(k)].lower;
      joint.dofs[at(k)].upper = source.dofs[at(k)].upper;
    }
    return;
  }
  if (sided.part == Part::other) return;  // no human range is known for other parts

  double open = 0;
  const Vec3 bone = anatomy.symmetric_bone(i);
  const double outward = std::fabs(bone.y);
  if (sided.part == Part::thigh) open = atan2(outward, -bone.z) / degree;
  if (sided.part == Part::upper_arm) open = atan2(-bone.z, outward) / degree;
  const Range range = range_of(sided.part, open);
  // The mirror image of a rotation vector (x, y, z) about the middle plane is (-x, y, -z).
  Vec3 lower = range.lower * degree, upper = range.upper * degree;
  if (sided.side < 0) {
    lower = {-range.upper.x * degree, lower.y, -range.upper.z * degree};
    upper = {-range.lower.x * degree, upper.y, -range.lower.z * degree};
  }
  if (joint.type == JointType::spherical) {
    // Bounding box, in the link's axes, of the range in anatomical axes. Both axes differ only if the character does not face x at rest.
    for (int k = 0; k < 3; ++k) {
      Vec3 a = transpose_times(anatomy.R_WA, Vec3{k == 0 ? 1.0 : 0.0, k == 1 ? 1.0 : 0.0, k == 2 ? 1.0 : 0.0});
      double low = 0, high = 0;
      for (int c = 0; c < 3; ++c) {
        low += a[c] > 0 ? a[c] * lower[c] : a[c] * upper[c];
        high += a[c] > 0 ? a[c] * upper[c] : a[c] * lower[c];
      }
      joint.dofs[at(k)].lower = low;
      joint.dofs[at(k)].upper = high;
    }
    return;
  }
  if (sided.part == Part::forearm && nv == 1) {  // fit_hinge signs the axis so that an elbow flexes in the positive sense
    joint.dofs[0].lower = -10 * degree;
    joint.dofs[0].upper = 150 * degree;
    return;
  }
  for (int k = 0; k < nv; ++k) {
    // The ranges about the three anatomical axes form a box. The range of this joint is the part of its axis inside the box.
    const Vec3 axis = transpose_times(anatomy.R_WA, k == 0 ? joint.axis : joint.axis2);
    double low = 1e9, high = 1e9;
    for (int c = 0; c < 3; ++c) {
      if (std::fabs(axis[c]) < 0.5) continue;  // small components (an abducted shank at rest) must not narrow the main range
      low = std::min(low, axis[c] > 0 ? -lower[c] / axis[c] : upper[c] / -axis[c]);
      high = std::min(high, axis[c] > 0 ? upper[c] / axis[c] : -lower[c] / -axis[c]);
    }
    joint.dofs[at(k)].lower = -low;
    joint.dofs[at(k)].upper = high;
  }
}

}  // namespace ugoki::body
