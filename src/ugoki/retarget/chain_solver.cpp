#include "ugoki/retarget/chain_solver.h"

#include <algorithm>
#include <cmath>

namespace ugoki::retarget {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

Quat quat_of(const double* q) { return {q[0], q[1], q[2], q[3]}; }
void set_quat(const Quat& r, double* q) {
  // q and -q are the same rotation: choose the sign closest to the previous value, so that coordinates stay continuous.
  const double sign = r.w * q[0] + r.x * q[1] + r.y * q[2] + r.z * q[3] < 0 ? -1.0 : 1.0;
  q[0] = sign * r.w;
  q[1] = sign * r.x;
  q[2] = sign * r.y;
  q[3] = sign * r.z;
}

/// Column k of the right Jacobian of SO(3): angular velocity in the body frame per unit rate of the rotation vector's component k.
Vec3 right_jacobian_column(const Vec3& x, int k) {
  const double angle2 = dot(x, x);
  Vec3 e;
  e[k] = 1;
  const Vec3 c = cross(x, e), cc = cross(x, c);
  if (angle2 < 1e-8) return e - c * 0.5 + cc * (1.0 / 6);
  const double angle = std::sqrt(angle2);
  const SinCos sc = sin_cos(angle);
  return e - c * ((1 - sc.cos) / angle2) + cc * ((angle - sc.sin) / (angle2 * angle));
}

}  // namespace

ChainSolver::ChainSolver(const Mechanism& mechanism) : m_(mechanism) {
  for (int i = 0; i < m_.nv(); ++i) {
    // Limits are narrowed by at most 1e-9, so that rounding in quaternions never leaves the mechanism's limits.
    const Dof& f = m_.dof(i);
    const double inset = std::min(1e-9, 0.25 * (f.upper - f.lower));
    lower.push_back(f.lower + inset);
    upper.push_back(f.upper - inset);
  }
  columns_.reserve(at(m_.nv()));
}

void ChainSolver::place(int link, const double* q, std::span<Pose> X_WB) const {
  const Link& l = m_.link(link);
  const Pose X_PB = l.joint.X_PJ * joint_pose(l.joint, q + l.q_index);
  X_WB[at(link)] = l.parent < 0 ? X_PB : X_WB[at(l.parent)] * X_PB;
}

bool ChainSolver::clamp(int link, double* q) const {
  const Link& l = m_.link(link);
  if (l.joint.type == JointType::floating || l.joint.type == JointType::fixed) return false;
  double* own = q + l.q_index;
  if (l.joint.type != JointType::spherical) {
    bool outside = false;
    for (int k = 0; k < l.joint.nv(); ++k) {
      const double x = std::clamp(own[k], lower[at(l.v_index + k)], upper[at(l.v_index + k)]);
      outside = outside || x != own[k];
      own[k] = x;
    }
    return outside;
  }
  bool limited = false;
  for (int k = 0; k < 3; ++k) limited = limited || std::isfinite(lower[at(l.v_index + k)]) || std::isfinite(upper[at(l.v_index + k)]);
  if (!limited) return false;
  const Vec3 x = log_map(quat_of(own));
  Vec3 inside;
  for (int k = 0; k < 3; ++k) inside[k] = std::clamp(x[k], lower[at(l.v_index + k)], upper[at(l.v_index + k)]);
  if (inside == x) return false;
  set_quat(exp_map(inside), own);
  return true;
}

bool ChainSolver::orient(int link, const Mat3& R_WB, double* q, std::span<Pose> X_WB) const {
  const Link& l = m_.link(link);
  const Mat3 R_WJ = l.parent < 0 ? l.joint.X_PJ.R : X_WB[at(l.parent)].R * l.joint.X_PJ.R;
  const Quat turn = to_quat(R_WJ.transposed() * R_WB);
  double* own = q + l.q_index;
  bool there = false;
  switch (l.joint.type) {
    case JointType::spherical:
      set_quat(turn, own);
      there = !clamp(link, q);
      break;
    case JointType::floating:
      set_quat(turn, own + 3);
      there = true;
      break;
    case JointType::revolute: {
      // The closest rotation about a given axis is the twist part of the swing-twist decomposition.
      double angle = 2 * atan2(dot(turn.vec(), l.joint.axis), turn.w);
      const double middle =
          std::isfinite(lower[at(l.v_index)] + upper[at(l.v_index)]) ? 0.5 * (lower[at(l.v_index)] + upper[at(l.v_index)]) : own[0];
      angle -= 2 * pi * std::floor((angle - middle) / (2 * pi) + 0.5);
      own[0] = angle;
      clamp(link, q);
      break;
    }
    default: break;
  }
  place(link, q, X_WB);
  if (l.joint.type == JointType::revolute) {
    const Mat3 off = X_WB[at(link)].R.transposed() * R_WB;
    there = off.trace() > 3 - 1e-14;
  }
  return there;
}

