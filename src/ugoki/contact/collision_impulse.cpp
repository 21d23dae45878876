#include "ugoki/contact/collision_impulse.h"

#include <algorithm>
#include <cmath>

namespace ugoki::contact {
namespace {

// Relative thresholds.
constexpr double held = 1e-12;           // fraction of the response with open loops; a smaller response with closed loops is rounding
constexpr double max_correction = 1e-6;  // fraction of an impulse: maximum energy correction of elastic impulses; rounding stays below it
constexpr double tied = 1e-9;            // approach speeds that differ by less count as equal, and their collisions as simultaneous

bool same_pair(const collision::ContactPoint& a, const collision::ContactPoint& b) {
  return a.system_a == b.system_a && a.link_a == b.link_a && a.system_b == b.system_b && a.link_b == b.link_b;
}

double product(const double* x, const double* y, std::size_t n) {
  double sum = 0;
  for (std::size_t k = 0; k < n; ++k) sum += x[k] * y[k];
  return sum;
}

std::size_t dofs(const LinkSystem& s) { return s.v.size(); }

/// Calculates and factors the inertia matrix of a system and, if it is closed, its loop constraints. @return false: the inertia is singular
bool factor_system(const LinkSystem& s) {
  if (s.loops) {
    dynamics::update_kinematics(*s.mechanism, s.q, s.v, *s.workspace);
    if (dynamics::factor_closed_links(*s.mechanism, *s.workspace, *s.loops, s.q, s.v) != dynamics::ClosedStatus::ok) return false;
    dynamics::share_virtual_inertias(*s.loops, *s.workspace);
  }
  dynamics::calc_inertia_rows(*s.mechanism, *s.workspace);
  return dynamics::factor(*s.workspace, {}) < 0;
}

/// Calculates y = M x with the inertia matrix M. @param x, y [nv]; must not alias
void multiply_by_inertia(const dynamics::Workspace& ws, std::span<const double> x, std::span<double> y) {
  std::ranges::fill(y, 0.0);
  for (std::size_t i = 0; i < x.size(); ++i) {
    for (int e = ws.row_start[i]; e < ws.row_start[i + 1] - 1; ++e) {
      const auto j = static_cast<std::size_t>(ws.chain[static_cast<std::size_t>(e)]);
      y[i] += ws.M[static_cast<std::size_t>(e)] * x[j];
      y[j] += ws.M[static_cast<std::size_t>(e)] * x[i];
    }
    y[i] += ws.M[static_cast<std::size_t>(ws.row_start[i + 1] - 1)] * x[i];
  }
}

/// Change of the kinetic energy by a velocity change s d (s: factor): `rate` s + `square` s^2 / 2 [J].
/// It is summed link by link, because in products with the inertia matrix the energy of light links would be lost in the rounding of heavy
/// ones.
struct EnergyChange {
  double rate = 0, square = 0;  // J

