#include "ugoki/dynamics/closed_reference.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "ugoki/base/check.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::dynamics {
namespace {

/// Joint forces of the cut tree minus the applied forces: cw.tau1 = A vdot + b - applied.
void open_forces(const Mechanism& m, ClosedWorkspace& cw, std::span<const double> vdot, const Vec3& gravity, std::span<const Vec6> external,
                 std::span<const double> applied) {
  calc_inverse_dynamics(m, cw.open, vdot, gravity, external, cw.tau1);
  for (std::size_t i = 0; i < applied.size(); ++i) cw.tau1[i] -= applied[i];
}

constexpr std::size_t branch_points = 8;  ///< sample points of interpolate_through(): a polynomial of degree 7
constexpr double branch_step = 0.04;      ///< travel of the fastest DOF between adjacent sample points: rad, or a fraction of cw.length

/// Scope guard: while the object exists, the choice of theta_G, the independent DOFs, cannot change.
class HeldChoice {
 public:
  explicit HeldChoice(ClosedWorkspace& cw) : cw_(cw), before_(cw.hold_choice) { cw.hold_choice = true; }
  ~HeldChoice() { cw_.hold_choice = before_; }
  HeldChoice(const HeldChoice&) = delete;
  HeldChoice& operator=(const HeldChoice&) = delete;

 private:
  ClosedWorkspace& cw_;
  bool before_;
};

/// Value of a quantity near a singular position, interpolated along the motion.
/// Near such a position, solving for the dependent DOFs is a division 0 / 0. At a distance d from the position, rounding errors
/// of velocities grow as 1 / d^2 and those of accelerations as 1 / d^3. The motion itself passes through the position on one smooth branch.
/// The function therefore evaluates the quantity at points far enough before and after the position, and interpolates with Lagrange's
/// polynomial.
/// @param q, v state, closed in position; v points along the branch
/// @param evaluate (out [nv]) -> bool: writes the quantity at the state (cw.q3, cw.v3); false: not available there
/// @param out [nv, out] the interpolated quantity
/// @return false if the system is at rest, or fewer than branch_points suitable points exist: no branch can be followed
template <class Evaluate>
bool interpolate_through(const Mechanism& m, ClosedWorkspace& cw, std::span<const double> q, std::span<const double> v,
                         const Evaluate& evaluate, std::span<double> out) {
  const std::size_t n = v.size();
  double speed = 0;
  for (std::size_t i = 0; i < n; ++i) speed = std::max(speed, std::fabs(v[i] / cw.dof_scale[i]));
  if (!(speed > 1e-300)) return false;
  const bool held_before = cw.hold_choice;
  std::array<int, branch_points> at{};
  std::size_t count = 0;
  for (int step = 2; step < 26 && count < branch_points; ++step) {
    const int k = step % 2 == 0 ? step / 2 : -(step / 2);  // 1, -1, 2, -2 ...
    integrate(m, q, v, branch_step * k / speed, cw.q3);
    if (!close_theta_S(m, cw.q3, cw).closed) continue;
    update_partition(m, cw);
    if (cw.is_nearly_singular()) continue;
    cw.hold_choice = true;  // the same independent DOFs theta_G for all points
    std::ranges::copy(v, cw.v3.begin());
    apply_partition(cw, cw.v3);
    if (!evaluate(std::span(cw.branch).subspan(count * n, n))) continue;
    at[count++] = k;
  }
  cw.hold_choice = held_before;
  if (count < branch_points) return false;
  std::ranges::fill(out, 0.0);
  for (std::size_t a = 0; a < branch_points; ++a) {
    double weight = 1;  // Lagrange basis polynomial of point a, evaluated at 0
    for (std::size_t b = 0; b < branch_points; ++b)
      if (b != a) weight *= static_cast<double>(at[b]) / (at[b] - at[a]);
    for (std::size_t i = 0; i < n; ++i) out[i] += weight * cw.branch[a * n + i];
  }
  return true;
}

}  // namespace

void expand_acceleration(const ClosedWorkspace& cw, std::span<const double> vdot_G, std::span<double> vdot) {
  const auto g = static_cast<std::size_t>(cw.dofs());
  for (std::size_t i = 0; i < vdot.size(); ++i) {
    double sum = cw.h[i];
    for (std::size_t a = 0; a < g; ++a) sum += cw.H[i * g + a] * vdot_G[a];
    vdot[i] = sum;
  }
}

