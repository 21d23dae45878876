#include "ugoki/motion_edit/mean_pose.h"

#include <algorithm>
#include <cmath>

namespace ugoki::motion_edit {
namespace {

constexpr int max_iterations = 30;
constexpr double enough = 1e-13;  // rad or m: the iteration stops when the step is smaller

std::size_t heaviest(std::span<const double> weights) {
  return static_cast<std::size_t>(std::max_element(weights.begin(), weights.end()) - weights.begin());
}

}  // namespace

void calc_mean(const Mechanism& m, std::span<const std::vector<double>> q, std::span<const double> weights, std::span<double> out) {
  const std::vector<double>& first = q[heaviest(weights)];
  for (const Link& link : m.links()) {
    const Joint& joint = link.joint;
    double* x = out.data() + link.q_index;
    std::copy_n(first.data() + link.q_index, joint.nq(), x);
    for (int iteration = 0; iteration < max_iterations; ++iteration) {
      double step[6] = {0, 0, 0, 0, 0, 0}, maximum = 0;
      for (std::size_t i = 0; i < q.size(); ++i) {
        if (weights[i] == 0) continue;
        double d[6];
        joint_difference(joint, x, q[i].data() + link.q_index, d);
        for (int k = 0; k < joint.nv(); ++k) step[k] += weights[i] * d[k];
      }
      for (int k = 0; k < joint.nv(); ++k) maximum = std::max(maximum, std::fabs(step[k]));
      if (maximum < enough) break;
      joint_integrate(joint, x, step, 1.0, x);
    }
  }
}

Quat calc_mean(std::span<const Quat> rotations, std::span<const double> weights) {
  Quat x = rotations[heaviest(weights)];
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    Vec3 step;
    for (std::size_t i = 0; i < rotations.size(); ++i) step += log_map(x.conjugate() * rotations[i]) * weights[i];
    if (norm(step) < enough) break;
    x = normalized(x * exp_map(step));
  }
  return x;
}

}  // namespace ugoki::motion_edit
