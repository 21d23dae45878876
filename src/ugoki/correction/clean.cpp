#include "ugoki/correction/clean.h"

#include <algorithm>
#include <cmath>

#include "ugoki/motion/smooth_motion.h"

namespace ugoki::correction {
namespace {

constexpr double min_pop = 0.035;     // rad (2 degrees): smaller pops are left to the low-pass filter
constexpr double pop_ratio = 4;       // a pop is this many times faster than the frames around it
constexpr double turn_of_way = 1.75;  // rad/m: a translation of 1 cm counts as a rotation of 1 degree
constexpr int window = 8;             // frames before and after a pop that show the usual speed

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Distance between two poses of a joint, rad.
double distance(const Joint& joint, const double* a, const double* b) {
  double d[6], sum = 0;
  joint_difference(joint, a, b, d);
  for (int k = 0; k < joint.nv(); ++k) {
    const bool is_way = joint.type == JointType::prismatic || (joint.type == JointType::floating && k >= 3) ||
                        (joint.type == JointType::planar && k < 2) || (joint.type == JointType::cylindrical && k == 1);
    const double x = is_way ? turn_of_way * d[k] : d[k];
    sum += x * x;
  }
  return std::sqrt(sum);
}

double median(std::vector<double>& x) {
  if (x.empty()) return 0;
  const auto middle = x.begin() + static_cast<std::ptrdiff_t>(x.size() / 2);
  std::nth_element(x.begin(), middle, x.end());
  return *middle;
}

}  // namespace

int remove_pops(const Mechanism& m, Motion& motion) {
  int replaced = 0;
  std::vector<double> step, near;
  for (const Link& link : m.links()) {
    const Joint& joint = link.joint;
    if (joint.nv() == 0) continue;
    const auto q = [&](int f) { return motion.frame(f) + link.q_index; };
    step.assign(at(motion.frames), 0.0);  // distance to the next frame
    for (int f = 0; f + 1 < motion.frames; ++f) step[at(f)] = distance(joint, q(f), q(f + 1));
    for (int width = 1; width <= 3; ++width)
      for (int f = 1; f + width < motion.frames; ++f) {
        const double in = step[at(f - 1)], out = step[at(f + width - 1)];
        if (std::min(in, out) <= min_pop) continue;
        near.clear();
        for (int i = std::max(0, f - 1 - window); i < std::min(motion.frames - 1, f + width + window); ++i)
          if (i < f - 1 || i >= f + width) near.push_back(step[at(i)]);
        const double across = distance(joint, q(f - 1), q(f + width));
        if (std::min(in, out) <= min_pop + pop_ratio * std::max(median(near), across / (width + 1))) continue;
        double way[6], part[6];
        joint_difference(joint, q(f - 1), q(f + width), way);
        for (int i = 0; i < width; ++i) {
          for (int k = 0; k < joint.nv(); ++k) part[k] = way[k] * (i + 1) / (width + 1);
          joint_integrate(joint, q(f - 1), part, 1, q(f + i));
          ++replaced;
        }
        for (int i = f - 1; i < f + width; ++i) step[at(i)] = across / (width + 1);
      }
  }
  return replaced;
}

void remove_jitter(const Mechanism& m, Motion& motion, double cutoff) {
  if (!(cutoff > 0) || cutoff >= motion.rate / 3) return;
  const SmoothMotion smooth(motion, m, cutoff);
  std::vector<double> v(at(m.nv())), a(v.size());
  for (int f = 0; f < motion.frames; ++f) smooth.sample(m, f / motion.rate, {motion.frame(f), at(motion.nq)}, v, a);
}

void keep_limits(const Mechanism& m, Motion& motion) {
  for (int f = 0; f < motion.frames; ++f)
    for (const Link& link : m.links()) {
      const Joint& joint = link.joint;
      double* q = motion.frame(f) + link.q_index;
      const auto limited = [&](double x, int k) { return std::clamp(x, joint.dofs[at(k)].lower, joint.dofs[at(k)].upper); };
      if (joint.type == JointType::revolute || joint.type == JointType::universal) {
        for (int k = 0; k < joint.nv(); ++k) q[k] = limited(q[k], k);
      } else if (joint.type == JointType::spherical) {
        double x[3];
        joint_displacement(joint, q, x);
        const Vec3 r{limited(x[0], 0), limited(x[1], 1), limited(x[2], 2)};
        if (r == Vec3{x[0], x[1], x[2]}) continue;
        const Quat turn = exp_map(r);
        const double values[4] = {turn.w, turn.x, turn.y, turn.z};
        std::copy(values, values + 4, q);
      }
    }
}

}  // namespace ugoki::correction
