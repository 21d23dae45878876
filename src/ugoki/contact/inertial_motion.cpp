#include "ugoki/contact/inertial_motion.h"

#include <algorithm>
#include <cmath>

#include "ugoki/dynamics/dynamics.h"
#include "ugoki/dynamics/rotation_chart.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::contact {
namespace {

constexpr double max_turn = 0.2;          // rad in a substep of an open system
constexpr double max_turn_closed = 0.02;  // rad in a substep of a closed system; with 0.05 dead points of the falling five-bar robot fail
constexpr double max_substeps = 20;       // bounds the cost; faster systems turn further in a substep
constexpr int max_closing_steps = 8;      // Newton steps that close the loops after a substep; 4 left gaps of 1e-7 m
// Pivot threshold of dependent loop rows (dynamics::dependent_row). Near dead points the forces of almost dependent rows would be huge.
constexpr double dependent = 1e-10;
constexpr double max_change = 0.3;  // relative change of the velocities at or above which the iteration of the bias forces diverges

/// Whether DOF `dof` of a joint is an angle.
bool turns(JointType type, int dof) {
  switch (type) {
    case JointType::prismatic: return false;
    case JointType::cylindrical: return dof == 0;
    case JointType::planar: return dof == 2;
    case JointType::floating: return dof < 3;
    default: return true;
  }
}

}  // namespace

InertialMotion::InertialMotion(const Mechanism& m) {
  for (const Link& link : m.links()) {
    const auto first = static_cast<std::size_t>(link.v_index);
    for (int k = 0; k < link.joint.nv(); ++k)
      if (turns(link.joint.type, k)) angles_.push_back(first + static_cast<std::size_t>(k));
    if (link.joint.type == JointType::spherical || link.joint.type == JointType::floating) rotations_.push_back(first);
  }
  const auto n = static_cast<std::size_t>(m.nv());
  for (std::vector<double>* x : {&zeros_, &u_, &rate_, &a_, &stage_v_, &sum_u_, &sum_v_, &start_v_}) x->assign(n, 0.0);
  for (std::vector<double>* x : {&stage_q_, &start_q_}) x->resize(static_cast<std::size_t>(m.nq()));
  if (std::ranges::any_of(m.loops(), &Loop::closed)) closing_.emplace_back(m);
}

double InertialMotion::turn(std::span<const double> v, double dt) const {
  double maximum = 0;
  for (const std::size_t k : angles_) maximum = std::max(maximum, std::fabs(v[k]) * dt);
  return maximum;
}

/// One step of the classical Runge-Kutta method for an open system. @return false if an acceleration is singular
bool InertialMotion::step_open(const Mechanism& m, dynamics::Workspace& ws, std::span<double> q, std::span<double> v, double h) {
  constexpr double time[] = {0, 0.5, 0.5, 1}, weight[] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
  const std::size_t n = v.size();
  for (int stage = 0; stage < 4; ++stage) {
    for (std::size_t k = 0; k < n; ++k) {
      u_[k] = stage == 0 ? 0 : time[stage] * h * rate_[k];
      stage_v_[k] = stage == 0 ? v[k] : v[k] + time[stage] * h * a_[k];
    }
    std::span<const double> at = q;
    if (stage > 0) {
      integrate(m, q, u_, 1, stage_q_);
      at = stage_q_;
    }
    if (!dynamics::calc_forward_dynamics(m, ws, at, stage_v_, zeros_, {}, {}, a_)) return false;
    rate_ = stage_v_;
    if (stage > 0)
      for (const std::size_t k : rotations_) {
        const Vec3 r = dynamics::rotation_vector_rate({u_[k], u_[k + 1], u_[k + 2]}, {stage_v_[k], stage_v_[k + 1], stage_v_[k + 2]});
        rate_[k] = r.x;
        rate_[k + 1] = r.y;
        rate_[k + 2] = r.z;
      }
    for (std::size_t k = 0; k < n; ++k) {
      sum_u_[k] = (stage == 0 ? 0 : sum_u_[k]) + weight[stage] * h * rate_[k];
      sum_v_[k] = (stage == 0 ? 0 : sum_v_[k]) + weight[stage] * h * a_[k];
    }
  }
  integrate(m, q, sum_u_, 1, q);
  for (std::size_t k = 0; k < n; ++k) v[k] += sum_v_[k];
  return std::ranges::all_of(v, [](double x) { return std::isfinite(x); });
}

