#include "ugoki/motion/feet_on_floor.h"

#include <algorithm>
#include <cmath>

#include "ugoki/mechanism/state.h"
#include "ugoki/motion/contact_labels.h"
#include "ugoki/motion/limb_reach.h"
#include "ugoki/motion/pass_through.h"

namespace ugoki {
namespace {

constexpr double root_time = 0.1;    // s, time constant of the root's correction
constexpr double foot_time = 0.03;   // s, time constant of a foot's own correction
constexpr double still_speed = 0.2;  // m/s: at this vertical speed the weight of a foot in contact has fallen to a quarter

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// A foot with its toes.
struct Foot {
  int link;
  std::vector<int> parts;  ///< links that can touch the ground: the foot and its descendants
  std::vector<std::vector<SupportPoint>> points;
  std::vector<int> limb;      ///< links from the limb's base to the foot, whose joints move no other foot
  double ankle = 0;           ///< m, height of the ankle above the floor while the foot stands
  std::vector<double> low;    ///< [frames] m, height of the lowest point above the floor
  std::vector<double> bears;  ///< [frames] 0 to 1: weight with which the foot counts as standing
};

/// Groups the links of find_feet() into feet: a link whose parent belongs to a foot is part of that foot.
std::vector<Foot> group_feet(const Mechanism& m) {
  const std::vector<int> links = find_feet(m);  // parents first
  std::vector<Foot> feet;
  std::vector<int> feet_behind(at(m.link_count()), 0);
  for (const int link : links) {
    const auto group = std::find_if(feet.begin(), feet.end(), [&](const Foot& f) {
      return std::find(f.parts.begin(), f.parts.end(), m.link(link).parent) != f.parts.end();
    });
    Foot& foot = group == feet.end() ? feet.emplace_back() : *group;
    if (foot.parts.empty()) {
      foot.link = link;
      for (int i = link; i >= 0; i = m.link(i).parent) ++feet_behind[at(i)];
    }
    foot.parts.push_back(link);
    foot.points.push_back(support_points(m.link(link)));
  }
  for (Foot& foot : feet)
    for (int i = foot.link; i > 0 && feet_behind[at(i)] == 1; i = m.link(i).parent) foot.limb.insert(foot.limb.begin(), i);
  return feet;
}

double lowest_point(const Foot& foot, std::span<const Pose> X_WB) {
  double low = 1e300;
  for (std::size_t p = 0; p < foot.parts.size(); ++p)
    for (const SupportPoint& s : foot.points[p]) low = std::min(low, (X_WB[at(foot.parts[p])] * s.p).z - s.radius);
  return low;
}

/// Computes `low` and `bears` of all feet in all animation frames.
void observe(const Motion& motion, const Mechanism& m, double floor, std::vector<Foot>& feet) {
  std::vector<Pose> X(at(m.link_count()));
  for (int f = 0; f < motion.frames; ++f) {
    calc_poses(m, std::span(motion.frame(f), at(motion.nq)), X);
    for (Foot& foot : feet) foot.low.push_back(lowest_point(foot, X) - floor);
  }
  std::vector<int> links;
  for (const Foot& foot : feet) links.push_back(foot.link);
  Motion labelled = motion;
  ContactLabelOptions options;
  options.ground = floor;
  label_contacts(m, labelled, links, options);
  for (std::size_t k = 0; k < feet.size(); ++k) {
    Foot& foot = feet[k];
    for (int f = 0; f < motion.frames; ++f) {
      const int before = std::max(0, f - 1), after = std::min(motion.frames - 1, f + 1);
      const double speed = (foot.low[at(after)] - foot.low[at(before)]) * motion.rate / (after - before);
      const double share = 1 / (1 + speed * speed / (still_speed * still_speed));
      foot.bears.push_back(labelled.contacts[k].on[at(f)] ? share * share : 0.0);
    }
  }
}

/// Turns a foot about its ankle so that its points do not reach far below the floor although the ankle is high enough (the large feet of
/// cartoon characters sink with the toes while the heel rises). A part of the depth is left to the lift of root and foot.
/// @param X world poses of the links @return the pose of the foot
Pose turned_up(const Foot& foot, double floor, std::span<const Pose> X) {
  constexpr double left = 0.15;  // share of the distance from the ankle to the farthest point
  const Pose& start = X[at(foot.link)];
  double reach = 0;
  for (std::size_t p = 0; p < foot.parts.size(); ++p)
    for (const SupportPoint& s : foot.points[p]) reach = std::max(reach, norm(X[at(foot.parts[p])] * s.p - start.p));
  Mat3 turn = Mat3::identity();
  for (int round = 0; round < 4; ++round) {
    double angle = 0;
    Vec3 axis;
    for (std::size_t p = 0; p < foot.parts.size(); ++p)
      for (const SupportPoint& s : foot.points[p]) {
        const Vec3 r = turn * (X[at(foot.parts[p])] * s.p - start.p);
        const double length = norm(r), across = std::sqrt(r.x * r.x + r.y * r.y);
        const double allowed = floor - left * reach - std::max(0.0, foot.ankle - (start.p.z - floor));
        const double wanted = std::min(allowed + s.radius - start.p.z, 0.0);  // of r.z
        if (r.z >= wanted || !(across > 1e-6 * length)) continue;
        const double needed = asin(std::clamp(wanted / length, -1.0, 1.0)) - asin(std::clamp(r.z / length, -1.0, 1.0));
        if (needed <= angle) continue;
        angle = needed;
        axis = normalized(Vec3{r.y, -r.x, 0});
      }
    if (!(angle > 1e-9)) break;
    turn = rotation_about(axis, angle) * turn;
  }
  return {turn * start.R, start.p};
}

/// Turns sunken feet up in all frames.
void turn_up(Motion& motion, const Mechanism& m, double floor, std::vector<Foot>& feet) {
  std::vector<Pose> X(at(m.link_count()));
  std::vector<std::vector<double>> heights(feet.size());
  for (int f = 0; f < motion.frames; ++f) {
    calc_poses(m, std::span<const double>(motion.frame(f), at(motion.nq)), X);
    for (std::size_t k = 0; k < feet.size(); ++k) heights[k].push_back(X[at(feet[k].link)].p.z - floor);
  }
  for (std::size_t k = 0; k < feet.size(); ++k) {
    const auto low = heights[k].begin() + static_cast<std::ptrdiff_t>(heights[k].size() / 10);
    std::ranges::nth_element(heights[k], low);
    feet[k].ankle = *low;
  }
  for (int f = 0; f < motion.frames; ++f) {
    double* q = motion.frame(f);
    calc_poses(m, std::span<const double>(q, at(motion.nq)), X);
    for (const Foot& foot : feet) {
      const Pose goal = turned_up(foot, floor, X);
      if (goal.R != X[at(foot.link)].R) reach(m, foot.limb, goal, {}, q, X);
    }
  }
}

/// Vertical correction of the root: the smoothed weighted mean of the corrections of the standing feet, m [frames].
std::vector<double> lift_of_root(const std::vector<Foot>& feet, double rate) {
  const std::size_t frames = feet.front().low.size();
  std::vector<double> value(frames), weight(frames);
  for (std::size_t f = 0; f < frames; ++f) {
    for (const Foot& foot : feet) {
      weight[f] += foot.bears[f];
      value[f] -= foot.bears[f] * foot.low[f];
    }
    if (weight[f] > 0) value[f] /= weight[f];
  }
  return pass_through(value, weight, root_time * rate * root_time * rate);
}

/// Remaining vertical correction of one foot after the root's correction, such that the foot is never below the floor, m [frames].
std::vector<double> lift_of_foot(const Foot& foot, std::span<const double> root, double rate) {
  std::vector<double> value(root.size());
  for (std::size_t f = 0; f < root.size(); ++f) value[f] = -foot.low[f] - root[f];
  std::vector<double> lift = pass_through(value, foot.bears, foot_time * rate * foot_time * rate);
  for (std::size_t f = 0; f < root.size(); ++f) lift[f] = std::max(lift[f], value[f]);
  return lift;
}

}  // namespace

Motion with_feet_on_floor(const Motion& motion, const Mechanism& m, double floor) {
  Motion out = motion;
  std::vector<Foot> feet = group_feet(m);
  if (feet.empty() || motion.frames < 2 || m.link(0).joint.type != JointType::floating) return out;
  std::vector<Pose> X(at(m.link_count()));
  turn_up(out, m, floor, feet);
  observe(out, m, floor, feet);
  const std::vector<double> root = lift_of_root(feet, motion.rate);
  std::vector<std::vector<double>> lifts;
  for (const Foot& foot : feet) lifts.push_back(lift_of_foot(foot, root, motion.rate));
  for (int f = 0; f < motion.frames; ++f) {
    double* q = out.frame(f);
    const Vec3 up = transpose_times(m.link(0).joint.X_PJ.R, Vec3{0, 0, root[at(f)]});
    for (int k = 0; k < 3; ++k) q[k] += up[k];
    calc_poses(m, std::span<const double>(q, at(motion.nq)), X);
    for (std::size_t k = 0; k < feet.size(); ++k) {
      Pose goal = X[at(feet[k].link)];
      goal.p.z += lifts[k][at(f)];
      reach(m, feet[k].limb, goal, {}, q, X);
    }
  }
  return out;
}

}  // namespace ugoki
