#include "ugoki/control/loop_drives.h"

#include <algorithm>

#include "ugoki/dynamics/dense.h"

namespace ugoki::control {
namespace {

// Price of a torque at a joint without a drive, as a multiple of the largest price of a drive. The relative error of the transmitted torque
// is its reciprocal; larger values cost digits of the normal equations.
constexpr double undriven_price = 1e6;
// Added to the diagonal of the normal equations, as a fraction of it: rows that depend on others then get a small multiplier.
constexpr double regularization = 1e-10;

std::vector<Loop> loops_within(const Mechanism& m) {
  const bool floating = m.link_count() > 0 && m.link(0).joint.type == JointType::floating;
  std::vector<Loop> loops;
  for (const Loop& loop : m.loops()) {
    if (!loop.closed || loop.of_virtual_link) continue;
    const bool to_world = loop.type != LoopType::gear && (loop.link_a < 0 || loop.link_b < 0);
    if (!(to_world && floating)) loops.push_back(loop);
  }
  return loops;
}

}  // namespace

LoopDrives::LoopDrives(const Mechanism& m, std::span<const double> strength) : loops_(loops_within(m)), rows_(loops_) {
  if (loops_.empty()) return;
  const auto n = static_cast<std::size_t>(m.nv());
  const auto rows = static_cast<std::size_t>(rows_.count());
  const std::size_t root_dofs = m.link(0).joint.type == JointType::floating ? 6 : 0;
  J_.resize(rows * n);
  A_.resize(rows * rows);
  x_.resize(rows);
  weight_.resize(n);
  in_loop_.resize(n);
  double max_weight = 0;
  for (std::size_t i = root_dofs; i < n; ++i)
    if (strength[i] > 0) max_weight = std::max(max_weight, weight_[i] = 1 / (strength[i] * strength[i]));
  for (std::size_t i = root_dofs; i < n; ++i)
    if (!(strength[i] > 0)) weight_[i] = undriven_price * (max_weight > 0 ? max_weight : 1);
  for (const Loop& loop : loops_) {
    if (loop.type == LoopType::gear) {
      in_loop_[static_cast<std::size_t>(loop.dof_a)] = in_loop_[static_cast<std::size_t>(loop.dof_b)] = 1;
      continue;
    }
    for (int a = loop.link_a, b = loop.link_b; a != b;) {
      int& deeper = a > b ? a : b;
      const Link& link = m.link(deeper);
      for (int k = link.v_index; k < link.v_index + link.joint.nv(); ++k) in_loop_[static_cast<std::size_t>(k)] = 1;
      deeper = link.parent;
    }
  }
}

void LoopDrives::distribute(const Mechanism& m, const dynamics::Workspace& ws, std::span<const double> q, std::span<const double> v,
                            std::span<double> tau) {
  const auto n = static_cast<std::size_t>(m.nv());
  const auto rows = static_cast<std::size_t>(rows_.count());
  dynamics::update_loop_rows(m, ws, loops_, q, v, rows_);
  std::size_t row = 0;
  for (std::size_t i = 0; i < loops_.size(); ++i)
    for (int r = 0; r < loops_[i].rows(); ++r, ++row)
      dynamics::calc_loop_jacobian_row(m, ws, loops_[i], rows_, static_cast<int>(i), r, std::span(J_).subspan(row * n, n));
  // minimum of sum weight (tau + J^T lambda)^2
  for (std::size_t a = 0; a < rows; ++a) {
    const double* Ja = J_.data() + a * n;
    x_[a] = 0;
    for (std::size_t i = 0; i < n; ++i) x_[a] -= Ja[i] * weight_[i] * tau[i];
    for (std::size_t b = 0; b <= a; ++b) {
      const double* Jb = J_.data() + b * n;
      double sum = 0;
      for (std::size_t i = 0; i < n; ++i) sum += Ja[i] * weight_[i] * Jb[i];
      A_[a * rows + b] = sum;
    }
  }
  double scale = 0;
  for (std::size_t a = 0; a < rows; ++a) scale = std::max(scale, A_[a * rows + a]);
  if (!(scale > 0)) return;
  for (std::size_t a = 0; a < rows; ++a) A_[a * rows + a] += regularization * std::max(A_[a * rows + a], regularization * scale);
  if (!dynamics::factor_cholesky(A_, static_cast<int>(rows), 0)) return;
  dynamics::solve_cholesky(A_, static_cast<int>(rows), x_);
  for (std::size_t a = 0; a < rows; ++a)
    for (std::size_t i = 0; i < n; ++i)
      if (weight_[i] > 0) tau[i] += J_[a * n + i] * x_[a];
}

}  // namespace ugoki::control
