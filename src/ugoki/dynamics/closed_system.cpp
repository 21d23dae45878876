#include "ugoki/dynamics/closed_system.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/check.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::dynamics {
namespace {

std::vector<char> closed_loops(const ClosedLinks& links) {
  std::vector<char> closed;
  for (std::size_t i = 0; i < links.loops().size(); ++i) closed.push_back(links.is_closed(static_cast<int>(i)));
  return closed;
}

}  // namespace

ClosedSystem::ClosedSystem(MechanismPtr mechanism, const OpenSystemOptions& options)
    : OpenSystem(std::move(mechanism), options), links_(this->mechanism()), q_(static_cast<std::size_t>(this->mechanism().nq())) {
  for (std::vector<double>* x : {&v_, &a_, &guess_, &mean_}) x->resize(drive.size());
}

void ClosedSystem::rebuild(std::vector<Loop> loops, std::span<const char> closed, std::span<const char> rows) {
  links_ = ClosedLinks(mechanism(), std::move(loops), closed, rows);
}

int ClosedSystem::add_loop(Loop loop) {
  std::vector<char> closed = closed_loops(links_);
  std::vector<Loop> loops(links_.loops().begin(), links_.loops().end());
  loops.push_back(std::move(loop));
  closed.push_back(0);
  rebuild(std::move(loops), closed);
  return static_cast<int>(closed.size()) - 1;
}

ClosingReport ClosedSystem::close(int loop, std::span<double> q, std::span<double> v) {
  std::vector<char> closed = closed_loops(links_);
  UGOKI_CHECK(loop >= 0 && loop < static_cast<int>(closed.size()));
  closed[static_cast<std::size_t>(loop)] = 1;
  rebuild({links_.loops().begin(), links_.loops().end()}, closed);
  ClosingReport report;
  Workspace& ws = workspace();
  update_kinematics(mechanism(), q, v, ws);
  report.status = factor_closed_links(mechanism(), ws, links_, q, v);
  if (report.status != ClosedStatus::ok) return report;
  report.gap = max_gap(links_);
  double remaining_gap = 0;
  report.status = project_position(mechanism(), ws, links_, q, v, remaining_gap);
  if (report.status != ClosedStatus::ok) return report;
  const double before = calc_energy(q, v);
  project_velocity(mechanism(), ws, links_, v);
  report.energy_lost = before - calc_energy(q, v);
  return report;
}

int ClosedSystem::leave_out_redundant_rows(std::span<const double> q) {
  constexpr double redundant = 1e-9;  // pivot threshold, (3e-5 rad)^2: frames in model files are consistent to about six digits
  Workspace& ws = workspace();
  int maximum = -1;
  double min_pivot_ratio = 0;
  std::vector<char> rows;
  for (int sample = 0; sample < 6; ++sample) {
    std::ranges::copy(q, q_.begin());
    // Moves away from q along an irregular velocity that is projected so that no loop opens. The velocity comes from the golden-ratio
    // sequence, so it is the same in every call. Sample 0 is q itself.
    for (std::size_t i = 0; i < v_.size(); ++i)
      v_[i] = sample * std::fmod(0.6180339887 * static_cast<double>((i + 1) * (static_cast<std::size_t>(sample) + 1)), 1.0);
    update_kinematics(mechanism(), q_, v_, ws);
    if (factor_closed_links(mechanism(), ws, links_, q_, v_, redundant) != ClosedStatus::ok) return 0;
    project_velocity(mechanism(), ws, links_, v_);
    integrate(mechanism(), q_, v_, 0.03, q_);
    double gap = 0;
    (void)project_position(mechanism(), ws, links_, q_, v_, gap);
    if (factor_closed_links(mechanism(), ws, links_, q_, v_, redundant) != ClosedStatus::ok) return 0;
    if (links_.rank() < maximum || (links_.rank() == maximum && links_.min_pivot_ratio() <= min_pivot_ratio)) continue;
    maximum = links_.rank();
    min_pivot_ratio = links_.min_pivot_ratio();
    rows.assign(links_.independent().begin(), links_.independent().end());
  }
  int closed_rows = 0;
  for (std::size_t i = 0; i < links_.loops().size(); ++i)
    if (links_.is_closed(static_cast<int>(i))) closed_rows += links_.loops()[i].rows();
  if (maximum < closed_rows) rebuild({links_.loops().begin(), links_.loops().end()}, closed_loops(links_), rows);
  return closed_rows - maximum;
}

