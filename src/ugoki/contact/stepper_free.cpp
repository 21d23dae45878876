// Motion without contact impulses: the inertia and its factor, and velocity-dependent bias forces.

#include <algorithm>
#include <cmath>

#include "ugoki/contact/stepper.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::contact {
namespace {

constexpr double min_motion = 1e-3;        // rad | m in a step: below this motion the bias force is not iterated
constexpr double max_bias_change = 0.01;   // relative change of the velocities at which the iteration of the bias force has converged
constexpr double divergence_change = 0.3;  // relative change at or above which the iteration of the bias force diverges

/// Correction [N m, body axes] of a free body's gyroscopic moment, so that the moment is evaluated at the mean angular velocity wm:
///   I (w' - w) = -dt wm x I wm,  wm = (w + w') / 2   (I: inertia; w, w': angular velocity before and after the step)
/// This midpoint rule conserves the kinetic energy and the magnitude of the angular momentum; the moment at w would increase the two.
/// For a body that turns by radians in a step the equation may have no solution near w; such a body keeps its angular velocity.
Vec3 gyroscopic_correction(const Sym3& I, const Vec3& w, double dt) {
  const Mat3 M = I.matrix();
  Vec3 next = w;
  for (int k = 0; k < 5; ++k) {  // Newton's method
    const Vec3 mean = (w + next) * 0.5, momentum = M * mean;
    const Vec3 rest = M * (next - w) + cross(mean, momentum) * dt;
    if (!(dot(rest, rest) > 1e-30 * dot(momentum, momentum))) break;
    next = next - inverse(M + (Mat3::skew(mean) * M - Mat3::skew(momentum)) * (0.5 * dt)) * rest;
  }
  const Vec3 mean = (w + next) * 0.5, moment = cross(mean, M * mean), rest = M * (next - w) + moment * dt;
  const bool solved = norm(rest) <= 1e-6 * norm(M * w);  // false for NaN
  return (solved ? moment : Vec3{}) - cross(w, M * w);
}

/// Correction of the bias force of a free body whose frame is not at its centre of mass. Zero below half a radian of rotation in a step.
/// The centripetal force that turns the frame about the centre of mass is replaced by its mean over the step; the force at the beginning
/// of the step would let the frame leave its circle along the tangent.
/// @return moment [N m] and force [N], body axes
Vec6 centripetal_correction(const Inertia& body, const Vec3& w, double dt) {
  if (!(dt * norm(w) > 0.5) || !(body.mass > 0)) return {};
  const Vec3 c = body.h / body.mass, turned = to_matrix(exp_map(w * dt)) * c;
  const Vec3 force = cross(w, turned - c) * (body.mass / dt) - cross(w, cross(w, body.h));
  return {cross(c, force), force};
}

}  // namespace

/// Calculates the inertia, its factor, and the velocity without impulses.
void Stepper::prepare(std::size_t s, const StepSystem& system, double dt) {
  const Mechanism& m = *mechanisms_[s];
  dynamics::Workspace& ws = workspaces_[s];
  SystemScratch& x = scratch_[s];
  const std::size_t n = x.free_v.size();
  if (n == 0) return;
  if (x.loops) {
    dynamics::share_virtual_inertias(x.loops->links, ws);
    x.loops->has_basis = false;
  }
  const bool servo = !system.servo_gain.empty();
  for (std::size_t i = 0; i < n; ++i) {
    x.extra[i] = dt * (ws.dofs[i].damping + dt * ws.dofs[i].stiffness);
    if (servo) x.extra[i] += dt * system.servo_gain[i];
  }
  x.singular_dof = x.factor.factor(ws, x.extra);
  if (x.singular_dof < 0 && x.by_tree) x.singular_dof = x.tree->begin(m, ws, system.q, x.v, x.factor, x.extra, options_.recovery_speed, dt);
  if (x.singular_dof >= 0) return;
  x.has_free_motion = false;
  for (const int i : x.displaced_links) {
    const Link& link = m.link(i);
    joint_displacement(link.joint, system.q.data() + link.q_index, x.displacement.data() + link.v_index);
  }
  const bool linked = !x.free_body && n > 1;
  const auto move = [&](std::span<const double> v) {
    dynamics::calc_bias_forces(m, ws, system.q, v, options_.gravity, system.external, x.free_v);
    move_freely(s, system, dt);
  };
  if (x.is_inertial) return move(x.zeros);  // bias at zero velocity; InertialMotion adds the inertial forces
  dynamics::calc_inverse_dynamics(m, ws, {}, options_.gravity, system.external, x.free_v);
  if (x.free_body) {
    const Vec3 w{x.v[0], x.v[1], x.v[2]};
    const Link& link = m.link(0);
    const Vec6 carried = centripetal_correction(link.inertia, w, dt);
    const Vec3 moment = gyroscopic_correction(link.inertia.about_centre(), w, dt) + carried.w;
    const Vec3 force = transpose_times(link.joint.X_PJ.R, ws.X_WB[0].R * carried.v);
    for (std::size_t k = 0; k < 3; ++k) {
      x.free_v[k] += moment[static_cast<int>(k)];
      x.free_v[k + 3] += force[static_cast<int>(k)];
    }
  }
  move_freely(s, system, dt);
  if (!linked) return;
  // Linked bodies: iterate until the bias is evaluated at the mean of the old and new velocities. Evaluated at the old velocities,
  // the bias adds energy in every step, and undamped chains spin ever faster.
  double change = 0;
  for (int iteration = 0; iteration < 2; ++iteration) {
    double fastest = 0;
    for (std::size_t i = 0; i < n; ++i) fastest = std::max({fastest, std::fabs(x.v[i]), std::fabs(x.free_v[i])});
    if (fastest * dt < min_motion) return;
    x.unforced = x.free_v;  // temporary use: velocities of the previous iteration; step() sets `unforced` afterwards
    for (std::size_t i = 0; i < n; ++i) x.mean[i] = 0.5 * (x.v[i] + x.free_v[i]);
    move(x.mean);
    double changed = 0, size = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double d = x.free_v[i] - x.unforced[i];
      changed += d * d * x.factor.pivot(i);
      size += (x.v[i] * x.v[i] + x.free_v[i] * x.free_v[i]) * x.factor.pivot(i);
    }
    change = changed / size;
    if (change < max_bias_change * max_bias_change) return;
  }
  if (!(change < divergence_change * divergence_change))
    move(x.zeros);  // no convergence: omit the velocity-dependent bias, so that the joints keep their velocities
}

/// Replaces the bias force in free_v by the velocity without impulses.
void Stepper::move_freely(std::size_t s, const StepSystem& system, double dt) {
  dynamics::Workspace& ws = workspaces_[s];
  SystemScratch& x = scratch_[s];
  const bool servo = !system.servo_gain.empty();
  for (std::size_t i = 0; i < x.v.size(); ++i) {
    const Dof& f = ws.dofs[i];
    double passive = f.damping * x.v[i];
    if (f.stiffness > 0) passive += f.stiffness * (x.displacement[i] - f.rest + dt * x.v[i]);
    if (servo) passive += system.servo_gain[i] * (x.v[i] - system.servo_velocity[i]);
    x.free_v[i] = dt * (system.tau[i] - x.free_v[i] - passive);
  }
  if (x.by_tree) return x.tree->move(*mechanisms_[s], ws, x.v, x.free_v);
  x.factor.solve(x.free_v);
  for (std::size_t i = 0; i < x.v.size(); ++i) x.free_v[i] += x.v[i];
  if (x.loops) solve_loops(s, system, dt);
}

}  // namespace ugoki::contact