void ChainSolver::gather(std::span<const int> chain, const double* q, std::span<const Pose> X_WB) {
  columns_.clear();
  for (const int i : chain) {
    const Link& l = m_.link(i);
    const Pose& X = X_WB[at(i)];
    const double* own = q + l.q_index;
    if (l.joint.type == JointType::spherical) {
      const Vec3 x = log_map(quat_of(own));
      for (int k = 0; k < 3; ++k) {
        Column& c = columns_.emplace_back();
        c.link = i;
        c.dof = k;
        c.w = X.R * right_jacobian_column(x, k);
        c.x = x[k];
      }
      continue;
    }
    if (l.joint.type == JointType::floating) continue;
    Vec6 S[6];
    for (int k = 0, n = joint_subspace(l.joint, own, S); k < n; ++k) {
      Column& c = columns_.emplace_back();
      c.link = i;
      c.dof = k;
      c.w = X.R * S[k].w;
      c.v = X.R * S[k].v;
      c.x = own[k];
    }
  }
}

void ChainSolver::find_step(const Vec3& first, const Vec3& turn_error, const Vec3& along, double damping, bool turn) {
  for (Column& c : columns_) c.at_limit = false;
  Vec3 e1 = first, e2 = turn_error;
  for (int round = 0; round < 6; ++round) {
    Mat3 A = Mat3::diagonal(damping, damping, damping) + Mat3::outer(along, along), K{};
    for (const Column& c : columns_) {
      if (c.at_limit) continue;
      A += Mat3::outer(c.J1, c.J1);
      if (turn) K += Mat3::outer(c.J2, c.J1);
    }
    const Mat3 A_inverse = inverse(A);
    const Vec3 y = A_inverse * e1;
    for (Column& c : columns_)
      if (!c.at_limit) c.step = dot(c.J1, y);
    if (turn) {
      const Mat3 M = K * A_inverse;
      Vec3 rest = e2;
      Mat3 B = Mat3::diagonal(1e-4, 1e-4, 1e-4);
      for (const Column& c : columns_) {
        if (c.at_limit) continue;
        rest -= c.J2 * c.step;
        const Vec3 n = c.J2 - M * c.J1;
        B += Mat3::outer(n, n);
      }
      const Vec3 z = inverse(B) * rest;
      for (Column& c : columns_)
        if (!c.at_limit) c.step += dot(c.J2 - M * c.J1, z);
    }
    // A DOF that would pass its limit is set to the limit; the step is re-solved for the other DOFs with the remaining error.
    bool changed = false;
    for (Column& c : columns_) {
      if (c.at_limit) continue;
      const int f = m_.link(c.link).v_index + c.dof;
      const double inside = std::clamp(c.x + c.step, lower[at(f)], upper[at(f)]) - c.x;
      if (inside == c.step) continue;
      c.step = inside;
      c.at_limit = true;
      changed = true;
      e1 -= c.J1 * inside;
      e2 -= c.J2 * inside;
    }
    if (!changed) return;
  }
}

Mat3 ChainSolver::resistance(std::span<const int> chain, const Vec3& point, const Vec3& wish, double length, const double* q,
                             std::span<const Pose> X_WB) {
  // softness: regularization (dimensionless, because J is divided by the length). near_limit: rad | m; a DOF whose distance from its limit
  // is smaller counts as at the limit.
  constexpr double softness = 1e-3, near_limit = 1e-3;
  gather(chain, q, X_WB);
  Mat3 A = Mat3::diagonal(softness, softness, softness);
  for (const Column& c : columns_) {
    const Vec3 J = (c.v + cross(c.w, point - X_WB[at(c.link)].p)) / length;
    const int f = m_.link(c.link).v_index + c.dof;
    const double rate = dot(J, wish);
    if ((rate > 0 && c.x > upper[at(f)] - near_limit) || (rate < 0 && c.x < lower[at(f)] + near_limit)) continue;
    A += Mat3::outer(J, J);
  }
  return inverse(A) * softness;
}

