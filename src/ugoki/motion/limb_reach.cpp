#include "ugoki/motion/limb_reach.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace ugoki {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Column of the Jacobian of the limb's end for one DOF: linear velocity, then angular velocity times the lever. World axes.
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

/// Returns (J J^T + damping^2 1)^-1 y, J being the Jacobian of the limb's end. The joint step for a step y of the end is J^T times this
/// vector. @param columns of J
std::array<double, 6> solve_damped(std::span<const Column> columns, std::array<double, 6> y, double damping) {
  std::array<std::array<double, 6>, 6> A{};
  for (std::size_t r = 0; r < 6; ++r) {
    A[r][r] = damping * damping;
    for (std::size_t s = 0; s < 6; ++s)
      for (const Column& c : columns) A[r][s] += c[r] * c[s];
  }
  solve_spd(A, y);
  return y;
}

void find_columns(const Mechanism& m, std::span<const int> limb, const ReachOptions& o, const double* q, std::span<const Pose> X_WB,
                  std::vector<Column>& columns) {
  const Vec3 end = X_WB[at(limb.back())].p;
  columns.clear();
  for (const int i : limb) {
    const Link& link = m.link(i);
    const Pose& X = X_WB[at(i)];
    Vec6 S[6];
    for (int k = 0, n = joint_subspace(link.joint, q + link.q_index, S); k < n; ++k) {
      const Vec3 w = X.R * S[k].w, v = X.R * S[k].v + cross(w, end - X.p);
      columns.push_back(i == o.held ? Column{} : Column{v.x, v.y, v.z, o.lever * w.x, o.lever * w.y, o.lever * w.z});
    }
  }
}

/// Computes the displacement of each DOF of the limb from its present coordinates to `start`.
/// @param start coordinates of the limb's joints, one joint after the other  @param displacement [DOFs of the limb, out]
void find_displacement_to_start(const Mechanism& m, std::span<const int> limb, const double* q, const double* start,
                                std::vector<double>& displacement) {
  displacement.clear();
  for (const int i : limb) {
    const Link& link = m.link(i);
    double d[6];
    joint_difference(link.joint, q + link.q_index, start, d);
    displacement.insert(displacement.end(), d, d + link.joint.nv());
    start += link.joint.nq();
  }
}

void move(const Mechanism& m, std::span<const int> limb, std::span<const double> step, double* q) {
  const double* own_step = step.data();
  for (const int i : limb) {
    const Link& link = m.link(i);
    const Joint& joint = link.joint;
    double* own = q + link.q_index;
    const double before = own[0];
    joint_integrate(joint, own, own_step, 1.0, own);
    own_step += joint.nv();
    if (joint.type == JointType::revolute)
      own[0] = std::clamp(own[0], std::min(before, joint.dofs[0].lower), std::max(before, joint.dofs[0].upper));
  }
}

void copy_joints(const Mechanism& m, std::span<const int> limb, const double* q, std::vector<double>& out) {
  out.clear();
  for (const int i : limb) out.insert(out.end(), q + m.link(i).q_index, q + m.link(i).q_index + m.link(i).joint.nq());
}

void set_joints(const Mechanism& m, std::span<const int> limb, const double* values, double* q) {
  for (const int i : limb) {
    std::copy(values, values + m.link(i).joint.nq(), q + m.link(i).q_index);
    values += m.link(i).joint.nq();
  }
}

void update_poses(const Mechanism& m, std::span<const int> limb, const double* q, std::span<Pose> X_WB) {
  for (const int i : limb) {
    const Link& link = m.link(i);
    const Pose X_PB = link.joint.X_PJ * joint_pose(link.joint, q + link.q_index);
    X_WB[at(i)] = link.parent < 0 ? X_PB : X_WB[at(link.parent)] * X_PB;
  }
}

}  // namespace

double reach(const Mechanism& m, std::span<const int> limb, const Pose& X_goal, const ReachOptions& o, double* q, std::span<Pose> X_WB) {
  const auto error = [&] {
    const Pose& X = X_WB[at(limb.back())];
    const Vec3 d = X_goal.p - X.p, turn = log_map(to_quat(X_goal.R * X.R.transposed())) * o.lever;
    return std::array<double, 6>{d.x, d.y, d.z, turn.x, turn.y, turn.z};
  };
  const auto size = [](const std::array<double, 6>& y) {
    double sum = 0;
    for (const double x : y) sum += x * x;
    return std::sqrt(sum);
  };
  std::vector<Column> columns;
  std::vector<double> start, before, back, step;
  copy_joints(m, limb, q, start);
  find_displacement_to_start(m, limb, q, start.data(), back);
  std::array<double, 6> y = error();
  const auto cost_of = [&](double miss) {
    double displacement = 0;
    for (const double x : back) displacement += x * x;
    return miss * miss + (o.keep ? o.damping * o.damping * displacement : 0.0);
  };
  double miss = size(y), cost = cost_of(miss), share = 1;
  for (int iteration = 0; iteration < o.iterations && miss >= o.enough; ++iteration) {
    find_columns(m, limb, o, q, X_WB, columns);
    if (!o.keep) std::fill(back.begin(), back.end(), 0.0);
    for (std::size_t r = 0; r < 6; ++r)
      for (std::size_t c = 0; c < columns.size(); ++c) y[r] -= columns[c][r] * back[c];
    y = solve_damped(columns, y, o.damping);
    step = back;
    double maximum = 0;
    for (std::size_t c = 0; c < columns.size(); ++c) {
      for (std::size_t r = 0; r < 6; ++r) step[c] += columns[c][r] * y[r];
      step[c] *= share;
      maximum = std::max(maximum, std::fabs(step[c]));
    }
    copy_joints(m, limb, q, before);
    move(m, limb, step, q);
    update_poses(m, limb, q, X_WB);
    y = error();
    find_displacement_to_start(m, limb, q, start.data(), back);
    const double now = size(y);
    if (const double next = cost_of(now); next < cost) {
      cost = next;
      miss = now;
      share = std::min(1.0, 2 * share);
    } else {  // the step did not reduce the cost: undo it and try a shorter one
      set_joints(m, limb, before.data(), q);
      update_poses(m, limb, q, X_WB);
      y = error();
      find_displacement_to_start(m, limb, q, start.data(), back);
      share *= 0.25;
    }
    if (maximum < 1e-7) break;
  }
  return miss;
}

}  // namespace ugoki
