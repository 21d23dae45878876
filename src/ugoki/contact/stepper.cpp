#include "ugoki/contact/stepper.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ugoki/base/check.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::contact {
namespace {

// m: tolerated position error of one step in a large heap; SolverOptions::coarse is this distance / dt.
constexpr double coarse_distance = 1e-4;
// DOFs of an open system, and of a system with loops, above which TreeIsland does not hand the system over, because the cost of whitened
// rows grows with the cube.
constexpr std::size_t max_handed_over = 512, max_closed_handed_over = 256;
// Newton steps of TreeIsland before it hands an open system over. Bodies that land slide fast; whitened rows then need few sweeps, and
// TreeIsland many steps. Bodies at rest need no step. The limit grows with the cost of whitened rows (TreeIsland::min_work), so that a
// system which has come to rest returns to TreeIsland. Measured with chains of 50 to 300 links that fall (docs/design/contact.md).
constexpr int min_steps_before_hand_over = 8;
constexpr double work_of_step = 60;  // work of whitened rows for each DOF that costs as much as one Newton step
// Maximum speed of a link that the recovery from deep overlaps may cause, relative to the recovery speed. Tests: overlap_test.cpp.
constexpr double max_speed_ratio = 3;

/// m: radius of a body whose only colliding shape is round, so that it can roll; 0 for every other body.
double rolling_radius(const Link& link) {
  double radius = 0;
  for (const Shape& s : link.shapes) {
    if (!s.collides) continue;
    if (radius > 0) return 0;
    switch (s.type) {
      case ShapeType::sphere:
      case ShapeType::capsule:
      case ShapeType::cylinder: radius = s.radius; break;
      case ShapeType::ellipsoid: radius = std::min({s.half_extents.x, s.half_extents.y, s.half_extents.z}); break;
      default: return 0;
    }
  }
  return radius;
}

}  // namespace

void StepReport::add(const StepReport& next) {
  if (status == StepStatus::ok) {
    status = next.status;
    system = next.system;
    dof = next.dof;
  }
  sweeps = std::max(sweeps, next.sweeps);
  residual = std::max(residual, next.residual);
  loop_gap = std::max(loop_gap, next.loop_gap);
  newton_steps += next.newton_steps;
  handed_over += next.handed_over;
  islands = next.islands;
  contacts = next.contacts;
  limits = next.limits;
  impacts += next.impacts;
  not_converged += next.not_converged;
  failed_motions += next.failed_motions;
  unfinished_impacts += next.unfinished_impacts;
  open_loops += next.open_loops;
  stops += next.stops;
  left_overlaps += next.left_overlaps;
}

