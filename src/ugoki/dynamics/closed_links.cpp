#include "ugoki/dynamics/closed_links.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/check.h"
#include "ugoki/dynamics/closed_run.h"
#include "ugoki/dynamics/closed_solver.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::dynamics {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Returns the larger of |p0| and the maximum distance of a link's origin from p0 [m]: the scale of rounding errors of positions.
double extent(const Workspace& ws) {
  double maximum = norm(ws.p0);
  for (const Pose& X : ws.X_WB) maximum = std::max(maximum, norm(X.p - ws.p0));
  return maximum;
}

ClosedTree tree_of_links(const Mechanism& m) {
  ClosedTree tree;
  for (int i = 0; i < m.link_count(); ++i) {
    tree.parent.push_back(m.link(i).parent);
    tree.dofs.push_back(m.link(i).joint.nv());
    tree.node_of_link.push_back(i);
  }
  for (int f = 0; f < m.nv(); ++f) tree.node_of_dof.push_back(m.link_of_dof(f));
  return tree;
}

std::vector<char> closed_at_start(const Mechanism& m) {
  std::vector<char> closed;
  for (const Loop& loop : m.loops()) closed.push_back(loop.closed);
  return closed;
}

/// Characteristic length of the mechanism, m: maximum of joint offsets, radii of gyration and loop frame offsets. 1 if all are zero.
double length_of(const Mechanism& m, std::span<const Loop> loops) {
  double maximum = 0;
  for (const Link& link : m.links()) {
    const Inertia& body = link.inertia;
    maximum = std::max(maximum, norm(link.joint.X_PJ.p));
    if (body.mass > 0) maximum = std::max(maximum, std::sqrt(0.5 * (body.I.xx + body.I.yy + body.I.zz) / body.mass));
  }
  for (const Loop& loop : loops)
    if (loop.type != LoopType::gear) maximum = std::max({maximum, loop.link_a < 0 ? 0.0 : norm(loop.X_AJ.p), norm(loop.X_BJ.p)});
  return maximum > 0 ? maximum : 1;
}

}  // namespace

ClosedLinks::ClosedLinks(const Mechanism& m) : ClosedLinks(m, {m.loops().begin(), m.loops().end()}, closed_at_start(m)) {}

ClosedLinks::ClosedLinks(const Mechanism& m, std::vector<Loop> loops, std::span<const char> closed, std::span<const char> rows)
    : loops_(std::move(loops)), rows_(loops_), over_links_(tree_of_links(m), loops_, closed, rows_.first, rows) {
  const ClosedStructure& x = over_links_;
  const std::size_t n = x.row.size();
  share_inertias(m);
  length_ = length_of(m, loops_);
  I_.resize(m.links().size());
  P_.resize(at(x.present_rows));
  s_.resize(at(x.s_rows));
  Lambda_.resize(36 * at(x.blocks));
  C_.resize(36 * x.entries.size());
  Y_.resize(36 * x.neighbours.size());
  rank_of_.resize(x.entries.size());
  pivots_.resize(n);
  Z_.resize(n);
  for (std::vector<double>* v : {&reduced_, &terms_, &g_, &z_, &lambda_}) v->resize(n);
  multipliers_.resize(at(rows_.count()));
  independent_.resize(at(rows_.count()));
  delta_.resize(at(m.nv()));
  kernel_ = std::make_unique<ClosedKernelState>(m, *this, closed, rows);
}

ClosedLinks::ClosedLinks(ClosedLinks&&) noexcept = default;
ClosedLinks& ClosedLinks::operator=(ClosedLinks&&) noexcept = default;
ClosedLinks::~ClosedLinks() = default;

// A virtual link is a second body of its real link. A virtual link without inertia of its own gets a share of the real link's inertia.
// This does not change the closed system, and no joint of the cut tree then moves a massless body.
void ClosedLinks::share_inertias(const Mechanism& m) {
  std::vector<int> bodies(m.links().size(), 1);
  const auto second_body = [&](const ClosedStructure::Entry& e) {
    const Loop& loop = loops_[at(e.loop)];
    if (!loop.of_virtual_link) return false;
    const Inertia& own = m.link(loop.link_b).inertia;
    return own.mass == 0 && own.I == Sym3{};
  };
  for (const ClosedStructure::Entry& e : over_links_.entries)
    if (second_body(e)) ++bodies[at(loops_[at(e.loop)].link_a)];
  for (const ClosedStructure::Entry& e : over_links_.entries) {
    if (!second_body(e)) continue;
    const Loop& loop = loops_[at(e.loop)];
    shares_.push_back({loop.link_b, loop.link_a, 1.0 / bodies[at(loop.link_a)]});
  }
  for (std::size_t i = 0; i < bodies.size(); ++i)
    if (bodies[i] > 1) shares_.push_back({static_cast<int>(i), static_cast<int>(i), 1.0 / bodies[i]});
}