  void add(const LinkSystem& s, std::span<const double> d) {
    const Mechanism& m = *s.mechanism;
    dynamics::Workspace& ws = *s.workspace;
    for (int i = 0; i < m.link_count(); ++i) {
      const auto at = static_cast<std::size_t>(i);
      const Link& link = m.link(i);
      const auto parent = static_cast<std::size_t>(std::max(link.parent, 0));
      Vec6 V = link.parent >= 0 ? ws.A[parent] : Vec6{}, D = link.parent >= 0 ? ws.pA[parent] : Vec6{};
      for (auto f = static_cast<std::size_t>(link.v_index); f < static_cast<std::size_t>(link.v_index + link.joint.nv()); ++f) {
        V += ws.S[f] * s.v[f];
        D += ws.S[f] * d[f];
        rate += ws.armature[f] * s.v[f] * d[f];
        square += ws.armature[f] * d[f] * d[f];
      }
      ws.A[at] = V;
      ws.pA[at] = D;
      const Vec6 h = ws.I[at] * D;
      rate += dot(V, h);
      square += dot(D, h);
    }
  }
};

}  // namespace

/// Adds a contact: the row r^T J of both sides (r: normal, J: Jacobian) and the separation velocity u.
/// @return false if no DOF moves the contact
bool CollisionImpulse::add_row(std::span<const LinkSystem> systems, const collision::ContactPoint& c, int index) {
  Row row;
  row.contact = index;
  row.e = c.restitution;
  int count = 0;
  for (int side = 0; side < 2; ++side) {
    const int s = side == 0 ? c.system_a : c.system_b, link = side == 0 ? c.link_a : c.link_b;
    if (s < 0) continue;
    const LinkSystem& system = systems[static_cast<std::size_t>(s)];
    const std::span<const int> chain = dynamics::chain_of_link(*system.workspace, link);
    if (chain.empty()) continue;
    const double sign = side == 0 ? 1 : -1;
    row.sides[side] = {s, static_cast<int>(rows_.size())};
    const std::size_t at = rows_.size();
    rows_.resize(at + dofs(system), 0.0);
    const Vec3 arm = c.p - system.workspace->p0;
    const Vec3 n = c.n * sign, moment = cross(arm, n);
    for (const int k : chain) {
      const Vec6& S = system.workspace->S[static_cast<std::size_t>(k)];
      rows_[at + static_cast<std::size_t>(k)] = dot(n, S.v) + dot(moment, S.w);
    }
    row.u += product(rows_.data() + at, system.v.data(), dofs(system));
    ++count;
  }
  if (count == 0) return false;
  list_.push_back(row);
  return true;
}

/// Calculates the velocity change MJ per unit impulse of a row, eqs. (15) (16), if not yet known.
/// @return false: an inertia is singular (see `report`)
bool CollisionImpulse::make_jump(std::span<const LinkSystem> systems, Row& row, ImpactReport& report) {
  if (row.has_jump) return true;
  for (const Side& side : row.sides) {
    if (side.system < 0) continue;
    const LinkSystem& s = systems[static_cast<std::size_t>(side.system)];
    char& factored = factored_[static_cast<std::size_t>(side.system)];
    if (!factored && !factor_system(s)) {
      report.status = ImpactStatus::singular;
      report.system = side.system;
      return false;
    }
    factored = 1;
    if (jumps_.size() < rows_.size()) jumps_.resize(rows_.size());
    const std::span<double> jump(jumps_.data() + side.row, dofs(s));
    std::copy_n(rows_.data() + side.row, jump.size(), jump.data());
    dynamics::solve(*s.workspace, jump);
    row.open += product(rows_.data() + side.row, jump.data(), jump.size());
    if (!s.loops) continue;
    closed_.solve(*s.mechanism, *s.workspace, *s.loops, {plain_.data() + side.row, dofs(s)}, jump);
    // Replace the row r^T J by M MJ (inertia matrix times jump), which eqs. (13) (14) need. Multiplied by a velocity that keeps the loops
    // closed, both give the same value; M MJ is accurate to rounding even if the loops are nearly singular.
    multiply_by_inertia(*s.workspace, jump, {rows_.data() + side.row, dofs(s)});
  }
  row.has_jump = true;
  return true;
}

/// Recalculates the separation velocity u of a row.
/// @param plain true: u is computed from all of v; false: only from the component of v that the loops allow
void CollisionImpulse::update_velocity(std::span<const LinkSystem> systems, Row& row, bool plain) const {
  row.u = 0;
  for (const Side& side : row.sides) {
    if (side.system < 0) continue;
    const LinkSystem& s = systems[static_cast<std::size_t>(side.system)];
    row.u += product((plain ? plain_ : rows_).data() + side.row, s.v.data(), dofs(s));
  }
}

/// Velocity change [m/s per N s] of contact a by a unit impulse at contact b.
double CollisionImpulse::coupling(std::span<const LinkSystem> systems, const Row& a, const Row& b) const {
  double sum = 0;
  for (const Side& x : a.sides)
    for (const Side& y : b.sides)
      if (x.system >= 0 && x.system == y.system)
        sum += product(rows_.data() + x.row, jumps_.data() + y.row, dofs(systems[static_cast<std::size_t>(x.system)]));
  return sum;
}

/// Solves the linear complementarity problem p >= 0, A p + b >= 0, p . (A p + b) = 0 by an active-set method (Lawson, Hanson 1974).
/// A_ [n * n] must be symmetric positive semi-definite; b_ [n]; the result is p_ [n].
void CollisionImpulse::solve_nonnegative(std::size_t n) {
  p_.assign(n, 0.0);
  s_.resize(n);
  g_.assign(b_.begin(), b_.begin() + static_cast<std::ptrdiff_t>(n));
  banned_.assign(n, 0);
  passive_.clear();
  double scale = 0;
  for (std::size_t i = 0; i < n; ++i) scale = std::max(scale, std::fabs(b_[i]));
  const auto a = [&](int i, int j) { return A_[static_cast<std::size_t>(i) * n + static_cast<std::size_t>(j)]; };
  // Factors A_PP = L L^T over the passive set P. @return false if the last row of A_PP depends on the others
  const auto factor = [&] {
    const std::size_t m = passive_.size();
    L_.resize(m * m);
    for (std::size_t i = 0; i < m; ++i)
      for (std::size_t j = 0; j <= i; ++j) {
        double sum = a(passive_[i], passive_[j]);
        for (std::size_t k = 0; k < j; ++k) sum -= L_[i * m + k] * L_[j * m + k];
        if (j < i) {
          L_[i * m + j] = sum / L_[j * m + j];
        } else {
          if (!(sum > 1e-11 * a(passive_[i], passive_[i]))) return false;
          L_[i * m + i] = std::sqrt(sum);
        }
      }
    return true;
  };
  const auto solve = [&](std::span<double> x) {
    const std::size_t m = passive_.size();
    for (std::size_t i = 0; i < m; ++i) {
      for (std::size_t k = 0; k < i; ++k) x[i] -= L_[i * m + k] * x[k];
      x[i] /= L_[i * m + i];
    }
    for (std::size_t i = m; i-- > 0;) {
      x[i] /= L_[i * m + i];
      for (std::size_t k = 0; k < i; ++k) x[k] -= L_[i * m + k] * x[i];
    }
  };
  for (std::size_t round = 0; round < 10 * n + 10; ++round) {
    int best = -1;
    for (std::size_t i = 0; i < n; ++i)
      if (p_[i] == 0 && !banned_[i] && g_[i] < -1e-14 * scale && (best < 0 || g_[i] < g_[static_cast<std::size_t>(best)]) &&
          std::ranges::find(passive_, static_cast<int>(i)) == passive_.end())
        best = static_cast<int>(i);
    if (best < 0) return;
    passive_.push_back(best);
    if (!factor()) {
      passive_.pop_back();
      banned_[static_cast<std::size_t>(best)] = 1;
      continue;
    }
    while (!passive_.empty()) {
      const std::size_t m = passive_.size();
      (void)factor();
      std::fill_n(s_.begin(), m, 0.0);
      for (int pass = 0; pass < 2; ++pass) {  // the second pass is iterative refinement
        g_.resize(n + m);
        const std::span<double> rest(g_.data() + n, m);
        for (std::size_t i = 0; i < m; ++i) {
          rest[i] = -b_[static_cast<std::size_t>(passive_[i])];
          for (std::size_t j = 0; j < m; ++j) rest[i] -= a(passive_[i], passive_[j]) * s_[j];
        }
        solve(rest);
        for (std::size_t i = 0; i < m; ++i) s_[i] += rest[i];
      }
      double part = 1;
      std::size_t blocking = m;
      for (std::size_t i = 0; i < m; ++i) {
        const double p = p_[static_cast<std::size_t>(passive_[i])];
        if (s_[i] > 0) continue;
        const double limit = p > 0 ? p / (p - s_[i]) : 0;
        if (blocking == m || limit < part) {
          part = limit;
          blocking = i;
        }
      }
      if (blocking == m) part = 1;
      for (std::size_t i = 0; i < m; ++i) {
        double& p = p_[static_cast<std::size_t>(passive_[i])];
        p += part * (s_[i] - p);
        if (blocking == m) p = s_[i];
      }
      if (blocking == m) break;
      p_[static_cast<std::size_t>(passive_[blocking])] = 0;
      passive_.erase(passive_.begin() + static_cast<std::ptrdiff_t>(blocking));
    }
    for (std::size_t i = 0; i < n; ++i) {
      g_[i] = b_[i];
      for (std::size_t j = 0; j < n; ++j) g_[i] += A_[i * n + j] * p_[j];
    }
  }
}

/// Collides the contacts of the pair of links that approaches fastest, and of all pairs that approach equally fast. With `plastic`,
/// collides all contacts simultaneously.
/// @return false if no contact approaches, or on an error (see `report`)
bool CollisionImpulse::collide_group(std::span<const LinkSystem> systems, std::span<const collision::ContactPoint> contacts,
                                     const ImpactOptions& options, bool plastic, ImpactReport& report) {
  const auto takes_part = [&](const Row& r) {
    return r.u < 0 && (options.reach == 0 || contacts[static_cast<std::size_t>(r.contact)].distance + options.reach * r.u <= 0);
  };
  if (plastic)  // u also counts velocities that violate the loops by rounding, so that the points really do not approach afterwards
    for (Row& r : list_) update_velocity(systems, r, true);
  double fastest = 0;
  for (const Row& r : list_)
    if ((plastic || (r.e > 0 && -r.u > options.min_speed)) && takes_part(r)) fastest = std::max(fastest, -r.u);
  if (fastest <= rounding_) return false;
  fastest_.clear();
  for (std::size_t i = 0; i < list_.size() && !plastic; ++i)
    if (list_[i].e > 0 && -list_[i].u >= (1 - tied) * fastest && takes_part(list_[i])) fastest_.push_back(list_[i].contact);
  group_.clear();
  for (std::size_t i = 0; i < list_.size(); ++i) {
    const Row& r = list_[i];
    const auto of_its_pair = [&](int other) {
      return same_pair(contacts[static_cast<std::size_t>(r.contact)], contacts[static_cast<std::size_t>(other)]);
    };
    if (plastic || (r.e > 0 && takes_part(r) && std::ranges::any_of(fastest_, of_its_pair))) group_.push_back(static_cast<int>(i));
  }
  for (const int i : group_)
    if (!make_jump(systems, list_[static_cast<std::size_t>(i)], report)) return false;
  std::erase_if(group_, [&](int i) {  // drop a contact if the loops allow no relative velocity along its normal
    const Row& r = list_[static_cast<std::size_t>(i)];
    return coupling(systems, r, r) <= held * r.open;
  });
  const std::size_t n = group_.size();
  if (n == 0) return false;
  A_.resize(n * n);
  b_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Row& r = list_[static_cast<std::size_t>(group_[i])];
    b_[i] = (1 + (plastic ? 0 : r.e)) * r.u;
    for (std::size_t j = 0; j <= i; ++j) A_[i * n + j] = A_[j * n + i] = coupling(systems, r, list_[static_cast<std::size_t>(group_[j])]);
  }
  solve_nonnegative(n);
  apply(systems);
  const auto is_struck = [&](const Side& side) { return side.system >= 0 && struck_[static_cast<std::size_t>(side.system)]; };
  for (Row& r : list_)
    if (std::ranges::any_of(r.sides, is_struck)) update_velocity(systems, r, plastic);
  ++report.collisions;
  return true;
}

