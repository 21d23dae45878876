#include "ugoki/capture/pose_solver.h"

#include <algorithm>
#include <cmath>

#include "ugoki/dynamics/dense.h"

namespace ugoki::capture {
namespace {

/// Range of the rotational DOFs of a segment's joint. In the root's joint three translations precede them.
struct RotationDofs {
  std::size_t first;
  int count;
};
RotationDofs rotation_dofs(const Subject& s, std::size_t i) {
  const auto first = static_cast<std::size_t>(s.first_dof[i]);
  switch (s.segment(i).joint) {
    case ModelJoint::root: return {first + 3, 3};
    case ModelJoint::ball: return {first, 3};
    case ModelJoint::universal: return {first, 2};
    case ModelJoint::hinge: return {first, 1};
    case ModelJoint::fixed: break;
  }
  return {first, 0};
}

/// Deviation [rad] of segment i's joint from pose `from` (null: from rest) along its rotational DOFs.
Vec3 departure(const Subject& s, const ModelPose& pose, const ModelPose* from, std::size_t i) {
  const ModelJoint joint = s.segment(i).joint;
  if (joint == ModelJoint::root || joint == ModelJoint::ball)
    return log_map(from == nullptr ? pose.rotations[i] : from->rotations[i].conjugate() * pose.rotations[i]);
  return {pose.angles[2 * i] - (from == nullptr ? 0 : from->angles[2 * i]),
          pose.angles[2 * i + 1] - (from == nullptr ? 0 : from->angles[2 * i + 1]), 0};
}

/// Huber limit [m] of a marker. Skin moves by at most a few centimetres relative to the bone: a marker with much noise that is farther off
/// has a wrong label.
double outlier_limit(const PoseOptions& o, double noise) { return o.outlier * std::clamp(noise, 1.0, 2.0); }

/// Huber loss of an error r >= 0.
double huber(double r, double limit) { return r <= limit ? 0.5 * r * r : limit * (r - 0.5 * limit); }

}  // namespace

MeasuredFrame measured_frame(const MarkerMotion& motion, const Subject& subject, int frame) {
  MeasuredFrame out;
  for (const int column : subject.columns) {
    const bool seen = motion.seen(frame, column);
    out.positions.push_back(motion.at(frame, column));
    out.seen.push_back(seen ? 1 : 0);
    out.count += seen ? 1 : 0;
  }
  return out;
}

double PoseSolver::cost(const Subject& s, const MeasuredFrame& frame, const PoseOptions& o, const ModelPose& pose) {
  calc_kinematics(s, pose, k_);
  double sum = 0;
  for (std::size_t m = 0; m < frame.positions.size(); ++m)
    if (frame.seen[m] != 0)
      sum += huber(norm(marker_position(s, k_, m) - frame.positions[m]) / (o.marker_sigma * s.marker(m).noise),
                   outlier_limit(o, s.marker(m).noise) / (o.marker_sigma * s.marker(m).noise));
  for (std::size_t i = 0; i < s.segment_count(); ++i) {
    const Vec3 rest = departure(s, pose, nullptr, i) / s.segment(i).stiffness_sigma;
    sum += 0.5 * dot(rest, rest);
    if (o.near == nullptr || o.step_sigma <= 0) continue;
    const Vec3 step = departure(s, pose, o.near, i) / o.step_sigma;
    sum += 0.5 * dot(step, step);
  }
  return sum;
}

Vec3 PoseSolver::jacobian(const Subject& s, std::size_t used, std::size_t dof) const {
  if (pinned_[dof] != 0) return {};
  const Vec3 x = marker_position(s, k_, used);
  for (int i = s.marker(used).segment; i >= 0; i = s.segment(static_cast<std::size_t>(i)).parent) {
    const auto j = static_cast<std::size_t>(i);
    const auto first = static_cast<std::size_t>(s.first_dof[j]);
    if (dof < first) continue;
    const RotationDofs t = rotation_dofs(s, j);
    if (dof < t.first) return k_.axes[dof];
    if (dof < t.first + static_cast<std::size_t>(t.count)) return cross(k_.axes[dof], x - k_.p[j]);
    return {};
  }
  return {};
}

double marker_weight(const PoseOptions& o, double noise, double distance) {
  const double sigma = o.marker_sigma * noise, outlier = outlier_limit(o, noise);
  return (distance > outlier ? outlier / distance : 1) / (sigma * sigma);
}

void PoseSolver::linearize(const Subject& s, const MeasuredFrame& frame, const PoseOptions& o, const ModelPose& pose) {
  const auto n = static_cast<std::size_t>(s.dofs);
  H_.assign(n * n, 0);
  g_.assign(n, 0);
  std::vector<std::pair<std::size_t, Vec3>> columns;
  for (std::size_t m = 0; m < frame.positions.size(); ++m) {
    if (frame.seen[m] == 0) continue;
    const Vec3 x = marker_position(s, k_, m);
    const Vec3 error = x - frame.positions[m];
    const double weight = marker_weight(o, s.marker(m).noise, norm(error));
    columns.clear();
    for (int i = s.marker(m).segment; i >= 0; i = s.segment(static_cast<std::size_t>(i)).parent) {
      const auto j = static_cast<std::size_t>(i);
      const RotationDofs t = rotation_dofs(s, j);
      for (std::size_t f = static_cast<std::size_t>(s.first_dof[j]); f < t.first; ++f) columns.emplace_back(f, k_.axes[f]);
      for (std::size_t f = t.first; f < t.first + static_cast<std::size_t>(t.count); ++f)
        columns.emplace_back(f, cross(k_.axes[f], x - k_.p[j]));
    }
    for (const auto& [f, a] : columns) {
      g_[f] += weight * dot(a, error);
      for (const auto& [h, b] : columns)
        if (h <= f) H_[f * n + h] += weight * dot(a, b);
    }
  }
  for (std::size_t i = 0; i < s.segment_count(); ++i) {
    const RotationDofs t = rotation_dofs(s, i);
    const double rest = 1 / (s.segment(i).stiffness_sigma * s.segment(i).stiffness_sigma);
    const double step = o.near != nullptr && o.step_sigma > 0 ? 1 / (o.step_sigma * o.step_sigma) : 0;
    const Vec3 from_rest = departure(s, pose, nullptr, i), from_near = departure(s, pose, o.near, i);
    for (int c = 0; c < t.count; ++c) {
      const std::size_t f = t.first + static_cast<std::size_t>(c);
      g_[f] += rest * from_rest[c] + step * from_near[c];
      H_[f * n + f] += rest + step;
    }
  }
  pin_angles_at_limits(s, pose);
}

void PoseSolver::pin_angles_at_limits(const Subject& s, const ModelPose& pose) {
  const auto n = static_cast<std::size_t>(s.dofs);
  pinned_.assign(n, 0);
  const auto check = [&](std::size_t f, double angle, double lower, double upper) {
    if (!((angle <= lower && g_[f] > 0) || (angle >= upper && g_[f] < 0))) return;
    pinned_[f] = 1;
    g_[f] = 0;
    for (std::size_t k = 0; k < n; ++k) H_[f * n + k] = H_[k * n + f] = 0;
    H_[f * n + f] = 1;
  };
  for (std::size_t i = 0; i < s.segment_count(); ++i) {
    const ModelSegment& segment = s.segment(i);
    const auto first = static_cast<std::size_t>(s.first_dof[i]);
    if (segment.joint == ModelJoint::hinge || segment.joint == ModelJoint::universal)
      check(first, pose.angles[2 * i], segment.lower, segment.upper);
    if (segment.joint == ModelJoint::universal) check(first + 1, pose.angles[2 * i + 1], segment.lower2, segment.upper2);
  }
}

double PoseSolver::solve(const Subject& s, const MeasuredFrame& frame, const PoseOptions& o, ModelPose& pose) {
  const auto n = static_cast<std::size_t>(s.dofs);
  double now = cost(s, frame, o, pose), damping = 1e-3;
  for (int iteration = 0; iteration < o.max_iterations; ++iteration) {
    linearize(s, frame, o, pose);
    ++iterations_;
    bool better = false;
    double gain = 0;
    for (int attempt = 0; attempt < 12 && !better; ++attempt) {
      L_ = H_;
      step_.resize(n);
      for (std::size_t f = 0; f < n; ++f) {
        L_[f * n + f] += damping * (L_[f * n + f] + 1);
        step_[f] = -g_[f];
      }
      if (dynamics::factor_cholesky(L_, s.dofs, 1e-14)) {
        dynamics::solve_cholesky(L_, s.dofs, step_);
        ModelPose trial = pose;
        move(s, step_, trial);
        const double then = cost(s, frame, o, trial);
        if (then < now) {
          gain = now - then;
          now = then;
          pose = std::move(trial);
          better = true;
          damping = std::max(damping * 0.2, 1e-9);
          break;
        }
      }
      damping = std::min(damping * 8, 1e9);
    }
    if (!better || gain < 1e-7 * (1 + now)) break;
  }
  now = cost(s, frame, o, pose);
  linearize(s, frame, o, pose);
  return now;
}

}  // namespace ugoki::capture
