// A step without impulses: inertia, its factor, the inertial forces, and what turns too fast for one step.

#include <algorithm>
#include <cmath>

#include "ugoki/contact/stepper.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::contact {
namespace {

constexpr double slow = 1e-3;        // rad | m in a step: what moves less needs no second look at its bias
constexpr double enough = 0.01;      // change of the velocities from one look at the bias to the next, relative
constexpr double most_change = 0.3;  // more of it, and there is no end to it
constexpr double most_turn = 0.02;   // rad in a step: linked bodies that turn faster coast in parts of a step,
constexpr double most_parts = 20;    // no more of them

/// What a free body's bias moment has to change by, so that the step takes it at the mean of old and new angular velocity:
///   I (w' - w) = -dt wm x I wm,  wm = (w + w') / 2
/// keeps the energy and the size of the angular momentum of a spinning body exactly, where the moment at w would spin it up. A body that
/// turns by radians in a step, for which that may have no solution nearby, keeps its angular velocity.
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

/// What a free body's bias has to change by where it turns by more than half a radian in a step and its frame is not at its centre: the
/// force that carries the frame round the centre is then taken as its mean over the step, or the frame would fly off along its tangent.
/// @return moment and force in the body's axes
Vec6 centripetal_correction(const Inertia& body, const Vec3& w, double dt) {
  if (!(dt * norm(w) > 0.5) || !(body.mass > 0)) return {};
  const Vec3 c = body.h / body.mass, turned = to_matrix(exp_map(w * dt)) * c;
  const Vec3 force = cross(w, turned - c) * (body.mass / dt) - cross(w, cross(w, body.h));
  return {cross(c, force), force};
}

}  // namespace

/// rad: the greatest turn about a joint, or of a free base, in dt.
double Stepper::turn(std::size_t s, std::span<const double> v, double dt) const {
  double most = 0;
  for (const std::size_t f : scratch_[s].turning) most = std::max(most, std::fabs(v[f]) * dt);
  return most;
}

/// Inertia, its factor, and the velocity without impulses.
void Stepper::prepare(std::size_t s, const StepSystem& system, double dt, StepReport& report) {
  const Mechanism& m = *mechanisms_[s];
  dynamics::Workspace& ws = workspaces_[s];
  SystemScratch& x = scratch_[s];
  const std::size_t n = x.free_v.size();
  if (n == 0) return;
  if (x.loops) dynamics::share_virtual_inertias(x.loops->links, ws);
  dynamics::calc_inertia_rows(m, ws);
  const bool servo = !system.servo_gain.empty();
  for (std::size_t i = 0; i < n && !coasting_; ++i) {
    x.extra[i] = dt * (ws.freedoms[i].damping + dt * ws.freedoms[i].stiffness);
    if (servo) x.extra[i] += dt * system.servo_gain[i];
  }
  if (const int bad = dynamics::factor(ws, x.extra); bad >= 0) {
    report.status = StepStatus::singular;
    report.system = static_cast<int>(s);
    report.freedom = bad;
    return;
  }
  for (std::size_t i = 0; i < n; ++i) x.root_D_inverse[i] = std::sqrt(ws.D_inverse[i]);
  if (!coasting_ && (x.springs || !x.limited.empty()))
    for (const Link& link : m.links()) joint_displacement(link.joint, system.q.data() + link.q_index, x.displacement.data() + link.v_index);
  const bool linked = !x.free_body && n > 1;
  x.coasts = linked && !coasting_ && turn(s, x.v, dt) > most_turn;
  const auto move = [&](std::span<const double> v) {
    dynamics::calc_inverse_dynamics(m, ws, system.q, v, {}, options_.gravity, system.external, x.free_v);
    move_freely(s, system, dt);
  };
  if (x.coasts) return move(x.none);  // the inertial forces come with coast()
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
  // Linked bodies: the bias at the mean of old and new velocities. Taken at the old ones it adds energy in every step, and chains that
  // nothing damps whirl ever faster.
  double change = 0;
  for (int round = 0; round < 2; ++round) {
    double fastest = 0;
    for (std::size_t i = 0; i < n; ++i) fastest = std::max({fastest, std::fabs(x.v[i]), std::fabs(x.free_v[i])});
    if (fastest * dt < slow) return;
    x.unforced = x.free_v;  // of the look before; what stays in it is set after this
    for (std::size_t i = 0; i < n; ++i) x.mean[i] = 0.5 * (x.v[i] + x.free_v[i]);
    move(x.mean);
    double changed = 0, size = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double d = x.free_v[i] - x.unforced[i];
      changed += d * d / ws.D_inverse[i];
      size += (x.v[i] * x.v[i] + x.free_v[i] * x.free_v[i]) / ws.D_inverse[i];
    }
    change = changed / size;
    if (change < enough * enough) return;
  }
  if (!(change < most_change * most_change)) move(x.none);  // too fast: the joints keep their velocities
}

/// free_v: from the bias to the velocity without impulses.
void Stepper::move_freely(std::size_t s, const StepSystem& system, double dt) {
  const dynamics::Workspace& ws = workspaces_[s];
  SystemScratch& x = scratch_[s];
  const bool servo = !system.servo_gain.empty();
  for (std::size_t i = 0; i < x.v.size(); ++i) {
    const Freedom& f = ws.freedoms[i];
    double passive = 0;
    if (!coasting_) passive += f.damping * x.v[i];
    if (!coasting_ && f.stiffness > 0) passive += f.stiffness * (x.displacement[i] - f.rest + dt * x.v[i]);
    if (servo) passive += system.servo_gain[i] * (x.v[i] - system.servo_velocity[i]);
    x.free_v[i] = dt * (system.tau[i] - x.free_v[i] - passive);
  }
  dynamics::solve(ws, x.free_v);
  for (std::size_t i = 0; i < x.v.size(); ++i) x.free_v[i] += x.v[i];
  if (x.loops) solve_loops(s, system, dt);
}

/// Linked bodies that turn by much in a step: all forces have acted, and what is left of the step they move by inertia alone, in
/// smaller steps. @return false where one step will do
bool Stepper::coast(std::size_t s, StepSystem& system, double dt, StepReport& report) {
  SystemScratch& x = scratch_[s];
  const double turned = turn(s, system.v, dt);
  if (coasting_ || x.free_body || x.v.size() < 2 || !(x.coasts || turned > most_turn)) return false;
  if (!x.inertial) {
    StepperOptions options = options_;
    options.gravity = {};
    x.inertial = std::make_unique<Stepper>(std::vector<MechanismPtr>{mechanisms_[s]}, options);
    x.inertial->coasting_ = true;
  }
  const double parts = std::clamp(std::ceil(turned / most_turn), 1.0, most_parts);
  std::ranges::copy(system.q, x.start_q.begin());
  StepSystem alone{system.q, system.v, x.none, {}, {}, {}};
  for (int k = 0; k < static_cast<int>(parts); ++k) {
    const StepReport part = x.inertial->step(std::span(&alone, 1), {}, dt / parts);
    if (part.status != StepStatus::ok) {  // straight on instead: what is wrong will be told by the next step
      std::ranges::copy(x.start_q, system.q.begin());
      std::ranges::copy(x.free_v, system.v.begin());
      return false;
    }
    report.loop_gap = std::max(report.loop_gap, part.loop_gap);
  }
  return true;
}

}  // namespace ugoki::contact