/// Adds the velocity changes MJ p to the velocities v of the systems, eqs. (18) (19) of the paper (see collision_impulse.h). The p are the
/// impulses of the contacts in the group. If all collisions of the group are elastic, the p are scaled so that the kinetic energy is
/// conserved to rounding.
void CollisionImpulse::apply(std::span<const LinkSystem> systems) {
  struck_.assign(systems.size(), 0);
  struck_list_.clear();
  const auto change = [&](std::size_t s) { return std::span(change_).subspan(first_dof_[s], dofs(systems[s])); };
  bool elastic = true;
  for (std::size_t i = 0; i < group_.size(); ++i) {
    if (p_[i] == 0) continue;
    const Row& r = list_[static_cast<std::size_t>(group_[i])];
    elastic = elastic && r.e == 1;
    for (const Side& side : r.sides) {
      if (side.system < 0) continue;
      const auto s = static_cast<std::size_t>(side.system);
      if (!struck_[s]) {
        struck_[s] = 1;
        struck_list_.push_back(s);
        std::ranges::fill(change(s), 0.0);
      }
      for (std::size_t k = 0; k < dofs(systems[s]); ++k) change(s)[k] += jumps_[static_cast<std::size_t>(side.row) + k] * p_[i];
    }
  }
  double part = 1;
  if (elastic) {
    EnergyChange energy;
    for (const std::size_t s : struck_list_) energy.add(systems[s], change(s));
    const double exact = -2 * energy.rate / energy.square;
    if (std::fabs(exact - 1) < max_correction) part = exact;
  }
  for (std::size_t i = 0; i < group_.size(); ++i)
    if (p_[i] != 0) impulses_[static_cast<std::size_t>(list_[static_cast<std::size_t>(group_[i])].contact)] += part * p_[i];
  for (const std::size_t s : struck_list_)
    for (std::size_t k = 0; k < dofs(systems[s]); ++k) systems[s].v[k] += part * change(s)[k];
}