void ChainSolver::apply(std::span<const int> chain, double share, double* q, std::span<Pose> X_WB) {
  std::size_t next = 0;
  for (const int i : chain) {
    const Link& l = m_.link(i);
    double* own = q + l.q_index;
    if (l.joint.type == JointType::floating) continue;
    if (l.joint.type == JointType::spherical) {
      Vec3 x;
      for (int k = 0; k < 3; ++k, ++next)
        x[k] = std::clamp(columns_[next].x + share * columns_[next].step, lower[at(l.v_index + k)], upper[at(l.v_index + k)]);
      set_quat(exp_map(x), own);
      clamp(i, q);  // clamped rotation vector may be longer than pi; the equivalent shorter one may be outside the limits
    } else {
      for (int k = 0; k < l.joint.nv(); ++k, ++next)
        own[k] = std::clamp(columns_[next].x + share * columns_[next].step, lower[at(l.v_index + k)], upper[at(l.v_index + k)]);
    }
    place(i, q, X_WB);
  }
}

void ChainSolver::save(std::span<const int> chain, const double* q) {
  saved_.clear();
  for (const int i : chain) {
    const Link& l = m_.link(i);
    saved_.insert(saved_.end(), q + l.q_index, q + l.q_index + l.joint.nq());
  }
}

void ChainSolver::restore(std::span<const int> chain, double* q, std::span<Pose> X_WB) const {
  const double* from = saved_.data();
  for (const int i : chain) {
    const Link& l = m_.link(i);
    std::copy_n(from, l.joint.nq(), q + l.q_index);
    from += l.joint.nq();
    place(i, q, X_WB);
  }
}

ChainSolver::Miss ChainSolver::miss_of(const ChainGoal& goal, const Pose& X) {
  Miss out;
  if (goal.first == ChainGoal::First::direction) {
    out.point = X.R * goal.point;
    out.first = log_map(rotation_between(out.point, goal.target));
  } else {
    out.point = X * goal.point;
    out.first = (goal.target - out.point) / goal.length;
  }
  if (goal.turn) out.turn = log_map(to_quat(goal.R * X.R.transposed()));
  out.cost = dot(out.first, out.first) + 0.01 * dot(out.turn, out.turn);
  return out;
}

double ChainSolver::solve(std::span<const int> chain, const ChainGoal& goal, double* q, std::span<Pose> X_WB) {
  constexpr double enough = 1e-9;  // rad or share of the chain's size: at a smaller error the goal counts as reached
  const int end = chain.back();
  const bool direct = goal.first == ChainGoal::First::direction;
  const double scale = direct ? 1 : goal.length;
  Miss miss = miss_of(goal, X_WB[at(end)]);
  double share = 1;
  for (int iteration = 0; iteration < goal.iterations; ++iteration) {
    if (norm(miss.first) < enough && norm(miss.turn) < enough) break;
    gather(chain, q, X_WB);
    for (Column& c : columns_) {
      c.J1 = direct ? c.w - miss.point * dot(miss.point, c.w) : (c.v + cross(c.w, miss.point - X_WB[at(c.link)].p)) / scale;
      c.J2 = c.w;
    }
    find_step(miss.first, miss.turn, direct ? miss.point : Vec3{}, 1e-8 + 0.01 * dot(miss.first, miss.first), goal.turn);
    double longest = 0;
    for (const Column& c : columns_) longest = std::max(longest, std::fabs(c.step));
    if (longest < 1e-12) break;
    // Limit steps to 0.5 (rad | m), where the linearization is still valid, and accept only steps that reduce the cost.
    save(chain, q);
    share = std::min(share, longest > 0.5 ? 0.5 / longest : 1.0);
    bool better = false;
    for (int attempt = 0; attempt < 4 && !better; ++attempt) {
      apply(chain, share, q, X_WB);
      const Miss after = miss_of(goal, X_WB[at(end)]);
      better = after.cost < miss.cost;
      if (!better) {
        restore(chain, q, X_WB);
        share *= 0.3;
        continue;
      }
      const bool slow = after.cost > 0.9999 * miss.cost;
      miss = after;
      share = std::min(1.0, 2 * share);
      if (slow) iteration = goal.iterations;
    }
    if (!better) break;
  }
  return norm(miss.first) * scale;
}

}  // namespace ugoki::retarget
