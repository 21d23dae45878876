#include "ugoki/intake/deform_bones.h"

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/intake/tree_edit.h"

namespace ugoki::intake {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

constexpr std::string_view deforms = "DEF-";

/// The name of the bone that a joint of the rig belongs to: without the prefix of its task.
std::string bone_of(const std::string& name) {
  for (const std::string_view prefix : {deforms, std::string_view("ORG-"), std::string_view("MCH-"), std::string_view("tweak_")})
    if (name.starts_with(prefix)) return name.substr(prefix.size());
  return name;
}

}  // namespace

bool consists_of_mechanisms(const Skeleton& s, const body::Character& c) {
  if (c.plan != body::BodyPlan::four_legs) return false;
  std::vector<int> joints = {c.pelvis, c.chest};
  for (const std::array<body::Limb, 2>* limbs : {&c.legs, &c.arms})
    for (const body::Limb& l : *limbs) joints.insert(joints.end(), {l.proximal, l.distal, l.end});
  return std::ranges::any_of(joints, [&](int i) { return i >= 0 && !s.joints[at(i)].name.starts_with(deforms); });
}

bool keep_deform_bones(std::span<MeasuredMotion> motions) {
  constexpr int fewest = 8;
  const Skeleton s = motions[0].skeleton;
  const int n = motions[0].joint_count();
  std::map<std::string, int> bones;
  for (int i = 0; i < n; ++i)
    if (s.joints[at(i)].name.starts_with(deforms)) bones.emplace(bone_of(s.joints[at(i)].name), i);
  if (static_cast<int>(bones.size()) < fewest || static_cast<int>(bones.size()) == n) return false;
  std::vector<int> parents(at(n), -1);
  const auto is_below_now = [&](int i, int ancestor) {
    for (; i >= 0; i = parents[at(i)])
      if (i == ancestor) return true;
    return false;
  };
  // Bones that hang on bones first: controls of a tail can have the opposite order of its bones.
  for (const bool direct : {true, false})
    for (const auto& [bone, i] : bones)
      for (int a = s.joints[at(i)].parent; a >= 0 && parents[at(i)] < 0; a = s.joints[at(a)].parent) {
        if (direct && !s.joints[at(a)].name.starts_with(deforms)) break;
        if (const auto found = bones.find(bone_of(s.joints[at(a)].name)); found != bones.end() && !is_below_now(found->second, i))
          parents[at(i)] = found->second;
      }
  const auto top_of = [&](int i) {
    while (parents[at(i)] >= 0) i = parents[at(i)];
    return i;
  };
  std::map<int, int> sizes;  // number of bones below each bone without a parent
  for (const auto& [bone, i] : bones) ++sizes[top_of(i)];
  const int largest = std::ranges::max_element(sizes, {}, [](const auto& entry) { return entry.second; })->first;
  std::vector<char> keep(at(n), 0);
  for (const auto& [bone, i] : bones) keep[at(i)] = top_of(i) == largest ? 1 : 0;
  for (MeasuredMotion& m : motions) {
    const auto world = world_of(m);
    const std::vector<Vec3> rest = rest_positions(m.skeleton);
    std::vector<int> order, place(at(n), -1);  // parents first
    const auto add = [&](auto&& self, int i) -> void {
      if (place[at(i)] >= 0) return;
      if (parents[at(i)] >= 0) self(self, parents[at(i)]);
      place[at(i)] = static_cast<int>(order.size());
      order.push_back(i);
    };
    for (int i = 0; i < n; ++i)
      if (keep[at(i)] != 0) add(add, i);
    std::vector<SkeletonJoint> joints;
    for (const int i : order) {
      SkeletonJoint j = m.skeleton.joints[at(i)];
      const int parent = parents[at(i)];
      j.parent = parent < 0 ? -1 : place[at(parent)];
      j.offset = rest[at(i)] - (parent < 0 ? Vec3{} : rest[at(parent)]);
      j.translates = true;
      joints.push_back(std::move(j));
    }
    std::vector<std::vector<Pose>> kept;
    for (const auto& X : world) {
      kept.emplace_back();
      for (const int i : order) kept.back().push_back(X[at(i)]);
    }
    m.skeleton.joints = std::move(joints);
    set_world(m, kept);
  }
  return true;
}

}  // namespace ugoki::intake
