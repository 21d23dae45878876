#include "ugoki/motion/limb_reach.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace ugoki {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// What one freedom does to the end: its place, then its orientation times the lever.
using Column = std::array<double, 6>;

/// Solves the symmetric positive definite A x = b in place.
void solve_spd(std::array<std::array<double, 6>, 6>& A, std::array<double, 6>& b) {
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = i + 1; j < 6; ++j) {
      const double factor = A[j][i] / A[i][i];
      for (std::size_t k = i; k < 6; ++k) A[j][k] -= factor * A[i][k];
      b[j] -= factor * b[i];
    }
  for (std::size_t i = 6; i-- > 0;) {
    for (std::size_t k = i + 1; k < 6; ++k) b[i] -= A[i][k] * b[k];
    b[i] /= A[i][i];
  }
}

}  // namespace

double reach(const Mechanism& m, std::span<const int> limb, const Pose& X_goal, const ReachOptions& o, double* q, std::span<Pose> X_WB) {
  const auto end = at(limb.back());
  std::vector<Column> columns;
  for (int iteration = 0;; ++iteration) {
    const Pose& X_WE = X_WB[end];
    const Vec3 place = X_goal.p - X_WE.p, turn = log_map(to_quat(X_goal.R * X_WE.R.transposed())) * o.lever;
    const double miss = dot(place, place) + dot(turn, turn);
    if (miss < o.enough * o.enough || iteration == o.iterations) return std::sqrt(miss);
    columns.clear();
    for (const int i : limb) {
      const Link& link = m.link(i);
      const Pose& X = X_WB[at(i)];
      Vec6 S[6];
      for (int k = 0, n = joint_subspace(link.joint, q + link.q_index, S); k < n; ++k) {
        const Vec3 w = X.R * S[k].w, v = X.R * S[k].v + cross(w, X_WE.p - X.p);
        columns.push_back({v.x, v.y, v.z, o.lever * w.x, o.lever * w.y, o.lever * w.z});
      }
    }
    std::array<double, 6> y = {place.x, place.y, place.z, turn.x, turn.y, turn.z};
    std::array<std::array<double, 6>, 6> A{};
    for (std::size_t r = 0; r < 6; ++r) {
      A[r][r] = o.damping * o.damping;
      for (std::size_t s = 0; s < 6; ++s)
        for (const Column& c : columns) A[r][s] += c[r] * c[s];
    }
    solve_spd(A, y);
    std::size_t c = 0;
    for (const int i : limb) {
      const Link& link = m.link(i);
      const Joint& joint = link.joint;
      double step[6] = {0, 0, 0, 0, 0, 0};
      for (int k = 0; k < joint.nv(); ++k, ++c)
        for (std::size_t r = 0; r < 6; ++r) step[k] += columns[c][r] * y[r];
      double* own = q + link.q_index;
      const double before = own[0];
      joint_integrate(joint, own, step, 1.0, own);
      if (joint.type == JointType::revolute)
        own[0] = std::clamp(own[0], std::min(before, joint.freedoms[0].lower), std::max(before, joint.freedoms[0].upper));
    }
    for (const int i : limb) {
      const Link& link = m.link(i);
      const Pose X_PB = link.joint.X_PJ * joint_pose(link.joint, q + link.q_index);
      X_WB[at(i)] = link.parent < 0 ? X_PB : X_WB[at(link.parent)] * X_PB;
    }
  }
}

}  // namespace ugoki