void ClosedSystem::open(int loop) {
  std::vector<char> closed = closed_loops(links_);
  UGOKI_CHECK(loop >= 0 && loop < static_cast<int>(closed.size()));
  closed[static_cast<std::size_t>(loop)] = 0;
  rebuild({links_.loops().begin(), links_.loops().end()}, closed);
}

int ClosedSystem::accelerate(double t, std::span<const double> q, std::span<const double> v, std::span<double> vdot) {
  calc_forces(t, q, v);
  if (calc_closed_forward_dynamics(mechanism(), links_, q, v, forces(), options().gravity, external, vdot) == ClosedStatus::ok) return -1;
  Workspace& ws = workspace();  // repeats the factorization with the staged functions, which find the singular DOF
  update_kinematics(mechanism(), q, v, ws);
  return factor_closed_links(mechanism(), ws, links_, q, v) == ClosedStatus::ok ? 0 : links_.singular_dof();
}

int ClosedSystem::calc_acceleration(double t, std::span<const double> q, std::span<const double> v, std::span<double> vdot) {
  const int singular = accelerate(t, q, v, vdot);
  if (singular >= 0) return singular;
  if (!links_.is_nearly_singular()) return -1;
  if (interpolate_acceleration(t, q, v, mean_)) std::ranges::copy(mean_, vdot.begin());
  return -1;
}

bool ClosedSystem::interpolate_acceleration(double t, std::span<const double> q, std::span<const double> v, std::span<double> vdot) {
  double speed = 0;
  for (const double x : v) speed = std::max(speed, std::fabs(x));
  if (!(speed > 1e-6)) return false;  // rad/s | m/s: at rest there is no motion to follow
  const double dt = 0.01 / speed;     // s: the fastest DOF moves by 0.01 rad | m
  std::ranges::fill(guess_, 0.0);
  // Richardson extrapolation: the mean of the accelerations at +dt and -dt has an error that is even in dt, so samples at dt and 2 dt
  // cancel the dt^2 term. Each pass predicts the neighbouring states with the acceleration that the previous pass found.
  for (int pass = 0; pass < 3; ++pass) {
    std::ranges::fill(vdot, 0.0);
    for (const double side : {-1.0, 1.0})
      if (!add_acceleration_near(t, side * dt, q, v, 4.0 / 6, vdot) || !add_acceleration_near(t, 2 * side * dt, q, v, -1.0 / 6, vdot))
        return false;
    std::ranges::copy(vdot, guess_.begin());
  }
  return true;
}

bool ClosedSystem::add_acceleration_near(double t, double dt, std::span<const double> q, std::span<const double> v, double weight,
                                         std::span<double> sum) {
  for (std::size_t i = 0; i < v.size(); ++i) a_[i] = v[i] + 0.5 * dt * guess_[i];
  integrate(mechanism(), q, a_, dt, q_);
  for (std::size_t i = 0; i < v.size(); ++i) v_[i] = v[i] + dt * guess_[i];
  double gap = 0;
  if (project_position(mechanism(), workspace(), links_, q_, v_, gap) != ClosedStatus::ok) return false;
  project_velocity(mechanism(), workspace(), links_, v_);
  if (accelerate(t + dt, q_, v_, a_) >= 0) return false;
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += weight * a_[i];
  return true;
}

Projection ClosedSystem::project(double /*t*/, std::span<double> q, std::span<double> v) {
  double gap = 0;
  Workspace& ws = workspace();
  if (project_position(mechanism(), ws, links_, q, v, gap) != ClosedStatus::ok) return Projection::failed;
  project_velocity(mechanism(), ws, links_, v);
  return Projection::moved;
}

}  // namespace ugoki::dynamics
