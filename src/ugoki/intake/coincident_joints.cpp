#include "ugoki/intake/coincident_joints.h"

#include <algorithm>

#include "ugoki/intake/arrange.h"
#include "ugoki/intake/tree_edit.h"

namespace ugoki::intake {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Joints of the character that stay whatever their place is: [joints].
std::vector<char> needed(const body::Character& character, std::size_t joints) {
  std::vector<char> out(joints, 0);
  const auto keep = [&](int i) {
    if (i >= 0) out[at(i)] = 1;
  };
  keep(0);
  keep(character.pelvis);
  keep(character.head);
  for (const auto* limbs : {&character.legs, &character.arms})
    for (const body::Limb& limb : *limbs)
      for (const int i : {limb.proximal, limb.distal, limb.end}) keep(i);
  return out;
}

/// True if the joint turns relative to its parent. Rounding errors of the file count too: a body has a degree of freedom for every joint that
/// turns at all.
bool turns(std::span<const MeasuredMotion> motions, std::size_t i) {
  constexpr double turned = 1e-9;  // rad
  const Quat first = motions[0].rotations[i].conjugate();
  for (const MeasuredMotion& m : motions)
    for (std::size_t f = 0; f < at(m.frames); ++f)
      if (2 * norm((first * m.rotations[f * m.skeleton.joints.size() + i]).vec()) > turned) return true;
  return false;
}

/// True if the joint has the same place as its parent in all frames.
bool at_parent(std::span<const MeasuredMotion> motions, std::size_t i, double near) {
  if (norm(motions[0].skeleton.joints[i].offset) > near) return false;
  for (const MeasuredMotion& m : motions)
    for (std::size_t f = 0; f < at(m.frames); ++f)
      if (norm(m.translations[f * m.skeleton.joints.size() + i]) > near) return false;
  return true;
}

/// Removes joints. Joints whose parent was removed stay at a fixed place relative to their new parent.
void remove(std::span<MeasuredMotion> motions, std::span<const char> keep) {
  std::vector<char> translates;
  for (std::size_t i = 0; i < keep.size(); ++i)
    if (keep[i] != 0) translates.push_back(motions[0].skeleton.joints[i].translates ? 1 : 0);
  for (MeasuredMotion& m : motions) {
    keep_joints(m, keep);
    const std::size_t n = m.skeleton.joints.size();
    for (std::size_t i = 0; i < n; ++i) {
      SkeletonJoint& joint = m.skeleton.joints[i];
      if (joint.translates == (translates[i] != 0)) continue;
      joint.translates = translates[i] != 0;
      for (std::size_t f = 0; f < at(m.frames); ++f) m.translations[f * n + i] = joint.offset;
    }
  }
}

}  // namespace

CoincidentJoints merge_coincident_joints(std::span<MeasuredMotion> motions, const body::Character& character) {
  CoincidentJoints out;
  const Skeleton& s = motions[0].skeleton;
  const std::size_t n = s.joints.size();
  const std::vector<std::vector<Pose>> samples = sample_poses(motions);
  if (samples.empty()) return out;
  const double near = 0.002 * extent_of(samples[0]);
  const std::vector<char> fixed = needed(character, n);
  std::vector<char> keep(n, 1);
  std::vector<int> children(n, 0), child(n, -1);  // of joints that stay; the last child
  std::vector<char> child_is_near(n, 0);          // the last child is at the place of the joint
  for (std::size_t i = n; i-- > 1;) {             // children before their parents
    const SkeletonJoint& joint = s.joints[i];
    if (joint.parent < 0) continue;
    const bool has_bone = std::ranges::any_of(joint.end_sites, [&](const Vec3& end) { return norm(end) > near; });
    const bool is_near = at_parent(motions, i, near);
    const bool useless = fixed[i] == 0 && !has_bone && turns(motions, i);
    if (useless && children[i] == 0 && is_near) {
      keep[i] = 0;
      out.points.push_back(joint.name);
      continue;
    }
    const bool carrier = useless && children[i] == 1 && child_is_near[i] != 0 && turns(motions, at(child[i]));
    if (carrier) {
      keep[i] = 0;
      out.carriers.push_back(joint.name);
    }
    ++children[at(joint.parent)];
    child[at(joint.parent)] = carrier ? child[i] : static_cast<int>(i);
    child_is_near[at(joint.parent)] = is_near ? 1 : 0;
  }
  if (!out.empty()) remove(motions, keep);
  return out;
}

}  // namespace ugoki::intake
