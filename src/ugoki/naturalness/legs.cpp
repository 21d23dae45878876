#include "ugoki/naturalness/legs.h"

#include <algorithm>
#include <cmath>

#include "ugoki/mechanism/state.h"

namespace ugoki::naturalness {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Joins each leg with the one whose foot is its mirror image in the neutral position. The mirror plane contains the root and is
/// normal to x or y of the root, whichever fits better.
void find_pairs(std::vector<Leg>& legs, const std::vector<Pose>& X) {
  const Pose root = X[0].inverse();
  const auto foot = [&](const Leg& leg) { return root * X[at(leg.limb.link)].p; };
  for (std::size_t i = 0; i < legs.size(); ++i) {
    double best = 0.25 * std::max(0.05, legs[i].limb.length);  // m: larger differences are no mirror image
    const Vec3 a = foot(legs[i]);
    for (std::size_t j = 0; j < legs.size(); ++j) {
      const Vec3 b = foot(legs[j]);
      const double d =
          std::min(std::fabs(a.x - b.x) + std::fabs(a.y + b.y), std::fabs(a.x + b.x) + std::fabs(a.y - b.y) + 1e-6) + std::fabs(a.z - b.z);
      if (i == j || d >= best || norm(a - b) < 1e-6) continue;
      best = d;
      legs[i].other = static_cast<int>(j);
    }
  }
  for (std::size_t i = 0; i < legs.size(); ++i)
    if (legs[i].other >= 0 && legs[at(legs[i].other)].other != static_cast<int>(i)) legs[i].other = -1;
}

/// The knee is the joint with the label of a shank, otherwise the joint of the chain that is nearest to the middle of the leg.
void find_knee(const Mechanism& m, Leg& leg, const std::vector<Pose>& X) {
  const std::vector<int>& chain = leg.limb.chain;
  std::vector<int> moved;  // links of the chain whose joints are at different places
  for (const int link : chain)
    if (moved.empty() || norm(X[at(link)].p - X[at(moved.back())].p) > 0.05 * leg.limb.length) moved.push_back(link);
  if (moved.size() < 3) return;
  std::size_t knee = 0;
  for (std::size_t i = 1; i + 1 < moved.size(); ++i)
    if (m.link(moved[i]).label.starts_with("shank")) knee = i;
  if (knee == 0) {
    double best = 1e300;
    for (std::size_t i = 1; i + 1 < moved.size(); ++i) {
      const double above = norm(X[at(moved[i])].p - X[at(moved[0])].p), below = norm(X[at(moved.back())].p - X[at(moved[i])].p);
      if (std::fabs(above - below) >= best) continue;
      best = std::fabs(above - below);
      knee = i;
    }
  }
  leg.hip = moved[knee - 1];
  leg.knee = moved[knee];
}

}  // namespace

BodyLegs find_legs(const Mechanism& m) {
  BodyLegs out;
  const int n = m.link_count();
  out.floating = m.link(0).joint.type == JointType::floating;
  out.feet = find_feet(m);
  out.leg_of_link.assign(at(n), -1);
  out.in_leg.assign(at(n), 0);
  std::vector<Pose> X(at(n));
  calc_poses(m, m.neutral(), X);
  if (out.floating)
    for (motion_edit::FootLimb& limb : motion_edit::find_foot_limbs(m)) {
      Leg leg;
      leg.limb = std::move(limb);
      const int index = static_cast<int>(out.legs.size());
      for (const int link : leg.limb.parts) out.leg_of_link[at(link)] = index;
      for (std::size_t k = 0; k < out.feet.size(); ++k)
        if (std::ranges::find(leg.limb.parts, out.feet[k]) != leg.limb.parts.end()) leg.foot_slots.push_back(k);
      std::vector<int> links = leg.limb.chain;
      links.insert(links.end(), leg.limb.parts.begin(), leg.limb.parts.end());
      std::ranges::sort(links);
      links.erase(std::unique(links.begin(), links.end()), links.end());
      for (const int link : links) {
        out.in_leg[at(link)] = 1;
        for (int k = 0; k < m.link(link).joint.nv(); ++k) leg.dofs.push_back(m.link(link).v_index + k);
      }
      find_knee(m, leg, X);
      out.legs.push_back(std::move(leg));
    }
  find_pairs(out.legs, X);
  for (int i = 0; i < n && out.head < 0; ++i)
    if (m.link(i).label.starts_with("head")) out.head = i;
  for (int i = 0; i < n; ++i)  // toes that cannot touch the ground
    if (const int parent = m.link(i).parent; parent >= 0 && out.in_leg[at(parent)]) out.in_leg[at(i)] = 1;
  out.in_trunk.assign(at(n), 0);
  out.in_trunk[0] = 1;
  for (int i = out.head; i >= 0; i = m.link(i).parent) out.in_trunk[at(i)] = 1;
  double low = 1e300;
  for (const Leg& leg : out.legs)
    for (const LinkPoint& p : leg.limb.points) low = std::min(low, (X[at(p.link)] * p.location.p).z - p.location.radius);
  if (out.legs.empty())
    for (const Pose& pose : X) low = std::min(low, pose.p.z);
  out.centre_height = std::max(0.01, centre_of_mass(m, X).z - low);
  return out;
}

}  // namespace ugoki::naturalness