ClosedStatus factor_closed_links(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<const double> q,
                                 std::span<const double> v, double dependent) {
  ClosedSolver solver(m, ws, closed);
  solver.update_rows(q, v);
  return solver.factor(dependent) ? ClosedStatus::ok : ClosedStatus::singular_inertia;
}

void calc_closed_forward_dynamics(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<const double> tau, const Vec3& gravity,
                                  std::span<const Vec6> external, std::span<double> vdot) {
  ClosedSolver solver(m, ws, closed);
  solver.forces_of_motion(external);
  solver.solve(tau, true, {{}, -gravity}, vdot);
}

void project_velocity(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<double> v) {
  ClosedSolver solver(m, ws, closed);
  solver.sweep_velocity(v);
  solver.residual_of_velocity(v);
  const std::span<const double> delta = solver.correct();
  for (std::size_t i = 0; i < v.size(); ++i) v[i] += delta[i];
}

void solve_closed_links(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<const double> r, std::span<const double> v,
                        std::span<double> x) {
  ClosedSolver solver(m, ws, closed);
  solver.sweep_velocity(v);
  solver.residual_of_velocity(v);
  std::ranges::fill(ws.pA, Vec6{});
  solver.solve(r, false, {}, x);
}

namespace {

/// project_position() and close_position(). @param keep_factor false: kinematics and factor need not be those of the final q
ClosedStatus close_loops(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<double> q, std::span<const double> v,
                         double& gap, int limit, bool keep_factor) {
  double last = HUGE_VAL, dependent = std::max(dependent_row, dependent_correction * closed.typical_pivot_ratio());
  for (int step = 0;; ++step) {
    // One Newton step usually closes the gaps. To see this, the poses and the independent rows of the last factor are sufficient.
    if (step > 0 && !keep_factor) {
      calc_poses(m, q, ws.X_WB);
      ws.p0 = ws.X_WB[0].p;
      ClosedSolver::update_rows(m, ws, closed, q, v);
      gap = max_gap(closed);
      if (gap <= 4e-16 * (1 + extent(ws))) return ClosedStatus::ok;
    }
    update_kinematics(m, q, v, ws);
    if (factor_closed_links(m, ws, closed, q, v, dependent) != ClosedStatus::ok) return ClosedStatus::singular_inertia;
    gap = max_gap(closed);
    const double rounding = 1e-16 * (1 + extent(ws));
    if (gap <= 4 * rounding || (gap <= 1e3 * rounding && gap >= 0.5 * last)) return ClosedStatus::ok;
    if (step >= limit || !std::isfinite(gap)) return ClosedStatus::not_closed;
    if (gap >= 0.5 * last && dependent != dependent_row) {  // only directions that `dependent` excluded can close the remaining gap
      dependent = dependent_row;
      if (factor_closed_links(m, ws, closed, q, v, dependent) != ClosedStatus::ok) return ClosedStatus::singular_inertia;
    }
    last = gap;
    ClosedSolver solver(m, ws, closed);
    solver.residual_of_position();
    integrate(m, q, solver.correct(), 1.0, q);
  }
}

}  // namespace

ClosedStatus project_position(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<double> q, std::span<const double> v,
                              double& gap, int limit) {
  return close_loops(m, ws, closed, q, v, gap, limit, true);
}

ClosedStatus close_position(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<double> q, std::span<const double> v,
                            double& gap, int limit) {
  return close_loops(m, ws, closed, q, v, gap, limit, false);
}

void ClosedLinks::note_rank() {
  if (rank_ > full_rank_) {
    full_rank_ = rank_;
    typical_pivot_ratio_ = min_pivot_ratio_;
  } else if (rank_ == full_rank_) {
    typical_pivot_ratio_ = std::max(typical_pivot_ratio_, min_pivot_ratio_);
  }
}

void share_virtual_inertias(const ClosedLinks& closed, Workspace& ws) {
  for (const InertiaShare& s : closed.shares_)  // the real links' own shares come last, so the virtual links read the full inertia
    ws.I[at(s.link)] = ws.I[at(s.source)] * s.part;
}

double max_gap(const ClosedLinks& closed) {
  double maximum = 0;
  for (std::size_t k = 0; k < closed.independent().size(); ++k)
    if (closed.independent()[k]) maximum = std::max(maximum, std::fabs(closed.rows().gap[k]));
  return maximum;
}

}  // namespace ugoki::dynamics