bool calc_closed_inverse_dynamics(const Mechanism& m, ClosedWorkspace& cw, std::span<const double> vdot, const Vec3& gravity,
                                  std::span<const Vec6> external, std::span<const double> applied, std::span<const int> driven,
                                  std::span<const double> weights, std::span<double> tau) {
  UGOKI_CHECK(tau.size() == static_cast<std::size_t>(m.nv()) && (weights.empty() || weights.size() == driven.size()));
  open_forces(m, cw, vdot, gravity, external, applied);
  const auto g = static_cast<std::size_t>(cw.dofs());
  reduce_forces(cw, cw.tau1, cw.b_G);
  // tau = D S (S^T D S)^-1 tau_G with D = 1 / weights: the minimum-norm solution of S^T tau = tau_G in the weighted norm.
  // S: rows of H of the driven DOFs.
  std::fill_n(cw.A_G.begin(), g * g, 0.0);
  for (std::size_t k = 0; k < driven.size(); ++k) {
    const double* S = cw.H.data() + static_cast<std::size_t>(driven[k]) * g;
    for (std::size_t a = 0; a < g; ++a)
      for (std::size_t b = 0; b <= a; ++b) cw.A_G[a * g + b] += S[a] * S[b] / (weights.empty() ? 1.0 : weights[k]);
  }
  std::ranges::fill(tau, 0.0);
  if (!factor_cholesky(cw.A_G, static_cast<int>(g), 1e-13)) return false;
  solve_cholesky(cw.A_G, static_cast<int>(g), std::span(cw.b_G).first(g));
  for (std::size_t k = 0; k < driven.size(); ++k) {
    const double* S = cw.H.data() + static_cast<std::size_t>(driven[k]) * g;
    double sum = 0;
    for (std::size_t a = 0; a < g; ++a) sum += S[a] * cw.b_G[a];
    tau[static_cast<std::size_t>(driven[k])] = sum / (weights.empty() ? 1.0 : weights[k]);
  }
  return true;
}

bool calc_closed_forward_dynamics_by_unit_vectors(const Mechanism& m, ClosedWorkspace& cw, std::span<const double> tau, const Vec3& gravity,
                                                  std::span<const Vec6> external, std::span<double> vdot) {
  UGOKI_CHECK(tau.size() == static_cast<std::size_t>(m.nv()) && vdot.size() == tau.size());
  const std::size_t n = tau.size(), g = static_cast<std::size_t>(cw.dofs());
  open_forces(m, cw, cw.h, gravity, external, tau);
  reduce_forces(cw, cw.tau1, cw.b_G);
  // Columns of A from inverse dynamics at rest and without gravity. In the difference ID(e_k) - b, the inertia of a small link would be
  // smaller than the rounding errors of the gravity and velocity terms.
  std::swap(cw.open.V, cw.rest_V);
  std::swap(cw.open.C, cw.rest_C);
  for (std::size_t k = 0; k < g; ++k) {
    for (std::size_t i = 0; i < n; ++i) cw.vdot1[i] = cw.H[i * g + k];
    open_forces(m, cw, cw.vdot1, {}, {}, {});
    reduce_forces(cw, cw.tau1, cw.column);
    for (std::size_t a = 0; a < g; ++a) cw.A_G[a * g + k] = cw.column[a];
  }
  std::swap(cw.open.V, cw.rest_V);
  std::swap(cw.open.C, cw.rest_C);
  for (std::size_t a = 0; a < g; ++a) {
    cw.b_G[a] = -cw.b_G[a];
    for (std::size_t b = 0; b < a; ++b) cw.A_G[a * g + b] = 0.5 * (cw.A_G[a * g + b] + cw.A_G[b * g + a]);
  }
  if (!factor_cholesky(cw.A_G, static_cast<int>(g), 1e-15)) return false;
  solve_cholesky(cw.A_G, static_cast<int>(g), std::span(cw.b_G).first(g));
  expand_acceleration(cw, cw.b_G, vdot);
  return true;
}

