#include "ugoki/dynamics/closed_impulse.h"

#include <algorithm>
#include <cmath>

#include "ugoki/dynamics/dense.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::dynamics {
namespace {

/// Maximum number of solves in refine(). The loop usually stops earlier, when a correction is more than half as large as the previous one.
constexpr int max_rounds = 6;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace

/// residual_ <- r + J^T lambda - M x. M x is computed from the links' momenta at the velocities x. @param with_loops false: no J^T lambda
void ClosedImpulse::calc_residual(const Mechanism& m, Workspace& ws, const ClosedLinks& closed, std::span<const double> r,
                                  std::span<const double> x, bool with_loops) {
  const int links = m.link_count();
  for (int i = 0; i < links; ++i) {
    const Link& link = m.link(i);
    Vec6 V = link.parent >= 0 ? ws.A[at(link.parent)] : Vec6{};
    for (int f = link.v_index; f < link.v_index + link.joint.nv(); ++f) V += ws.S[at(f)] * x[at(f)];
    ws.A[at(i)] = V;
    ws.pA[at(i)] = ws.I[at(i)] * V;
  }
  for (std::size_t f = 0; f < residual_.size(); ++f) residual_[f] = r[f] - ws.armature[f] * x[f];
  const LoopRows& rows = closed.rows();
  for (std::size_t i = 0; with_loops && i < closed.loops().size(); ++i) {
    const Loop& loop = closed.loops()[i];
    for (int k = rows.first[i]; k < rows.first[i + 1]; ++k) {
      const double p = lambda_[at(k)];
      if (loop.type == LoopType::gear) {
        residual_[at(loop.dof_a)] += p;
        residual_[at(loop.dof_b)] -= rows.slope[i] * p;
        continue;
      }
      const Vec6 wrench = rows.W[at(k)] * p;
      if (loop.link_b >= 0) ws.pA[at(loop.link_b)] -= wrench;
      if (loop.link_a >= 0) ws.pA[at(loop.link_a)] += wrench;
    }
  }
  for (int i = links; i-- > 0;) {
    const Link& link = m.link(i);
    for (int f = link.v_index; f < link.v_index + link.joint.nv(); ++f) residual_[at(f)] -= dot(ws.S[at(f)], ws.pA[at(i)]);
    if (link.parent >= 0) ws.pA[at(link.parent)] += ws.pA[at(i)];
  }
}

/// Corrects x for every tree that no loop connects to the world or to another tree: the residual impulse on the root's DOFs is applied
/// to the whole tree as one rigid body.
void ClosedImpulse::balance_trees(const Mechanism& m, Workspace& ws, const ClosedLinks& closed, std::span<const double> r,
                                  std::span<double> x) {
  tree_.resize(m.links().size());
  tied_.assign(m.links().size(), 0);
  for (int i = 0; i < m.link_count(); ++i) tree_[at(i)] = m.link(i).parent < 0 ? i : tree_[at(m.link(i).parent)];
  for (std::size_t i = 0; i < closed.loops().size(); ++i) {
    const Loop& loop = closed.loops()[i];
    if (!closed.is_closed(static_cast<int>(i))) continue;
    int a = loop.link_a, b = loop.link_b;
    if (loop.type == LoopType::gear) {  // a gear acts on joint coordinates, so it ties only trees whose root has dof_a or dof_b
      a = m.link_of_dof(loop.dof_a);
      b = m.link_of_dof(loop.dof_b);
      for (const int link : {a, b})
        if (m.link(link).parent < 0) tied_[at(link)] = 1;
      continue;
    }
    if (a >= 0 && b >= 0 && tree_[at(a)] == tree_[at(b)]) continue;
    for (const int link : {a, b})
      if (link >= 0) tied_[at(tree_[at(link)])] = 1;
  }
  for (int root = 0; root < m.link_count(); ++root) {
    const Link& link = m.link(root);
    const int n = link.joint.nv(), first = link.v_index;
    if (link.parent >= 0 || tied_[at(root)] || n == 0) continue;
    Inertia tree_inertia;
    for (int i = 0; i < m.link_count(); ++i)
      if (tree_[at(i)] == root) tree_inertia += ws.I[at(i)];
    double M[36], change[6];
    for (int i = 0; i < n; ++i) {
      const Vec6 h = tree_inertia * ws.S[at(first + i)];
      for (int j = 0; j < n; ++j) M[i * n + j] = dot(ws.S[at(first + j)], h) + (i == j ? ws.armature[at(first + i)] : 0.0);
    }
    if (!factor_cholesky({M, at(n * n)}, n, 1e-14)) continue;
    for (int pass = 0; pass < 2; ++pass) {  // the second pass removes the rounding error of the first
      calc_residual(m, ws, closed, r, x, false);
      std::copy_n(residual_.data() + first, n, change);
      solve_cholesky({M, at(n * n)}, n, {change, at(n)});
      for (int k = 0; k < n; ++k) x[at(first + k)] += change[k];
    }
  }
}

/// Solves M x = r + J^T lambda, J (v + x) = 0 by iterative refinement (symbols: closed_impulse.h).
void ClosedImpulse::refine(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<const double> r, std::span<const double> v,
                           std::span<double> x) {
  for (std::vector<double>* array : {&residual_, &delta_, &sum_}) array->resize(x.size());
  std::ranges::fill(x, 0.0);
  lambda_.assign(closed.multipliers().size(), 0.0);
  double before = HUGE_VAL;
  for (int round = 0; round < max_rounds; ++round) {
    calc_residual(m, ws, closed, r, x, true);
    for (std::size_t f = 0; f < x.size(); ++f) sum_[f] = v[f] + x[f];
    solve_closed_links(m, ws, closed, residual_, sum_, delta_);
    double size = 0;
    for (const double d : delta_) size = std::max(size, std::fabs(d));
    if (!(size < 0.5 * before)) break;  // corrections that stop shrinking are rounding errors: x is accurate
    before = size;
    for (std::size_t f = 0; f < x.size(); ++f) x[f] += delta_[f];
    for (std::size_t k = 0; k < lambda_.size(); ++k) lambda_[k] += closed.multipliers()[k];
  }
  balance_trees(m, ws, closed, r, x);
}

void ClosedImpulse::solve(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<const double> r, std::span<double> x) {
  zero_.assign(x.size(), 0.0);
  refine(m, ws, closed, r, zero_, x);
}

void ClosedImpulse::project(const Mechanism& m, Workspace& ws, ClosedLinks& closed, std::span<double> v) {
  zero_.assign(v.size(), 0.0);
  change_.resize(v.size());
  refine(m, ws, closed, zero_, v, change_);
  for (std::size_t f = 0; f < v.size(); ++f) v[f] += change_[f];
}

}  // namespace ugoki::dynamics