/// One step of a closed system by the midpoint rule: bias forces and loops at the middle position and the mean velocity. Impulses of the
/// loops keep the mean velocity on the loops, so velocities stay bounded near dead points, where accelerations do not. The end is projected
/// onto the loops, position and velocity. @return false if an inertia is singular
bool InertialMotion::step_closed(const Mechanism& m, dynamics::ClosedLinks& closed, std::span<double> q, std::span<double> v, double h,
                                 double& gap) {
  dynamics::Workspace& ws = closing_[0];
  const std::size_t n = v.size();
  integrate(m, q, v, 0.5 * h, stage_q_);
  dynamics::update_kinematics(m, stage_q_, v, ws);
  if (dynamics::factor_closed_links(m, ws, closed, stage_q_, v, dependent) != dynamics::ClosedStatus::ok) return false;
  dynamics::share_virtual_inertias(closed, ws);  // the factor uses these shares; the bias forces must agree with them
  // stage_v_: new velocity; u_: mean velocity; rate_: impulses of the bias forces; a_: change of velocity
  for (std::size_t k = 0; k < n; ++k) sum_u_[k] = 2 * v[k];
  const auto find_velocity = [&](double length) {
    dynamics::calc_bias_forces(m, ws, stage_q_, u_, {}, {}, rate_);
    for (double& x : rate_) x *= -length;
    dynamics::solve_closed_links(m, ws, closed, rate_, sum_u_, a_);  // J (v + v') = J (2 v + a) = 0
    for (std::size_t k = 0; k < n; ++k) {
      stage_v_[k] = v[k] + a_[k];
      u_[k] = v[k] + 0.5 * a_[k];
    }
  };
  std::ranges::copy(v, u_.begin());
  find_velocity(h);
  double change = 0, size = 0;
  for (int iteration = 0; iteration < 2; ++iteration) {
    sum_v_ = stage_v_;
    find_velocity(h);
    change = size = 0;
    for (std::size_t k = 0; k < n; ++k) {
      change += (stage_v_[k] - sum_v_[k]) * (stage_v_[k] - sum_v_[k]);
      size += v[k] * v[k] + stage_v_[k] * stage_v_[k];
    }
  }
  if (!(change < max_change * max_change * size)) find_velocity(0);
  std::ranges::copy(stage_v_, v.begin());
  integrate(m, q, u_, h, q);
  double left = 0;
  if (dynamics::project_position(m, ws, closed, q, v, left, max_closing_steps) == dynamics::ClosedStatus::singular_inertia) return false;
  dynamics::project_velocity(m, ws, closed, v);
  gap = std::max(gap, left);
  return std::ranges::all_of(v, [](double x) { return std::isfinite(x); });
}

/// Kinetic energy, J, with that of the armatures.
double InertialMotion::kinetic_energy(const Mechanism& m, std::span<const double> q, std::span<const double> v) {
  dynamics::Workspace& ws = closing_[0];
  dynamics::update_kinematics(m, q, v, ws);
  double energy = dynamics::kinetic_energy(m, ws);
  for (std::size_t k = 0; k < v.size(); ++k) energy += 0.5 * ws.armature[k] * v[k] * v[k];
  return energy;
}

bool InertialMotion::move(const Mechanism& m, dynamics::Workspace& ws, dynamics::ClosedLinks* closed, std::span<double> q,
                          std::span<double> v, double dt, double& gap) {
  std::ranges::copy(q, start_q_.begin());
  std::ranges::copy(v, start_v_.begin());
  const double substeps = std::clamp(std::ceil(turn(v, dt) / (closed == nullptr ? max_turn : max_turn_closed)), 1.0, max_substeps);
  const double h = dt / substeps, energy = closed != nullptr ? kinetic_energy(m, q, v) : 0;
  for (int k = 0; k < static_cast<int>(substeps); ++k)
    if (!(closed == nullptr ? step_open(m, ws, q, v, h) : step_closed(m, *closed, q, v, h, gap))) {
      std::ranges::copy(start_q_, q.begin());
      std::ranges::copy(start_v_, v.begin());
      return false;
    }
  if (closed == nullptr) return true;
  // Without forces the energy is constant. Near dead points the error of a substep is large; it must not add energy.
  if (const double end = kinetic_energy(m, q, v); end > energy)
    for (double& x : v) x *= std::sqrt(energy / end);
  return true;
}

}  // namespace ugoki::contact