void calc_loop_forces(const Mechanism& m, ClosedWorkspace& cw, std::span<const double> tau, const Vec3& gravity,
                      std::span<const Vec6> external, std::span<const double> vdot, std::span<double> multipliers) {
  open_forces(m, cw, vdot, gravity, external, tau);
  std::ranges::fill(multipliers, 0.0);
  const std::size_t n = cw.tau1.size(), r = static_cast<std::size_t>(cw.rank), rows = cw.active.size(), rest = rows - r;
  // All quantities are scaled to one unit. With the independent rows J_I alone the multipliers would be mu = J_S^-T f_S, where f_S are the
  // forces on theta_S. The dependent rows are J_D = L J_I. The minimum-norm solution is therefore
  // multipliers_I = (1 + L^T L)^-1 mu, multipliers_D = L multipliers_I.
  for (std::size_t i = 0; i < r; ++i) {
    const auto f = static_cast<std::size_t>(cw.dof_order[i]);
    cw.column[i] = cw.tau1[f] * cw.dof_scale[f];
  }
  const std::span<double> mu = std::span(cw.column).first(r);
  cw.J_S.solve_transposed(mu);
  cw.pivots.resize(cw.J.size());
  cw.normal.resize(rows * rows);
  const auto L_row = [&](std::size_t d) { return std::span(cw.pivots).subspan(d * r, r); };
  for (std::size_t d = 0; d < rest; ++d) {
    const double* J = cw.J.data() + static_cast<std::size_t>(cw.row_order[r + d]) * n;
    for (std::size_t j = 0; j < r; ++j) L_row(d)[j] = J[cw.dof_order[j]];
    cw.J_S.solve_transposed(L_row(d));
  }
  for (std::size_t a = 0; a < r; ++a)
    for (std::size_t b = 0; b <= a; ++b) {
      double sum = a == b ? 1.0 : 0.0;
      for (std::size_t d = 0; d < rest; ++d) sum += L_row(d)[a] * L_row(d)[b];
      cw.normal[a * r + b] = sum;
    }
  if (!factor_cholesky(cw.normal, cw.rank, 0)) return;  // 1 + L^T L is positive definite, so this fails only if an entry is not finite
  solve_cholesky(cw.normal, cw.rank, mu);
  const auto store = [&](std::size_t k, double value) {
    const auto row = static_cast<std::size_t>(cw.active[static_cast<std::size_t>(cw.row_order[k])]);
    multipliers[row] = value * cw.row_scale[row];
  };
  for (std::size_t i = 0; i < r; ++i) store(i, mu[i]);
  for (std::size_t d = 0; d < rest; ++d) {
    double sum = 0;
    for (std::size_t j = 0; j < r; ++j) sum += L_row(d)[j] * mu[j];
    store(r + d, sum);
  }
}

Closure project_closed_state(const Mechanism& m, std::span<double> q, std::span<double> v, ClosedWorkspace& cw) {
  if (cw.full_rank < 0) {
    if (const Closure c = close_positions(m, q, cw); !c.closed) return c;
    find_full_rank(m, q, cw);
  }
  Closure c = close_theta_S(m, q, cw);
  if (!c.closed) {
    c = close_positions(m, q, cw);
    if (!c.closed) return c;
    find_full_rank(m, q, cw);
  }
  update_partition(m, cw);
  if (cw.is_nearly_singular()) {
    const auto velocity = [&](std::span<double> value) {
      std::ranges::copy(cw.v3, value.begin());
      return true;
    };
    if (interpolate_through(m, cw, q, v, velocity, cw.vdot2)) {
      for (const int f : cw.theta_S()) v[static_cast<std::size_t>(f)] = cw.vdot2[static_cast<std::size_t>(f)];
      return c;
    }
    update_gaps(m, q, cw);
    update_partition(m, cw);
  }
  apply_partition(cw, v);
  return c;
}

bool calc_closed_acceleration(const Mechanism& m, ClosedWorkspace& cw, std::span<const double> q, std::span<const double> v,
                              std::span<const double> tau, const Vec3& gravity, std::span<const Vec6> external, std::span<double> vdot) {
  std::ranges::copy(q, cw.q2.begin());
  std::ranges::copy(v, cw.v2.begin());
  // All stages of a step must integrate the same independent DOFs theta_G; project_closed_state() may change them after the step
  const HeldChoice held(cw);
  if (!project_closed_state(m, cw.q2, cw.v2, cw).closed) return false;
  update_closed(m, cw.q2, cw.v2, cw);
  if (cw.is_nearly_singular()) {
    const auto acceleration = [&](std::span<double> value) {
      update_closed(m, cw.q3, cw.v3, cw);
      return calc_closed_forward_dynamics_by_unit_vectors(m, cw, tau, gravity, external, value);
    };
    if (interpolate_through(m, cw, cw.q2, cw.v2, acceleration, vdot)) return true;
    update_closed(m, cw.q2, cw.v2, cw);
  }
  return calc_closed_forward_dynamics_by_unit_vectors(m, cw, tau, gravity, external, vdot);
}

}  // namespace ugoki::dynamics
