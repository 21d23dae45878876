#include "ugoki/intake/limb_ends.h"

#include <algorithm>
#include <iterator>

#include "ugoki/body/joint_names.h"
#include "ugoki/body/limb_geometry.h"
#include "ugoki/intake/tree_edit.h"

namespace ugoki::intake {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

std::vector<body::NameEvidence> evidence_of(const Skeleton& s) {
  std::vector<std::string> names;
  for (const SkeletonJoint& j : s.joints) names.push_back(j.name);
  return body::read_joint_names(names);
}

std::vector<int> child_counts(const Skeleton& s) {
  std::vector<int> count(s.joints.size(), 0);
  for (const SkeletonJoint& j : s.joints)
    if (j.parent >= 0) ++count[at(j.parent)];
  return count;
}

/// True if a point reaches far below all joints of the character in most frames, so that no foot ends there.
bool is_below_ground(const std::vector<std::vector<Pose>>& samples, std::size_t joint, const Vec3& point) {
  constexpr double far = 0.1;  // share of the character's extent
  std::size_t count = 0;
  for (const std::vector<Pose>& X : samples) {
    double low = 1e300;
    for (const Pose& pose : X) low = std::min(low, pose.p.z);
    count += (X[joint] * point).z < low - far * extent_of(X) ? 1 : 0;
  }
  return 2 * count > samples.size();
}

/// The joint of the chain from `first` to the head that is nearest to a point.
std::size_t nearest_of_chain(const Skeleton& s, const std::vector<Vec3>& rest, std::size_t first, const Vec3& point) {
  std::size_t nearest = first;
  for (std::size_t i = first + 1; i < s.joints.size(); ++i) {
    if (s.joints[i].parent != static_cast<int>(nearest)) continue;
    if (norm(rest[i] - point) < norm(rest[nearest] - point)) nearest = i;
  }
  return nearest;
}

}  // namespace

std::vector<std::string> add_limb_ends(std::span<MeasuredMotion> motions) {
  constexpr double ankle = 0.88;  // share of the last bone above the foot, where a rig has no joint for it
  std::vector<std::string> names;
  const Skeleton s = motions[0].skeleton;
  const std::vector<body::NameEvidence> evidence = evidence_of(s);
  const std::vector<int> children = child_counts(s);
  const std::vector<std::vector<Pose>> samples = sample_poses(motions);
  std::vector<int> new_parent(s.joints.size(), -1);
  for (std::size_t i = 0; i < s.joints.size(); ++i) {
    if (children[i] > 0 || s.joints[i].parent < 0) continue;
    // A leaf that marks the end of its parent's bone ("Leg_end") is no joint of the limb.
    const int above = s.joints[i].parent;
    const bool marks_end = evidence[i].end && !evidence[i].control && children[at(above)] == 1 && norm(s.joints[i].offset) > 1e-6;
    const int last = marks_end ? above : static_cast<int>(i);
    std::vector<int> limb;  // from the last joint to the joint below the trunk
    bool other = false;
    for (int k = last; k >= 0 && (k == last || children[at(k)] == 1); k = s.joints[at(k)].parent) {
      const body::NameEvidence& name = evidence[at(k)];
      other = other || name.helper || name.tail || name.wing || name.part == body::Part::head || name.part == body::Part::neck;
      if (s.joints[at(k)].parent >= 0) limb.push_back(k);
    }
    if (other || limb.empty() || limb.size() > 2) continue;
    Vec3 end;
    for (const Vec3& e : s.joints[i].end_sites) end += e / static_cast<double>(s.joints[i].end_sites.size());
    if (marks_end) end = s.joints[i].offset;
    if (norm(end) < 1e-6 && limb.size() == 2) {
      end = s.joints[i].offset;
      // The limb has one bone, and the last joint is its foot.
      if (is_below_ground(samples, i, end)) {
        names.push_back(s.joints[i].name);
        for (MeasuredMotion& m : motions) {
          m.skeleton.joints[i].end_sites = {end * (0.5 * (1 - ankle))};
          append_rigid(m, s.joints[i].name + "_2", above, end * 0.5, {});
        }
        new_parent.resize(motions[0].skeleton.joints.size(), -1);
        new_parent[i] = motions[0].joint_count() - 1;
        continue;
      }
    }
    if (norm(end) < 1e-6) continue;
    const std::string& name = s.joints[at(last)].name;
    names.push_back(name);
    for (MeasuredMotion& m : motions) {
      int parent = last;
      m.skeleton.joints[at(last)].end_sites.clear();
      Vec3 rest = end;
      if (limb.size() == 1) {
        append_rigid(m, name + "_2", parent, end * 0.5, {});
        parent = static_cast<int>(m.skeleton.joints.size()) - 1;
        rest = end * 0.5;
      }
      append_rigid(m, name + "_3", parent, rest * ankle, {rest * (1 - ankle)});
    }
  }
  new_parent.resize(motions[0].skeleton.joints.size(), -1);
  if (std::ranges::any_of(new_parent, [](int p) { return p >= 0; })) reparent(motions, new_parent);
  return names;
}