Stepper::Stepper(std::vector<MechanismPtr> systems, const StepperOptions& options) : mechanisms_(std::move(systems)), options_(options) {
  workspaces_.reserve(mechanisms_.size());
  scratch_.reserve(mechanisms_.size());
  factor_scratch_.resize(1);
  std::vector<int> first = {0};
  for (std::size_t s = 0; s < mechanisms_.size(); ++s) {
    const Mechanism& m = *mechanisms_[s];
    const dynamics::Workspace& ws = workspaces_.emplace_back(m);
    const auto n = static_cast<std::size_t>(m.nv());
    first.push_back(first.back() + m.nv());
    SystemScratch& x = scratch_.emplace_back(m);
    for (std::vector<double>* array : {&x.v, &x.extra, &x.free_v, &x.unforced, &x.mean, &x.displacement}) array->resize(n);
    x.zeros.assign(n, 0.0);
    x.next_q.resize(static_cast<std::size_t>(m.nq()));
    x.next_X.resize(static_cast<std::size_t>(m.link_count()));
    x.free_motion.resize(n);
    for (int i = 0; i < m.link_count(); ++i) {
      const Joint& joint = m.link(i).joint;
      bool limited = false, sprung = false;
      for (int k = 0; k < joint.nv(); ++k) {
        const Dof& f = joint.dofs[static_cast<std::size_t>(k)];
        if (joint.type != JointType::floating) limited = limited || std::isfinite(f.lower) || std::isfinite(f.upper);
        sprung = sprung || f.stiffness > 0;
        if (f.friction > 0) x.dry_friction_dofs.push_back(m.link(i).v_index + k);
      }
      if (limited) x.limited_links.push_back(i);
      if (limited || sprung) x.displaced_links.push_back(i);
    }
    x.free_body = m.link_count() == 1 && m.link(0).joint.type == JointType::floating;
    if (!x.free_body && n > 1) x.inertial = std::make_unique<InertialMotion>(m);
    x.rolling_radius = x.free_body ? rolling_radius(m.link(0)) : 0;
    if (std::ranges::any_of(m.loops(), &Loop::closed)) {
      x.loops = std::make_unique<SystemScratch::Loops>(m);
    }
    if (m.nv() >= options_.min_tree_dofs && TreeIsland::can_treat(m)) {
      x.tree = std::make_unique<TreeIsland>(m);
      x.can_hand_over = n <= (x.loops ? max_closed_handed_over : max_handed_over);
    }
    if (x.loops && !x.tree) x.loops->make_room_for_basis(n);
    x.factor.make_room(factor_scratch_[0]);
    for (std::size_t k = 0; k < n; ++k) x.contiguous_chain.push_back(ws.depth[k] == static_cast<int>(k) ? 1 : 0);
  }
  solver_.set_systems(first);
  const std::size_t room = 64 + 12 * scratch_.size() + 2 * static_cast<std::size_t>(first.back());
  impact_impulses_.reserve(2 * room);
  forces_.reserve(2 * room);
  frames_.reserve(6 * room);
  constexpr std::size_t usual_grips = 32;
  grips_.reserve(usual_grips);
  grip_forces_.reserve(usual_grips);
  warm_.reserve(room);
}

void Stepper::set_executor(Executor* executor) {
  std::size_t dofs = 0;
  for (const MechanismPtr& m : mechanisms_) dofs += static_cast<std::size_t>(m->nv());
  executor_ = dofs >= min_parallel_dofs ? executor : nullptr;
  factor_scratch_.resize(executor_ ? static_cast<std::size_t>(executor_->workers()) : 1, factor_scratch_[0]);
  for (SystemScratch& x : scratch_) x.factor.use(factor_scratch_[0]);
  solver_.set_executor(executor_);
}

/// Chooses for each system how its rows are solved: by TreeIsland or by whitened rows (velocity_solver.h).
void Stepper::choose_methods(std::span<const collision::ContactPoint> contacts) {
  for (SystemScratch& x : scratch_) x.by_tree = x.tree && !x.gripped;
  std::vector<double>& work = tree_work_;
  work.assign(scratch_.size(), 0.0);
  for (const collision::ContactPoint& c : contacts) {
    const bool moves_a = is_movable(c.system_a, c.link_a), moves_b = is_movable(c.system_b, c.link_b);
    if (moves_a && moves_b)
      for (const int s : {c.system_a, c.system_b}) scratch_[static_cast<std::size_t>(s)].by_tree = false;
    else if (moves_a || moves_b) {
      const int s = moves_a ? c.system_a : c.system_b, link = moves_a ? c.link_a : c.link_b;
      const dynamics::Workspace& ws = workspaces_[static_cast<std::size_t>(s)];
      const double length = ws.depth[static_cast<std::size_t>(ws.link_chain[static_cast<std::size_t>(link)])] + 1;
      work[static_cast<std::size_t>(s)] += length * length;
    }
  }
  for (std::size_t s = 0; s < scratch_.size(); ++s) {
    SystemScratch& x = scratch_[s];
    if (!x.loops && work[s] < options_.min_tree_work * static_cast<double>(x.v.size())) x.by_tree = false;
    if (!x.by_tree && !x.v.empty() && workspaces_[s].chain.empty()) workspaces_[s].make_rows(*mechanisms_[s]);
  }
}

