#include "ugoki/control/body_plan.h"

#include <algorithm>
#include <string>
#include <vector>

#include "ugoki/control/foot_schedule.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/contact_labels.h"

namespace ugoki::control {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

int labelled(const Mechanism& m, const std::string& label) {
  for (int i = 0; i < m.link_count(); ++i)
    if (m.link(i).label == label) return i;
  return -1;
}

/// Middle of the support points of the hand, or of its first descendant that has some.
Effector palm_of(const Mechanism& m, int hand, std::span<const Pose> X) {
  Effector palm{hand, {}, 0};
  std::vector<char> inside(at(m.link_count()));
  inside[at(hand)] = 1;
  for (int i = hand; i < m.link_count(); ++i) {
    if (i > hand) inside[at(i)] = m.link(i).parent >= 0 && inside[at(m.link(i).parent)];
    if (!inside[at(i)]) continue;
    const std::vector<SupportPoint> points = support_points(m.link(i));
    if (points.empty()) continue;
    for (const SupportPoint& s : points) {
      palm.point += X[at(hand)].inverse() * (X[at(i)] * s.p) / static_cast<double>(points.size());
      palm.radius = std::max(palm.radius, s.radius);
    }
    break;
  }
  return palm;
}

}  // namespace

std::optional<BodyPlan> body_plan_of(const Mechanism& m) {
  if (m.link_count() == 0 || m.link(0).joint.type != JointType::floating) return std::nullopt;
  BodyPlan plan;
  plan.chest = labelled(m, "chest");
  plan.head = labelled(m, "head");
  const std::vector<Foot> feet = feet_of(m);
  if (plan.chest < 0 || plan.head < 0 || feet.size() != 2) return std::nullopt;
  std::vector<Pose> X(at(m.link_count()));
  calc_poses(m, m.neutral(), X);
  for (int side = 0; side < 2; ++side) {
    const std::string name = side == 0 ? " left" : " right";
    const int thigh = labelled(m, "thigh" + name), shank = labelled(m, "shank" + name), foot = labelled(m, "foot" + name);
    const int arm = labelled(m, "upper arm" + name), forearm = labelled(m, "forearm" + name), hand = labelled(m, "hand" + name);
    if (std::min({thigh, shank, foot, arm, forearm, hand}) < 0) return std::nullopt;
    const auto own = std::ranges::find_if(feet, [&](const Foot& f) { return std::ranges::find(f.parts, foot) != f.parts.end(); });
    if (own == feet.end()) return std::nullopt;
    plan.places[at(side)] = {Effector{own->link, own->sole, 0}, Effector{shank, {}, 0}, palm_of(m, hand, X)};
    plan.thigh[at(side)] = thigh;
    plan.upper_arm[at(side)] = arm;
    plan.thigh_length = norm(X[at(shank)].p - X[at(thigh)].p);
    plan.arm_length = norm(X[at(forearm)].p - X[at(arm)].p) + norm(X[at(hand)].p - X[at(forearm)].p);
    plan.hip_height = X[at(thigh)].p.z - (X[at(own->link)] * own->sole).z;
  }
  plan.rest = X[0].R;
  plan.head_up = transpose_times(X[at(plan.head)].R, Vec3{0, 0, 1});
  return plan;
}

}  // namespace ugoki::control
