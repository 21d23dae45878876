#include "ugoki/dynamics/closed_system.h"

#include <algorithm>

#include "ugoki/base/check.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::dynamics {
namespace {

std::vector<char> closed_loops(const ClosedLinks& links) {
  std::vector<char> closed;
  for (std::size_t i = 0; i < links.loops().size(); ++i) closed.push_back(links.is_closed(static_cast<int>(i)));
  return closed;
}

}  // namespace

ClosedSystem::ClosedSystem(MechanismPtr mechanism, const OpenSystemOptions& options)
    : OpenSystem(std::move(mechanism), options), links_(this->mechanism()) {}

void ClosedSystem::rebuild(std::vector<Loop> loops, std::span<const char> closed) {
  links_ = ClosedLinks(mechanism(), std::move(loops), closed);
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
  report.gap = greatest_gap(links_);
  double left = 0;
  report.status = project_position(mechanism(), ws, links_, q, v, left);
  if (report.status != ClosedStatus::ok) return report;
  const double before = calc_energy(q, v);
  project_velocity(mechanism(), ws, links_, v);
  report.energy_lost = before - calc_energy(q, v);
  return report;
}

void ClosedSystem::open(int loop) {
  std::vector<char> closed = closed_loops(links_);
  UGOKI_CHECK(loop >= 0 && loop < static_cast<int>(closed.size()));
  closed[static_cast<std::size_t>(loop)] = 0;
  rebuild({links_.loops().begin(), links_.loops().end()}, closed);
}

int ClosedSystem::calc_acceleration(double t, std::span<const double> q, std::span<const double> v, std::span<double> vdot) {
  calc_forces(t, q, v);
  if (calc_closed_forward_dynamics(mechanism(), links_, q, v, forces(), options().gravity, external, vdot) == ClosedStatus::ok) return -1;
  Workspace& ws = workspace();  // which freedom it is
  update_kinematics(mechanism(), q, v, ws);
  return factor_closed_links(mechanism(), ws, links_, q, v) == ClosedStatus::ok ? 0 : links_.singular_freedom();
}

Projection ClosedSystem::project(double /*t*/, std::span<double> q, std::span<double> v) {
  double gap = 0;
  Workspace& ws = workspace();
  if (project_position(mechanism(), ws, links_, q, v, gap) != ClosedStatus::ok) return Projection::failed;
  project_velocity(mechanism(), ws, links_, v);
  return Projection::moved;
}

}  // namespace ugoki::dynamics