/// Maximum speed of the links' origins at the velocity v, in m/s; infinite if v is not finite. Overwrites free_motion.
double Stepper::max_speed(std::size_t s, std::span<const double> v) {
  SystemScratch& x = scratch_[s];
  const dynamics::Workspace& ws = workspaces_[s];
  move_links(s, v);
  x.has_free_motion = false;
  double largest = 0;
  for (std::size_t i = 0; i < ws.link_chain.size(); ++i) {
    if (ws.link_chain[i] < 0) continue;
    const Vec6& V = x.free_motion[static_cast<std::size_t>(ws.link_chain[i])];
    const double speed = norm(V.v + cross(V.w, ws.X_WB[i].p - ws.p0));
    if (!std::isfinite(speed)) return HUGE_VAL;
    largest = std::max(largest, speed);
  }
  return largest;
}

/// Reduces `recovery_` if the impulses of a step make a link of a system with deep overlaps too fast. In some configurations of deep
/// overlaps and joint limits, a small recovery requires high speeds of other links. For systems at rest these are proportional to it.
/// @return whether recovery_ has changed
bool Stepper::reduce_recovery() {
  if (recovery_ == 0) return false;
  const double limit = max_speed_ratio * options_.recovery_speed;
  double factor = 1;
  for (std::size_t s = 0; s < scratch_.size(); ++s) {
    SystemScratch& x = scratch_[s];
    if (!x.deep || x.v.empty()) continue;
    const double after = max_speed(s, x.free_v);
    if (after <= limit) continue;
    const double before = max_speed(s, x.unforced);
    if (after <= before) continue;
    factor = before < limit && std::isfinite(after) ? std::min(factor, 0.9 * limit / after) : 0.0;
  }
  if (factor == 1) return false;
  recovery_ = recovery_ * factor > 1e-3 ? recovery_ * factor : 0;
  return true;
}

/// Newton steps after which TreeIsland hands the system over to the velocity solver.
int Stepper::steps_before_hand_over(std::size_t s) const {
  const SystemScratch& x = scratch_[s];
  if (!x.can_hand_over || x.loops) return std::numeric_limits<int>::max();
  return std::max(min_steps_before_hand_over, static_cast<int>(tree_work_[s] / (work_of_step * static_cast<double>(x.v.size()))));
}

/// Lets the velocity solver solve the systems that TreeIsland did not finish, if they are small. @return whether there are any
bool Stepper::hand_over() {
  bool any = false;
  for (std::size_t s = 0; s < scratch_.size(); ++s) {
    SystemScratch& x = scratch_[s];
    if (!x.by_tree || x.tree_report.not_converged == 0 || !x.can_hand_over) continue;
    x.by_tree = false;
    any = true;
    ++handed_over_;
    if (workspaces_[s].chain.empty()) workspaces_[s].make_rows(*mechanisms_[s]);
  }
  return any;
}

bool Stepper::is_movable(int system, int link) const {
  return system >= 0 && workspaces_[static_cast<std::size_t>(system)].link_chain[static_cast<std::size_t>(link)] >= 0;
}

bool Stepper::can_add(const collision::ContactPoint& c) const {
  if (!is_movable(c.system_a, c.link_a) || !is_movable(c.system_b, c.link_b)) return true;
  return !scratch_[static_cast<std::size_t>(c.system_a)].by_tree && !scratch_[static_cast<std::size_t>(c.system_b)].by_tree;
}

/// Solves the rows of all systems, or after repeat() those of islands with new blocks, and adds the velocity changes to free_v.
SolverReport Stepper::solve_rows(const SolverOptions& options, std::size_t first_new, bool again) {
  SolverReport report = again ? solver_.solve_again(options, first_new) : solver_.solve(options);
  const bool rows = !solver_.blocks().empty();
  for_each_system([&](std::size_t s) {
    SystemScratch& x = scratch_[s];
    if (!x.by_tree) {
      if (rows) x.factor.add_whitened(solver_.w(static_cast<int>(s)), x.free_v);
      return;
    }
    x.tree_solved = !again || x.tree->blocks().size() > x.tree_blocks;
    x.tree_blocks = x.tree->blocks().size();
    if (x.tree_solved) {
      x.tree_report = {};
      const int max_steps = again ? std::numeric_limits<int>::max() : steps_before_hand_over(s);
      x.tree->solve(*mechanisms_[s], workspaces_[s], options, max_steps, x.tree_report);
    }
    if (x.tree->blocks().empty()) x.tree_report = {};
    const std::span<const double> change = x.tree->change();
    for (std::size_t i = 0; i < change.size(); ++i) x.free_v[i] += change[i];
  });
  for (const SystemScratch& x : scratch_) {
    if (!x.by_tree) continue;
    report.not_converged += x.tree_report.not_converged;
    if (!x.tree_solved) continue;
    report.islands += x.tree_report.islands;
    report.sweeps = std::max(report.sweeps, x.tree_report.sweeps);
    report.newton_steps += x.tree_report.newton_steps;
    report.residual = std::max(report.residual, x.tree_report.residual);
  }
  return report;
}

