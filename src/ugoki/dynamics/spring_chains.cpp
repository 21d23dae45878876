#include "ugoki/dynamics/spring_chains.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/number.h"
#include "ugoki/dynamics/dense.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::dynamics {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Inertia and gravity of one chain in the rest pose. Matrices are n x n, row by row.
struct ChainForces {
  std::vector<int> dofs;                   // velocity indices of the chain
  std::vector<double> M, G, D, torque, x;  // inertia; gravity stiffness; diagonal of M [n]; drive torques at rest [n]; displacement [n]

  [[nodiscard]] int n() const { return static_cast<int>(dofs.size()); }
  /// Factors s D + G + a M into L. @return false if it is not positive definite
  bool factor(double s, double a, std::vector<double>& L) const {
    L.resize(M.size());
    for (std::size_t i = 0; i < L.size(); ++i) L[i] = G[i] + a * M[i];
    for (std::size_t i = 0; i < D.size(); ++i) L[i * D.size() + i] += s * D[i];
    for (std::size_t i = 0; i < D.size(); ++i)
      if (!(L[i * D.size() + i] > 0)) return false;
    return factor_cholesky(L, n(), 1e-12);
  }
};

/// Returns the joint torques that hold the mechanism at rest.
std::vector<double> holding_torques(const Mechanism& m, Workspace& ws, std::span<const double> q, const Vec3& gravity) {
  const std::vector<double> still(at(m.nv()), 0.0);
  std::vector<double> tau(still.size());
  calc_inverse_dynamics(m, ws, q, still, {}, gravity, {}, tau);
  return tau;
}

ChainForces find_forces(const Mechanism& m, Workspace& ws, std::vector<int> dofs, std::span<const double> q, const Vec3& gravity) {
  constexpr double h = 1e-5;          // rad | m: step of the central differences; their error is about h^2 of the torque
  constexpr double min_share = 0.01;  // an axis with little inertia gets at least this share of the springs of the joint's other axes
  ChainForces c;
  c.dofs = std::move(dofs);
  const std::size_t n = c.dofs.size();
  c.M.assign(n * n, 0.0);
  c.G.assign(n * n, 0.0);
  calc_inertia_rows(m, ws, q);
  for (std::size_t i = 0; i < n; ++i)
    for (int e = ws.row_start[at(c.dofs[i])]; e < ws.row_start[at(c.dofs[i]) + 1]; ++e) {
      const auto j = std::ranges::find(c.dofs, ws.chain[at(e)]) - c.dofs.begin();
      if (at(static_cast<int>(j)) < n) c.M[i * n + at(static_cast<int>(j))] = c.M[at(static_cast<int>(j)) * n + i] = ws.M[at(e)];
    }
  std::vector<double> move(at(m.nv()), 0.0), moved(q.size()), displacement(move.size());
  for (std::size_t j = 0; j < n; ++j) {
    for (const double sign : {1.0, -1.0}) {
      move[at(c.dofs[j])] = sign * h;
      integrate(m, q, move, 1.0, moved);
      const std::vector<double> tau = holding_torques(m, ws, moved, gravity);
      for (std::size_t i = 0; i < n; ++i) {  // the derivative is symmetric at rest: use the mean of both halves
        const double slope = sign * tau[at(c.dofs[i])] / (4 * h);
        c.G[i * n + j] += slope;
        c.G[j * n + i] += slope;
      }
    }
    move[at(c.dofs[j])] = 0;
  }
  const std::vector<double> tau = holding_torques(m, ws, q, gravity);
  for (const Link& link : m.links()) joint_displacement(link.joint, q.data() + link.q_index, displacement.data() + link.v_index);
  for (std::size_t i = 0; i < n; ++i) {
    c.torque.push_back(tau[at(c.dofs[i])]);
    c.x.push_back(displacement[at(c.dofs[i])]);
    double largest = 0;
    for (std::size_t j = 0; j < n; ++j)
      if (m.link_of_dof(c.dofs[i]) == m.link_of_dof(c.dofs[j])) largest = std::max(largest, c.M[j * n + j]);
    c.D.push_back(std::max(c.M[i * n + i], min_share * largest));
  }
  return c;
}

/// Returns the smallest value between 0 and `high` for which `works` is true. `works` is false below it and true above it.
template <class Works>
double bisect(double high, Works works) {
  double low = 0;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (works(middle) ? high : low) = middle;
  }
  return high;
}

