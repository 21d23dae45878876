#include "ugoki/dynamics/joint_forces.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/check.h"
#include "ugoki/dynamics/rotation_chart.h"

namespace ugoki::dynamics {
namespace {

/// True if the coordinate of DOF k of the joint is an angle.
bool is_angle(const Joint& joint, int k) {
  switch (joint.type) {
    case JointType::prismatic: return false;
    case JointType::cylindrical: return k == 0;
    case JointType::planar: return k == 2;
    case JointType::floating: return k < 3;
    default: return true;
  }
}

/// Force of spring and limits on one coordinate x: total, conservative part, and derivatives of the total with respect to x (dx) and to the
/// rate of x (drate).
struct CoordinateForce {
  double force = 0, conservative = 0, dx = 0, drate = 0;
  double spring_energy = 0, limit_energy = 0;
};

void add_limit(const Dof& f, double x, double rate, double stiffness, double dissipation, CoordinateForce& out) {
  const bool below = x < f.lower;
  if (!below && !(x > f.upper)) return;
  const double direction = below ? 1 : -1;
  const double depth = below ? f.lower - x : x - f.upper;  // the rate of depth is -direction * rate
  const double damping = std::max(0.0, 1 - dissipation * direction * rate);
  out.limit_energy = 0.5 * stiffness * depth * depth;
  out.conservative += direction * stiffness * depth;
  out.force += direction * stiffness * depth * damping;
  out.dx -= stiffness * damping;
  if (damping > 0) out.drate -= stiffness * depth * dissipation;
}

CoordinateForce coordinate_force(const Joint& joint, int k, double x, double rate, const JointForceOptions& o) {
  const Dof& f = joint.dofs[static_cast<std::size_t>(k)];
  CoordinateForce out;
  if (f.stiffness > 0) {
    const double stretch = x - f.rest;
    out.force = out.conservative = -f.stiffness * stretch;
    out.dx = -f.stiffness;
    out.spring_energy = 0.5 * f.stiffness * stretch * stretch;
  }
  add_limit(f, x, rate, is_angle(joint, k) ? o.limit_turn : o.limit_shift, o.limit_dissipation, out);
  return out;
}

/// The coordinates of a joint on which springs and limits act.
struct JointCoordinates {
  int count = 0;         ///< number of coordinates: nv of the joint; 0 for floating joints
  Vec3 r;                ///< rotation vector of a spherical joint
  double x[6], rate[6];  ///< [count] coordinates and their time derivatives
};

JointCoordinates coordinates_of(const Joint& joint, const double* q, const double* v) {
  JointCoordinates out;
  if (joint.type == JointType::floating) return out;
  out.count = joint.nv();
  joint_displacement(joint, q, out.x);
  for (int k = 0; k < out.count; ++k) out.rate[k] = v[k];
  if (joint.type == JointType::spherical) {
    out.r = {out.x[0], out.x[1], out.x[2]};
    const Vec3 rate = rotation_vector_rate(out.r, {v[0], v[1], v[2]});
    for (int k = 0; k < 3; ++k) out.rate[k] = rate[k];
  }
  return out;
}

double smooth_sign(double v, double speed) { return v / std::sqrt(v * v + speed * speed); }

}  // namespace

JointForceReport calc_joint_forces(const Mechanism& m, std::span<const double> q, std::span<const double> v, std::span<const double> drive,
                                   const JointForceOptions& options, std::span<double> tau) {
  UGOKI_CHECK(static_cast<int>(v.size()) == m.nv() && tau.size() == v.size() && (drive.empty() || drive.size() == v.size()));
  JointForceReport report;
  for (const Link& link : m.links()) {
    const Joint& joint = link.joint;
    const auto first = static_cast<std::size_t>(link.v_index);
    const double* vj = v.data() + first;
    for (int k = 0; k < joint.nv(); ++k) {
      const std::size_t f = first + static_cast<std::size_t>(k);
      const Dof& dof = joint.dofs[static_cast<std::size_t>(k)];
      const double requested = drive.empty() ? 0.0 : drive[f];
      const double applied = std::clamp(requested, -dof.effort, dof.effort);
      const double resisting = -dof.damping * vj[k] - dof.friction * smooth_sign(vj[k], options.friction_speed);
      report.saturated += applied != requested;
      report.drive_power += applied * vj[k];
      report.loss -= resisting * vj[k];
      tau[f] = applied + resisting;
    }
    const JointCoordinates c = coordinates_of(joint, q.data() + link.q_index, vj);
    double force[6] = {};
    for (int k = 0; k < c.count; ++k) {
      const CoordinateForce law = coordinate_force(joint, k, c.x[k], c.rate[k], options);
      force[k] = law.force;
      report.spring_energy += law.spring_energy;
      report.limit_energy += law.limit_energy;
      report.limits += law.limit_energy > 0;
      report.loss -= (law.force - law.conservative) * c.rate[k];
    }
    if (joint.type == JointType::spherical) {
      const Vec3 torque = rotation_vector_torque(c.r, {force[0], force[1], force[2]});
      for (int k = 0; k < 3; ++k) force[k] = torque[k];
    }
    for (int k = 0; k < c.count; ++k) tau[first + static_cast<std::size_t>(k)] += force[k];
  }
  return report;
}

void calc_joint_force_slopes(const Mechanism& m, std::span<const double> q, std::span<const double> v, const JointForceOptions& options,
                             std::span<double> dq, std::span<double> dv) {
  UGOKI_CHECK(static_cast<int>(v.size()) == m.nv() && dq.size() == v.size() && dv.size() == v.size());
  const double s2 = options.friction_speed * options.friction_speed;
  for (const Link& link : m.links()) {
    const Joint& joint = link.joint;
    const auto first = static_cast<std::size_t>(link.v_index);
    const double* vj = v.data() + first;
    const JointCoordinates c = coordinates_of(joint, q.data() + link.q_index, vj);
    for (int k = 0; k < joint.nv(); ++k) {
      const std::size_t f = first + static_cast<std::size_t>(k);
      const Dof& dof = joint.dofs[static_cast<std::size_t>(k)];
      const double root = std::sqrt(vj[k] * vj[k] + s2);
      dq[f] = 0;
      dv[f] = -dof.damping - dof.friction * s2 / (root * root * root);
      if (k >= c.count) continue;
      const CoordinateForce law = coordinate_force(joint, k, c.x[k], c.rate[k], options);
      dq[f] += law.dx;
      dv[f] += law.drate;
    }
  }
}

}  // namespace ugoki::dynamics