/// Computes collisions with restitution and changes the velocities by eqs. (18) (19) of the paper.
void Stepper::find_impacts(std::span<StepSystem> systems, std::span<const collision::ContactPoint> contacts, double dt,
                           StepReport& report) {
  impact_impulses_.assign(contacts.size(), 0.0);
  const auto hits = [&](const collision::ContactPoint& c) {
    if (!(c.restitution > 0)) return false;
    double u = 0;
    if (c.system_a >= 0) u += dot(c.n, dynamics::point_velocity(workspaces_[static_cast<std::size_t>(c.system_a)], c.link_a, c.p));
    if (c.system_b >= 0) u -= dot(c.n, dynamics::point_velocity(workspaces_[static_cast<std::size_t>(c.system_b)], c.link_b, c.p));
    return u < -options_.impact_speed && c.distance + dt * u <= 0;
  };
  if (!std::ranges::any_of(contacts, hits)) return;
  impact_systems_.resize(systems.size());
  for (std::size_t s = 0; s < systems.size(); ++s) {
    SystemScratch& x = scratch_[s];
    impact_systems_[s] = {mechanisms_[s].get(), &workspaces_[s], x.loops ? &x.loops->links : nullptr, systems[s].q, x.v};
  }
  const ImpactReport impact = impact_.collide(impact_systems_, contacts, {options_.impact_speed, dt, false});
  report.impacts = impact.collisions;
  report.unfinished_impacts = impact.status == ImpactStatus::unfinished ? 1 : 0;
  if (impact.status == ImpactStatus::singular) {
    report.status = StepStatus::singular;
    report.system = impact.system;
    report.dof = 0;
    return;
  }
  std::ranges::copy(impact_.impulses(), impact_impulses_.begin());
  // The velocities have changed, and collide() may have distributed the inertias of virtual links.
  for (std::size_t s = 0; s < systems.size(); ++s)
    dynamics::update_kinematics(*mechanisms_[s], systems[s].q, scratch_[s].v, workspaces_[s]);
}

/// Returns the options of the velocity solver. @param careful true for more sweeps and a tighter coarse tolerance (repeated steps)
SolverOptions Stepper::solver_options(double dt, bool careful) const {
  const double coarse = (careful ? 0.3 : 1.0) * coarse_distance / dt;
  return {(careful ? 4 : 1) * options_.iterations, options_.tolerance, coarse, options_.softness, max_dense_rows_};
}

StepReport Stepper::step(std::span<StepSystem> systems, std::span<const collision::ContactPoint> contacts, double dt, std::size_t forced) {
  return step(systems, contacts, dt, forced, 1);
}