ImpactReport CollisionImpulse::collide(std::span<const LinkSystem> systems, std::span<const collision::ContactPoint> contacts,
                                       const ImpactOptions& options) {
  ImpactReport report;
  list_.clear();
  rows_.clear();
  factored_.assign(systems.size(), 0);
  first_dof_.assign(1, 0);
  for (const LinkSystem& s : systems) first_dof_.push_back(first_dof_.back() + dofs(s));
  change_.resize(first_dof_.back());
  impulses_.assign(contacts.size(), 0.0);
  rounding_ = 0;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (!options.plastic && !(contacts[i].restitution > 0)) continue;
    if (add_row(systems, contacts[i], static_cast<int>(i))) rounding_ = std::max(rounding_, std::fabs(list_.back().u));
  }
  rounding_ *= 1e-13;
  plain_ = rows_;
  for (Row& r : list_) {
    const auto closed = [&](const Side& side) { return side.system >= 0 && systems[static_cast<std::size_t>(side.system)].loops; };
    if (!std::ranges::any_of(r.sides, closed)) continue;
    if (!make_jump(systems, r, report)) return report;
    update_velocity(systems, r, false);
  }
  const std::size_t limit = 1000 + 100 * list_.size();
  while (collide_group(systems, contacts, options, false, report)) {
    if (static_cast<std::size_t>(report.collisions) < limit) continue;
    report.status = ImpactStatus::unfinished;
    break;
  }
  if (report.status != ImpactStatus::singular && options.plastic)
    for (int again = 0; again < 3 && collide_group(systems, contacts, options, true, report);) ++again;
  for (const Row& r : list_)
    if (-r.u > options.min_speed) report.approach = std::max(report.approach, -r.u);
  return report;
}

}  // namespace ugoki::contact
