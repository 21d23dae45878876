#include "ugoki/motion/jumps.h"

#include <cmath>

#include "ugoki/mechanism/state.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki {
namespace {

constexpr double min_turn = 70 * pi / 180;  // rad per frame, reason in jumps.h
constexpr double min_speed = 80;            // rad/s, reason in jumps.h

bool turns_only(const Joint& joint) {
  return joint.type == JointType::revolute || joint.type == JointType::universal || joint.type == JointType::spherical;
}

}  // namespace

std::vector<Jump> find_jumps(const Motion& motion, const Mechanism& m) {
  std::vector<Jump> jumps;
  for (int i = 0; i < m.link_count(); ++i) {
    const Link& link = m.link(i);
    if (!turns_only(link.joint)) continue;
    for (int f = 1; f < motion.frames; ++f) {
      double d[6], square = 0;
      joint_difference(link.joint, motion.frame(f - 1) + link.q_index, motion.frame(f) + link.q_index, d);
      for (int k = 0; k < link.joint.nv(); ++k) square += d[k] * d[k];
      const double turn = std::sqrt(square);
      if (turn > min_turn && turn * motion.rate > min_speed) jumps.push_back({i, f});
    }
  }
  return jumps;
}

Motion without_jumps(const Motion& motion, const Mechanism& m) {
  Motion out = motion;
  const std::vector<Jump> jumps = find_jumps(motion, m);
  for (std::size_t at = 0; at < jumps.size();) {
    const int jumper = jumps[at].link;
    const Link& link = m.link(jumper);
    for (int f = jumps[at].frame; f < motion.frames; ++f) {
      double step[6] = {0, 0, 0, 0, 0, 0};
      if (at < jumps.size() && jumps[at].link == jumper && jumps[at].frame == f)
        ++at;
      else
        joint_difference(link.joint, motion.frame(f - 1) + link.q_index, motion.frame(f) + link.q_index, step);
      joint_integrate(link.joint, out.frame(f - 1) + link.q_index, step, 1.0, out.frame(f) + link.q_index);
    }
  }
  return out;
}

}  // namespace ugoki