std::vector<std::string> add_chest(std::span<MeasuredMotion> motions) {
  std::vector<std::string> names;
  const Skeleton& s = motions[0].skeleton;
  const std::vector<body::NameEvidence> evidence = evidence_of(s);
  const std::vector<Vec3> rest = rest_positions(s);
  const std::size_t n = s.joints.size();
  std::vector<double> depth(n, 0);  // m, length of the longest path below
  for (std::size_t i = n; i-- > 0;) {
    for (const Vec3& e : s.joints[i].end_sites) depth[i] = std::max(depth[i], norm(e));
    if (s.joints[i].parent >= 0)
      depth[at(s.joints[i].parent)] = std::max(depth[at(s.joints[i].parent)], depth[i] + norm(s.joints[i].offset));
  }
  for (std::size_t hub = 0; hub < n; ++hub) {
    std::vector<std::size_t> limbs;
    std::vector<std::size_t> heads;
    for (std::size_t i = 0; i < n; ++i) {
      if (s.joints[i].parent != static_cast<int>(hub)) continue;
      bool head = false, other = evidence[i].helper || evidence[i].tail || evidence[i].wing;
      for (std::size_t k = i; k < n; ++k) {
        int a = static_cast<int>(k);
        while (a > static_cast<int>(i)) a = s.joints[at(a)].parent;
        if (a == static_cast<int>(i)) other = other || evidence[k].tail;
        if (a == static_cast<int>(i)) head = head || evidence[k].part == body::Part::head || evidence[k].part == body::Part::neck;
      }
      if (head)
        heads.push_back(i);
      else if (!other && depth[i] > 0)
        limbs.push_back(i);
    }
    // Names of two arms and two legs distinguish them from the trunk, which can be a further branch, and which then carries the head.
    const auto are_named = [&](bool (*is_part)(body::Part)) {
      return std::ranges::count_if(limbs, [&](std::size_t i) {
               return evidence[i].side != 0 && !evidence[i].fore && !evidence[i].hind && is_part(evidence[i].part);
             }) == 2;
    };
    const bool person = are_named(body::is_arm) && are_named(body::is_leg);
    // The other branches of a person belong to the upper trunk.
    const auto is_limb = [&](std::size_t i) {
      return evidence[i].side != 0 && (body::is_arm(evidence[i].part) || body::is_leg(evidence[i].part));
    };
    if (person) {
      std::ranges::copy_if(limbs, std::back_inserter(heads), [&](std::size_t i) { return !is_limb(i); });
      std::erase_if(limbs, [&](std::size_t i) { return !is_limb(i); });
    }
    if ((heads.empty() && !person) || limbs.size() < 4) continue;
    // The four longest limbs, the front ones first.
    std::ranges::sort(limbs, [&](std::size_t a, std::size_t b) { return depth[a] != depth[b] ? depth[a] > depth[b] : a < b; });
    limbs.resize(4);
    Vec3 middle;
    for (const std::size_t i : limbs) middle += rest[i] * 0.25;
    Vec3 forward = person ? Vec3{} : rest[heads[0]] - middle;
    forward.z = 0;
    const auto front = [&](std::size_t i) {
      const bool fore = evidence[i].fore || (person && body::is_arm(evidence[i].part)),
                 hind = evidence[i].hind || (person && body::is_leg(evidence[i].part));
      return (fore ? 1e3 : hind ? -1e3 : 0) + dot(rest[i] - middle, forward);
    };
    std::ranges::sort(limbs, [&](std::size_t a, std::size_t b) { return front(a) != front(b) ? front(a) > front(b) : a < b; });
    const Vec3 chest = (rest[limbs[0]] + rest[limbs[1]]) * 0.5, hips = (rest[limbs[2]] + rest[limbs[3]]) * 0.5;
    if (depth[limbs[3]] < 0.5 * depth[limbs[0]] || norm(chest - hips) < 0.3 * depth[limbs[0]]) continue;
    // A trunk bone from the rump to the chest carries the neck: the neck is attached instead of it.
    if (!person) {
      std::vector<int> new_parent(n, -1);
      for (const std::size_t i : heads)
        if (const std::size_t k = nearest_of_chain(s, rest, i, chest); k != i) new_parent[k] = static_cast<int>(hub);
      if (std::ranges::any_of(new_parent, [](int p) { return p >= 0; })) {
        reparent(motions, new_parent);
        return add_chest(motions);
      }
    }
    const Vec3 offset = chest - rest[hub];
    std::vector<std::size_t> moved = {limbs[0], limbs[1]};
    moved.insert(moved.end(), heads.begin(), heads.end());
    for (const std::size_t i : {limbs[0], limbs[1]}) names.push_back(s.joints[i].name);
    for (MeasuredMotion& m : motions) {
      // The new joint stands directly behind its parent, so that parents precede children.
      const std::size_t place = hub + 1;
      std::vector<SkeletonJoint> joints = m.skeleton.joints;
      for (const std::size_t i : moved) {
        joints[i].offset -= offset;
        for (std::size_t f = 0; f < at(m.frames); ++f) m.translations[f * n + i] -= offset;
      }
      for (std::size_t i = 0; i < n; ++i) {
        const bool moves = std::ranges::find(moved, i) != moved.end();
        if (moves)
          joints[i].parent = static_cast<int>(place);
        else if (joints[i].parent >= static_cast<int>(place))
          ++joints[i].parent;
      }
      SkeletonJoint joint;
      joint.name = s.joints[hub].name + "_chest";
      joint.parent = static_cast<int>(hub);
      joint.offset = offset;
      joints.insert(joints.begin() + static_cast<std::ptrdiff_t>(place), joint);
      std::vector<Vec3> translations;
      std::vector<Quat> rotations;
      for (std::size_t f = 0; f < at(m.frames); ++f)
        for (std::size_t i = 0; i <= n; ++i) {
          const std::size_t from = f * n + (i > place ? i - 1 : i);
          translations.push_back(i == place ? offset : m.translations[from]);
          rotations.push_back(i == place ? Quat{} : m.rotations[from]);
        }
      m.skeleton.joints = std::move(joints);
      m.translations = std::move(translations);
      m.rotations = std::move(rotations);
    }
    return names;
  }
  return names;
}

}  // namespace ugoki::intake
