#include "ugoki/intake/paw_ends.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "ugoki/intake/tree_edit.h"

namespace ugoki::intake {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Last joint of a limb. A limb without an end section ends at the last joint of the chain below its lower section.
int last_of(const Skeleton& s, const body::Limb& limb) {
  if (limb.tip >= 0 || limb.end >= 0) return limb.tip >= 0 ? limb.tip : limb.end;
  int last = limb.distal;
  const auto child_of = [&](int i) {
    const auto is_child = [&](const SkeletonJoint& j) { return j.parent == i; };
    const auto found = std::ranges::find_if(s.joints, is_child);
    return std::ranges::count_if(s.joints, is_child) == 1 ? static_cast<int>(found - s.joints.begin()) : -1;
  };
  for (int child = last; child >= 0; child = child_of(child)) last = child;
  return last;
}

/// Gives the ends of an animal's limbs, where they have no end sites, those of the joints of the same name in `with_ends`, if left and
/// right are alike within 15 %. Meshes of heads reach to the ends of antlers and ears, which are no ends of bones. @return true if any
/// joint got ends
bool restore_ends(std::span<MeasuredMotion> motions, const Skeleton& with_ends, const body::Character& character) {
  const auto ends_of = [&](int joint) {
    const SkeletonJoint* found = nullptr;
    for (const SkeletonJoint& j : with_ends.joints) {
      if (joint < 0 || j.name != motions[0].skeleton.joints[at(joint)].name) continue;
      if (found) return std::vector<Vec3>{};  // another joint has the same name
      found = &j;
    }
    return found && motions[0].skeleton.joints[at(joint)].end_sites.empty() ? found->end_sites : std::vector<Vec3>{};
  };
  bool any = false;
  for (const auto* limbs : {&character.legs, &character.arms}) {
    std::array<int, 2> joint{};
    std::array<std::vector<Vec3>, 2> ends;
    for (std::size_t k = 0; k < 2; ++k) {
      joint[k] = last_of(motions[0].skeleton, (*limbs)[k]);
      ends[k] = ends_of(joint[k]);
    }
    if (ends[0].size() != 1 || ends[1].size() != 1) continue;
    const double left = norm(ends[0][0]), right = norm(ends[1][0]);
    if (std::fabs(left - right) > 0.15 * std::max(left, right)) continue;
    any = true;
    for (MeasuredMotion& m : motions)
      for (std::size_t k = 0; k < 2; ++k) m.skeleton.joints[at(joint[k])].end_sites = ends[k];
  }
  return any;
}

/// The end of joint `joint` in `with_ends`; std::nullopt if the joint has an end or a child, if there is no joint of its name or several,
/// or if the end is far away.
std::optional<Vec3> end_of(const Skeleton& s, int joint, const Skeleton& with_ends, double trunk_length) {
  constexpr double longest = 0.75;  // trunk lengths
  if (joint < 0 || !s.joints[at(joint)].end_sites.empty()) return std::nullopt;
  if (std::ranges::any_of(s.joints, [&](const SkeletonJoint& j) { return j.parent == joint; })) return std::nullopt;
  const auto is_it = [&](const SkeletonJoint& j) { return j.name == s.joints[at(joint)].name; };
  const auto found = std::ranges::find_if(with_ends.joints, is_it);
  if (found == with_ends.joints.end() || found->end_sites.size() != 1 || std::ranges::count_if(with_ends.joints, is_it) != 1)
    return std::nullopt;
  return norm(found->end_sites[0]) <= longest * trunk_length ? std::optional(found->end_sites[0]) : std::nullopt;
}

/// Gives the last joint of the tail the end of its mesh, and the head, if its end is usually in front of the head's joint and not far above
/// it: a muzzle. Meshes of heads can also reach farthest to the ends of antlers and ears, which are no ends of bones.
/// @return true if a joint got an end
bool restore_head_and_tail(std::span<MeasuredMotion> motions, const Skeleton& with_ends, const body::Character& character) {
  constexpr double steepest = 0.5;  // sine of the elevation
  const auto set_end = [&](int joint, const Vec3& end) {
    for (MeasuredMotion& m : motions) m.skeleton.joints[at(joint)].end_sites = {end};
  };
  const int last = character.tail.empty() ? -1 : character.tail.back();
  const std::optional<Vec3> tail = end_of(motions[0].skeleton, last, with_ends, character.trunk_length);
  if (tail) set_end(last, *tail);
  const std::optional<Vec3> end = end_of(motions[0].skeleton, character.head, with_ends, character.trunk_length);
  if (!end) return tail.has_value();
  std::vector<double> rises, fronts;
  for (const auto& X : sample_poses(motions)) {
    const auto middle = [&](const std::array<body::Limb, 2>& l) { return (X[at(l[0].proximal)].p + X[at(l[1].proximal)].p) * 0.5; };
    const Vec3 direction = normalized(X[at(character.head)].R * *end), forward = middle(character.arms) - middle(character.legs);
    rises.push_back(direction.z);
    fronts.push_back(direction.x * forward.x + direction.y * forward.y);
  }
  std::ranges::sort(rises);
  std::ranges::sort(fronts);
  const bool muzzle = !rises.empty() && quantile(rises, 0.5) <= steepest && quantile(fronts, 0.5) > 0;
  if (muzzle) set_end(character.head, *end);
  return muzzle || tail.has_value();
}

/// Usual difference [m] between the heights of the lower fore paw and the lower hind paw, with their end sites.
double height_between_paws(std::span<const MeasuredMotion> motions, const body::Character& character) {
  std::vector<double> heights;
  for (const auto& X : sample_poses(motions)) {
    const auto lowest = [&](const auto& limbs) {
      double low = 1e300;
      for (const body::Limb& limb : limbs) {
        const std::size_t joint = at(last_of(motions[0].skeleton, limb));
        low = std::min(low, X[joint].p.z);
        for (const Vec3& end : motions[0].skeleton.joints[joint].end_sites) low = std::min(low, (X[joint] * end).z);
      }
      return low;
    };
    heights.push_back(std::fabs(lowest(character.arms) - lowest(character.legs)));
  }
  std::ranges::sort(heights);
  return heights.empty() ? 0 : quantile(heights, 0.5);
}

}  // namespace

bool restore_ends_of_meshes(std::span<MeasuredMotion> motions, const Skeleton& with_ends, const body::Character& character) {
  constexpr double level = 0.1;  // share of the length of a leg
  const double before = height_between_paws(motions, character);
  std::vector<MeasuredMotion> with_paws(motions.begin(), motions.end());
  const bool paws =
      restore_ends(with_paws, with_ends, character) && height_between_paws(with_paws, character) <= before + level * character.leg_length;
  if (paws) std::ranges::move(with_paws, motions.begin());
  return restore_head_and_tail(motions, with_ends, character) || paws;
}

}  // namespace ugoki::intake
