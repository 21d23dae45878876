#include "ugoki/intake/rigid_joints.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ugoki/base/check.h"

namespace ugoki::intake {
namespace {

constexpr double rigid = 0.01;       // m; joints that move less relative to each other move together
constexpr double arm_of_turn = 0.1;  // m, at which a relative turn is measured
constexpr double clearly = 0.5;      // another joint than the nearest ancestor is taken if it moves less than this share

}  // namespace

RigidJoints::RigidJoints(SampledJoints whole, SampledJoints reduced) : whole_(std::move(whole)), reduced_(std::move(reduced)) {
  for (std::size_t i = 0; i < whole_.names.size(); ++i) in_whole_.emplace(whole_.names[i], i);
  for (std::size_t k = 0; k < reduced_.names.size(); ++k) in_reduced_.emplace(reduced_.names[k], k);
}

std::optional<std::size_t> RigidJoints::remaining(std::size_t joint) const {
  const auto it = in_reduced_.find(whole_.names[joint]);
  return it == in_reduced_.end() ? std::nullopt : std::optional(it->second);
}

/// True for ancestors of a remaining joint, and the joint itself.
bool RigidJoints::carries_remaining(std::size_t joint) const {
  return std::ranges::any_of(in_reduced_, [&](const auto& entry) {
    const auto it = in_whole_.find(entry.first);
    int up = it == in_whole_.end() ? -1 : static_cast<int>(it->second);
    while (up >= 0 && up != static_cast<int>(joint)) up = whole_.parents[static_cast<std::size_t>(up)];
    return up >= 0;
  });
}

/// Largest motion [m] of a joint of the whole skeleton relative to one of the reduced skeleton over the sampled frames.
double RigidJoints::relative_motion(std::size_t reduced, std::size_t whole) const {
  const Pose first = reduced_.samples[0][reduced].inverse() * whole_.samples[0][whole];
  double largest = 0;
  for (std::size_t f = 1; f < whole_.samples.size(); ++f) {
    const Pose X = reduced_.samples[f][reduced].inverse() * whole_.samples[f][whole];
    double turn = 0;
    for (int c = 0; c < 3; ++c) turn = std::max(turn, norm(X.R.column(c) - first.R.column(c)));
    largest = std::max(largest, norm(X.p - first.p) + arm_of_turn * turn);
  }
  return largest;
}

std::optional<RigidJoint> RigidJoints::find(const std::string& name) const {
  const auto joint = in_whole_.find(name);
  UGOKI_CHECK(joint != in_whole_.end());
  const std::size_t i = joint->second;
  std::optional<std::size_t> target;
  for (int up = static_cast<int>(i); up >= 0 && !target; up = whole_.parents[static_cast<std::size_t>(up)])
    target = remaining(static_cast<std::size_t>(up));
  if (!target && !carries_remaining(i)) return std::nullopt;
  double minimum = target ? relative_motion(*target, i) : INFINITY;
  if (minimum > rigid)
    for (std::size_t k = 0; k < reduced_.names.size(); ++k)
      if (const double motion = relative_motion(k, i); !target || motion < clearly * minimum) {
        minimum = motion;
        target = k;
      }
  if (!target) return std::nullopt;
  const Pose at_rest{Mat3::identity(), whole_.rest[i] - reduced_.rest[*target]};
  return RigidJoint{*target, minimum <= rigid ? reduced_.samples[0][*target].inverse() * whole_.samples[0][i] : at_rest};
}

}  // namespace ugoki::intake