/// Returns the mode of the factored matrix with the lowest natural frequency, by inverse iteration with M.
std::vector<double> lowest_mode(const ChainForces& c, std::span<const double> L) {
  const std::size_t n = c.dofs.size();
  std::vector<double> mode(n, 1.0), next(n);
  for (int iteration = 0; iteration < 50; ++iteration) {
    double size = 0;
    for (std::size_t i = 0; i < n; ++i) {
      next[i] = 0;
      for (std::size_t j = 0; j < n; ++j) next[i] += c.M[i * n + j] * mode[j];
    }
    solve_cholesky(L, c.n(), next);
    for (const double x : next) size = std::max(size, std::fabs(x));
    for (std::size_t i = 0; i < n; ++i) mode[i] = next[i] / size;
  }
  return mode;
}

/// Sets the springs and dampers of one chain. @return the problem, or an empty error
Error tune(const Mechanism& m, const SpringChain& chain, const ChainForces& c, double step, MechanismSpec& spec) {
  const double w = 2 * pi * chain.frequency;
  const std::size_t n = c.dofs.size();
  std::vector<double> L;
  const auto supports = [&](double s) { return c.factor(s, -w * w, L); };
  if (supports(0)) {
    const double alone = bisect(1e4, [&](double hz) { return !c.factor(0, -4 * pi * pi * hz * hz, L); });
    return {ErrorCode::range, "link " + m.link(chain.link).name,
            "Under gravity alone, the chain swings at " + to_fixed(alone, 2) + " Hz, faster than the wanted " +
                to_fixed(chain.frequency, 2) + " Hz.",
            "Choose a higher frequency."};
  }
  double high = w * w;
  while (!supports(high) && high < 1e12) high *= 2;
  const double s = bisect(high, supports);
  if (!c.factor(s * (1 + 1e-7), -w * w, L))
    return {ErrorCode::structure, "link " + m.link(chain.link).name, "The inertia of the chain is singular.",
            "Give the links of the chain mass and size."};
  // A damper c D takes the power c mode^T D mode from the lowest mode, which has the inertia mode^T M mode.
  const std::vector<double> mode = lowest_mode(c, L);
  double inertia = 0, share = 0;
  for (std::size_t i = 0; i < n; ++i) {
    share += mode[i] * c.D[i] * mode[i];
    for (std::size_t j = 0; j < n; ++j) inertia += mode[i] * c.M[i * n + j] * mode[j];
  }
  const double damper = 2 * chain.damping * w * inertia / share;
  for (std::size_t i = 0; i < n; ++i) {
    const int link = m.link_of_dof(c.dofs[i]);
    Dof& dof = std::ranges::find(spec.links, m.link(link).name, &LinkSpec::name)->joint.dofs[at(c.dofs[i] - m.link(link).v_index)];
    dof.stiffness = s * c.D[i];
    dof.damping = std::max(0.0, damper - step * s) * c.D[i];
    dof.rest = c.x[i] + c.torque[i] / dof.stiffness;
    dof.friction = 0;
    dof.effort = 0;
  }
  return {};
}

}  // namespace

Result<MechanismPtr> with_spring_chains(const Mechanism& m, std::span<const SpringChain> chains, std::span<const double> q,
                                        const Vec3& gravity, double step) {
  Error problems;
  Workspace ws(m);
  MechanismSpec spec = m.spec();
  std::vector<unsigned char> used(m.links().size(), 0);
  for (const SpringChain& chain : chains) {
    const std::string location = "link " + m.link(chain.link).name;
    std::vector<unsigned char> inside(used.size(), 0);
    std::vector<int> dofs;
    bool shared = false, closed = false;
    for (int i = chain.link; i < m.link_count(); ++i) {
      const Link& link = m.link(i);
      if (i != chain.link && (link.parent < 0 || !inside[at(link.parent)])) continue;
      inside[at(i)] = 1;
      shared = shared || used[at(i)];
      used[at(i)] = 1;
      for (int k = 0; k < link.joint.nv(); ++k) dofs.push_back(link.v_index + k);
    }
    for (const Loop& loop : m.loops()) closed = closed || inside[at(loop.link_a)] || (loop.link_b >= 0 && inside[at(loop.link_b)]);
    if (m.link(chain.link).joint.type == JointType::floating)
      problems.add(ErrorCode::structure, location, "A spring chain cannot begin at a floating root.", "Name a link below the root.");
    else if (dofs.empty())
      problems.add(ErrorCode::structure, location, "The chain has no joint that moves.", "Name a link with a movable joint.");
    else if (shared)
      problems.add(ErrorCode::duplicate, location, "The link belongs to two spring chains.",
                   "A chain contains all links below its first link: remove one of the chains.");
    else if (closed)
      problems.add(ErrorCode::unsupported, location, "The chain is part of a closed loop.", "Name a link that is not part of a loop.");
    else
      for (Problem& p : tune(m, chain, find_forces(m, ws, std::move(dofs), q, gravity), step, spec).problems)
        problems.problems.push_back(std::move(p));
  }
  if (!problems.empty()) return fail(std::move(problems));
  return Mechanism::make(std::move(spec));
}

}  // namespace ugoki::dynamics
