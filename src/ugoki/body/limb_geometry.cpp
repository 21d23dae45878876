#include "ugoki/body/limb_geometry.h"

#include <algorithm>

#include "ugoki/body/recognise.h"

namespace ugoki::body {
namespace {
std::size_t at(int i) { return static_cast<std::size_t>(i); }
}  // namespace

double facing_of(const MotionShape& motion, const Branch (&legs)[2], const Sections (&leg_parts)[2], double size) {
  double shape = 0;
  for (int f = 0; f < motion.frames(); ++f) {
    const auto leg_joint = [&](int s, int k) { return motion.p(f, legs[s].path[at(k)]); };
    const Vec3 across = normalized(leg_joint(0, leg_parts[0].upper) - leg_joint(1, leg_parts[1].upper));
    for (int s = 0; s < 2; ++s) {
      const Vec3 hip = leg_joint(s, leg_parts[s].upper), knee = leg_joint(s, leg_parts[s].lower), ankle = leg_joint(s, leg_parts[s].end);
      const Vec3 up = normalized(hip - ankle);
      // A leg of four joints ends at its last joint or end site.
      Vec3 toes = leg_parts[s].tip >= 0 ? leg_joint(s, leg_parts[s].tip) - ankle : motion.tip(f, legs[s].leaf) - ankle;
      toes = toes - normalized(knee - ankle) * dot(toes, normalized(knee - ankle));
      const Vec3 bend = (knee - (hip + ankle) * 0.5) * 2.0;
      shape += dot(cross(up, normalized(toes, {})), across) * std::min(1.0, norm(toes) / (0.02 * size)) +
               dot(cross(up, bend), across) / (0.05 * size);
    }
  }
  shape /= 2.0 * motion.frames();
  return shape;
}

std::size_t find_thumb_among(const MotionShape& motion, const Limb& arm, std::span<const int> tips) {
  std::size_t thumb = 0;
  double smallest = 1e300;
  for (std::size_t k = 0; k < tips.size(); ++k) {
    double straight = 0;  // agreement of the finger's direction with the forearm or with the other fingers
    for (int f = 0; f < motion.frames(); ++f) {
      const Vec3 wrist = motion.p(f, arm.end);
      const auto direction = [&](std::size_t j) { return normalized(motion.tip(f, tips[j]) - wrist, {}); };
      Vec3 others{};
      for (std::size_t j = 0; j < tips.size(); ++j)
        if (j != k) others += direction(j);
      if (tips.size() == 2) others = wrist - motion.p(f, arm.distal);
      straight += dot(direction(k), normalized(others));
    }
    // With two fingers, the shorter one is more likely the thumb.
    if (tips.size() == 2)
      straight +=
          motion.frames() * 0.5 * motion.distance(arm.end, tips[k]).mean / std::max(1e-9, motion.distance(arm.end, tips[1 - k]).mean);
    if (straight < smallest) {
      smallest = straight;
      thumb = k;
    }
  }
  return thumb;
}

Anatomy anatomy_of(const Character& character, const Skeleton& skeleton) {
  const std::size_t n = skeleton.joints.size();
  Anatomy a;
  a.human = character.plan == BodyPlan::human;
  a.why_not = character.why_not;
  a.p = rest_positions(skeleton);
  a.children.resize(n);
  a.parts.assign(n, {});
  a.mirror.assign(n, -1);
  a.bone.resize(n);
  a.helper = character.helper;
  for (std::size_t i = 0; i < n; ++i)
    if (const int parent = skeleton.joints[i].parent; parent >= 0) a.children[at(parent)].push_back(static_cast<int>(i));
  // The bone of a joint ends at its farthest end site or child; children that only follow do not count.
  for (std::size_t i = 0; i < n; ++i) {
    Vec3 best{};
    for (const Vec3& e : skeleton.joints[i].end_sites)
      if (norm(e) > norm(best)) best = e;
    for (const int c : a.children[i])
      if (character.helper[at(c)] == 0 && norm(a.p[at(c)] - a.p[i]) > norm(best)) best = a.p[at(c)] - a.p[i];
    // If the joint has no other end, its bone ends at its farthest child that only follows.
    if (!(norm(best) > 0))
      for (const int c : a.children[i])
        if (norm(a.p[at(c)] - a.p[i]) > norm(best)) best = a.p[at(c)] - a.p[i];
    a.bone[i] = best;
  }
  if (!a.human) return a;
  for (const std::array<Limb, 2>* limbs : {&character.legs, &character.arms})
    for (const Limb& l : *limbs) {
      // Along a limb the bone ends at the next joint of the limb.
      const int last = l.end >= 0 ? l.end : l.distal;
      for (int i = last; i >= 0 && i != l.proximal; i = skeleton.joints[at(i)].parent) {
        const int parent = skeleton.joints[at(i)].parent;
        a.bone[at(parent)] = a.p[at(i)] - a.p[at(parent)];
      }
      if (l.end >= 0 && l.tip >= 0 && skeleton.joints[at(l.tip)].parent == l.end) a.bone[at(l.end)] = a.p[at(l.tip)] - a.p[at(l.end)];
    }
  a.parts = character.parts;
  for (std::size_t i = 0; i < n; ++i)
    if (character.helper[i] != 0) a.parts[i] = {};
  for (const int i : character.root_path) a.parts[at(i)] = {Part::pelvis, 0};
  a.trunk = character.root_path;
  a.trunk.insert(a.trunk.end(), character.trunk.begin(), character.trunk.end());
  a.neck = character.neck;
  a.legs = character.legs;
  a.arms = character.arms;
  // Pairs the joints of each part by their order on both sides.
  for (std::size_t i = 0; i < n; ++i) {
    const SidedPart sided = a.parts[i];
    if (sided.side <= 0) continue;
    int rank = 0;
    for (std::size_t k = 0; k < i; ++k) rank += a.parts[k].part == sided.part && a.parts[k].side == sided.side ? 1 : 0;
    for (std::size_t k = 0; k < n; ++k) {
      if (a.parts[k].part != sided.part || a.parts[k].side != -1) continue;
      if (rank-- == 0) {
        a.mirror[i] = static_cast<int>(k);
        a.mirror[k] = static_cast<int>(i);
      }
    }
  }
  return a;
}

}  // namespace ugoki::body