/// @param recovery first value of recovery_
StepReport Stepper::step(std::span<StepSystem> systems, std::span<const collision::ContactPoint> contacts, double dt, std::size_t forced,
                         double recovery) {
  UGOKI_CHECK(systems.size() == mechanisms_.size() && dt > 0);
  StepReport report;
  frames_.resize(3 * contacts.size());
  choose_methods(contacts);
  find_separations(contacts);
  handed_over_ = 0;
  recovery_ = recovery;
  forced_ = std::min(forced, contacts.size());
  for (SystemScratch& x : scratch_) x.deep = false;
  const auto prepare_and_keep = [&](std::size_t s) {
    prepare(s, systems[s], dt);
    scratch_[s].unforced = scratch_[s].free_v;
  };
  // Without impacts each system is prepared at once, while its kinematics are in the processor's cache.
  bool prepared = std::ranges::none_of(contacts, [](const collision::ContactPoint& c) { return c.restitution > 0; });
  for_each_system([&](std::size_t s) {
    std::ranges::copy(systems[s].v, scratch_[s].v.begin());
    scratch_[s].is_inertial =
        scratch_[s].inertial && !scratch_[s].gripped && scratch_[s].inertial->turn(systems[s].v, dt) > InertialMotion::threshold;
    dynamics::update_kinematics(*mechanisms_[s], systems[s].q, scratch_[s].v, systems[s].known, workspaces_[s]);
    if (prepared) prepare_and_keep(s);
  });
  find_impacts(systems, contacts, dt, report);
  SolverReport solved;
  for (bool solve = true; solve && report.status == StepStatus::ok;) {
    solver_.clear();
    report.limits = 0;
    if (!prepared) for_each_system(prepare_and_keep);
    prepared = false;  // a second solution prepares the systems again
    for (std::size_t s = systems.size(); s-- > 0;) {
      if (scratch_[s].singular_dof < 0) continue;
      report.status = StepStatus::singular;
      report.system = static_cast<int>(s);
      report.dof = scratch_[s].singular_dof;
    }
    if (report.status != StepStatus::ok) break;
    for (std::size_t i = 0; i < contacts.size(); ++i) add_contact(static_cast<int>(i), contacts[i], dt, i >= forced);
    if (!grips_.empty()) predict_grips(systems, dt);
    for (const Grip& g : grips_) add_grip(g, dt);
    for (std::size_t s = 0; s < systems.size(); ++s) report.limits += add_joint_rows(s, dt);
    solved = solve_rows(solver_options(dt, forced < contacts.size()), 0, false);
    // An open system that becomes fast in this step is solved again, with its velocity-dependent forces left to InertialMotion. A closed
    // one is not: with a second solution the energy of a falling cassie_v2 rises by its weight times 2 m (FallingRobots tests).
    solve = hand_over();
    for (SystemScratch& x : scratch_)
      if (x.inertial && !x.loops && !x.gripped && !x.is_inertial && x.inertial->turn(x.free_v, dt) > InertialMotion::threshold)
        solve = x.is_inertial = true;
    if (reduce_recovery()) solve = true;
  }
  if (report.status != StepStatus::ok) {
    forces_.assign(contacts.size(), Vec3{});
    return report;
  }
  first_report_ = report;
  return finish(systems, contacts, dt, solved, report);
}

StepReport Stepper::repeat(std::span<StepSystem> systems, std::span<const collision::ContactPoint> contacts, double dt) {
  const std::size_t given = impact_impulses_.size(), first = solver_.blocks().size();
  impact_impulses_.resize(contacts.size(), 0.0);
  frames_.resize(3 * contacts.size());
  for (SystemScratch& x : scratch_) x.free_v = x.unforced;
  for (std::size_t i = given; i < contacts.size(); ++i) add_contact(static_cast<int>(i), contacts[i], dt, true);
  const SolverReport solved = solve_rows(solver_options(dt, true), first, true);
  // The contacts of the guard have no recovery that could be reduced: without recovery of the others, they need none.
  if (reduce_recovery()) return step(systems, contacts, dt, forced_, 0);
  return finish(systems, contacts, dt, solved, first_report_);
}

/// Computes the new velocities, contact forces and positions from the solver's impulses.
StepReport Stepper::finish(std::span<StepSystem> systems, std::span<const collision::ContactPoint> contacts, double dt,
                           const SolverReport& solved, StepReport report) {
  const auto for_each_block = [&](const auto& visit) {
    for (const RowBlock& b : solver_.blocks()) visit(b, solver_.impulses(b));
    for (const SystemScratch& x : scratch_)
      if (x.by_tree)
        for (const RowBlock& b : x.tree->blocks()) visit(b, x.tree->impulses(b));
  };
  for_each_block([&](const RowBlock& b, std::span<const double>) { report.contacts += b.kind == RowKind::contact ? 1 : 0; });
  report.sweeps = solved.sweeps;
  report.newton_steps = solved.newton_steps;
  report.handed_over = solved.handed_over + handed_over_;
  report.islands = solved.islands;
  report.not_converged = solved.not_converged;
  report.residual = solved.residual;
  forces_.assign(contacts.size(), Vec3{});
  for (std::size_t s = 0; s < systems.size(); ++s) {
    const std::vector<double>& v = scratch_[s].free_v;
    for (std::size_t i = 0; i < v.size(); ++i) {
      if (std::isfinite(v[i]) && std::fabs(v[i]) < 1e6) continue;
      report.status = StepStatus::not_finite;
      report.system = static_cast<int>(s);
      report.dof = static_cast<int>(i);
      return report;
    }
  }
  warm_.clear();
  for (std::size_t i = 0; i < contacts.size(); ++i) forces_[i] = contacts[i].n * (impact_impulses_[i] / dt);
  for_each_block([&](const RowBlock& b, std::span<const double> p) {
    if (b.kind != RowKind::contact) {
      warm_.add({b.key, {p[0], b.rows == 3 ? p[1] : 0, b.rows == 3 ? p[2] : 0}});
      return;
    }
    const Vec3* frame = frames_.data() + 3 * b.contact;
    const Vec3 impulse = frame[0] * p[0] + frame[1] * p[1] + frame[2] * p[2];
    warm_.add({b.key, {impulse.x, impulse.y, impulse.z}});
    forces_[static_cast<std::size_t>(b.contact)] += impulse / dt;
  });
  warm_.make_index();
  if (!grips_.empty()) take_grip_forces(dt);
  for_each_system([&](std::size_t s) {
    std::ranges::copy(scratch_[s].free_v, systems[s].v.begin());
    integrate_system(s, systems[s], dt);
  });
  for (const SystemScratch& x : scratch_) {
    report.failed_motions += x.motion_failed ? 1 : 0;
    report.open_loops += x.loop_gap > StepperOptions::open_gap ? 1 : 0;
    report.loop_gap = std::max(report.loop_gap, x.loop_gap);
  }
  return report;
}

/// Moves the positions of one system through the step at its new velocities.
void Stepper::integrate_system(std::size_t s, StepSystem& system, double dt) {
  const Mechanism& m = *mechanisms_[s];
  SystemScratch& x = scratch_[s];
  x.loop_gap = 0;
  x.motion_failed = false;
  if (x.is_inertial) {
    dynamics::ClosedLinks* const closed = x.loops ? &x.loops->links : nullptr;
    if (x.inertial->move(m, workspaces_[s], closed, system.q, system.v, dt, x.loop_gap)) return;
    x.motion_failed = true;
    x.loop_gap = 0;
  }
  integrate(m, system.q, system.v, dt, system.q);
  if (x.loops) close_loops(s, system);
}

Stepper::LoopMemory Stepper::loop_memory(int system) const {
  const SystemScratch& x = scratch_[static_cast<std::size_t>(system)];
  return x.loops ? x.loops->links.memory() : LoopMemory{};
}

void Stepper::set_loop_memory(int system, const LoopMemory& memory) {
  if (const SystemScratch& x = scratch_[static_cast<std::size_t>(system)]; x.loops) x.loops->links.set_memory(memory);
}

Vec3 Stepper::velocity_after(int system, int link, const Vec3& p) const {
  const dynamics::Workspace& ws = workspaces_[static_cast<std::size_t>(system)];
  const std::vector<double>& v = scratch_[static_cast<std::size_t>(system)].free_v;
  const auto add = [&](Vec6& V, int k) { V += ws.S[static_cast<std::size_t>(k)] * v[static_cast<std::size_t>(k)]; };
  Vec6 V;
  if (!ws.chain.empty()) {
    for (const int k : dynamics::chain_of_link(ws, link)) add(V, k);
  } else {  // a large mechanism (Workspace::make_rows)
    const std::span<const int> parents = mechanisms_[static_cast<std::size_t>(system)]->dof_parents();
    for (int k = ws.link_chain[static_cast<std::size_t>(link)]; k >= 0; k = parents[static_cast<std::size_t>(k)]) add(V, k);
  }
  return V.v + cross(V.w, p - ws.p0);
}

}  // namespace ugoki::contact
