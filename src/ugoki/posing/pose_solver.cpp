#include "ugoki/posing/pose_solver.h"

#include <algorithm>
#include <cmath>

#include "ugoki/dynamics/dense.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/posing/pose_goals.h"

namespace ugoki::posing {
namespace {

constexpr double max_turn = 0.5;     // rad, maximum rotation of a joint in one iteration: the linearisation is valid within this range
constexpr double root_factor = 6;    // the root's displacement counts this much more than that of a joint, so that limbs move first
constexpr double missed = 1e-3;      // m: goals with a larger error were not reached
constexpr double bend = 0.15;        // rad: a bend of this size gives a stretched limb a direction in which to shorten
constexpr double small_step = 1e-7;  // rad: the iteration stops when no DOF moves farther

std::size_t at(int i) { return static_cast<std::size_t>(i); }

bool is_translation(const Joint& joint, int dof) {
  switch (joint.type) {
    case JointType::prismatic: return true;
    case JointType::cylindrical: return dof == 1;
    case JointType::planar: return dof < 2;
    case JointType::floating: return dof >= 3;
    default: return false;
  }
}

class Solver {
 public:
  Solver(const Mechanism& m, std::span<const PoseGoal> goals, const PoseSolverOptions& options, std::span<double> q)
      : m_(m), goals_(goals), o_(options), q_(q), start_(q.begin(), q.end()), trial_(start_), X_WB_(at(m.link_count())) {
    for (int i = 0; i < m.link_count(); ++i) {
      const Joint& joint = m.link(i).joint;
      if (!o_.moves.empty() && o_.moves[at(i)] == 0) continue;
      for (int k = 0; k < joint.nv(); ++k) {
        variables_.push_back({i, k, {}});
        const double factor = joint.type == JointType::floating ? root_factor : 1;
        const double unit = is_translation(joint, k) ? lever : 1;
        stiffness_.push_back(o_.stiffness * o_.stiffness * factor / (unit * unit));
      }
    }
  }

  /// Solves from the initial pose. If goals are missed, a stretched limb may be the reason: no first-order motion bends it. Then the pose
  /// with hinges bent away from their limits is tried as a second start.
  double run() {
    const double cost = descend();
    if (worst_error() > missed) {
      const std::vector<double> first(q_.begin(), q_.end());
      std::copy(start_.begin(), start_.end(), q_.begin());
      const bool better = bend_hinges() && descend() < cost;
      if (!better) std::copy(first.begin(), first.end(), q_.begin());
    }
    return worst_error();
  }

 private:
  /// Levenberg-Marquardt iterations from q_. @return the cost
  double descend() {
    const int n = static_cast<int>(variables_.size());
    double cost = calc_cost(q_, equations_);
    double damping = 1e-4;  // of Levenberg and Marquardt, m^2/rad^2
    for (int i = 0; i < o_.iterations && n > 0; ++i) {
      find_step(damping);
      const double moved = apply(trial_);
      const double next = calc_cost(trial_, next_equations_);
      if (next < cost) {
        std::copy(trial_.begin(), trial_.end(), q_.begin());
        std::swap(equations_, next_equations_);
        cost = next;
        damping = std::max(damping * 0.2, 1e-9);
        if (moved < small_step) break;
      } else {
        damping *= 8;
        if (damping > 1e4) break;
        calc_cost(q_, equations_);  // X_WB_ and the variables belong to q_ again
      }
    }
    return cost;
  }

  double worst_error() {
    calc_poses(m_, q_, X_WB_);
    double worst = 0;
    for (const PoseGoal& g : goals_) worst = std::max(worst, norm(X_WB_[at(g.link)] * g.point - g.target));
    return worst;
  }

  /// Turns the hinges that are close to a limit away from it. @return whether there is one
  bool bend_hinges() {
    bool found = false;
    for (const Variable& x : variables_) {
      const Link& link = m_.link(x.link);
      if (link.joint.type != JointType::revolute) continue;
      double& angle = q_[at(link.q_index)];
      const Dof& dof = link.joint.dofs[0];
      const double way = angle - dof.lower < bend ? 1 : dof.upper - angle < bend ? -1 : 0;
      if (way == 0 || dof.upper - dof.lower < 2 * bend) continue;
      angle += way * bend;
      found = true;
    }
    return found;
  }

  /// Sum of squared residuals and of squared displacements. Also updates poses, variables and equations.
  double calc_cost(std::span<const double> q, Equations& equations) {
    calc_poses(m_, q, X_WB_);
    Vec6 S[6];
    int link = -1;
    for (Variable& x : variables_) {
      if (x.link != link) joint_subspace(m_.link(x.link).joint, q.data() + m_.link(x.link).q_index, S);
      link = x.link;
      const Pose& X = X_WB_[at(link)];
      const Vec3 w = X.R * S[x.dof].w;
      x.S = {w, X.R * S[x.dof].v - cross(w, X.p)};
    }
    write_equations(m_, goals_, variables_, q, X_WB_, equations);
    displacement_.resize(at(m_.nv()));
    difference(m_, start_, q, displacement_);
    double sum = 0;
    for (const double r : equations.residual) sum += r * r;
    for (std::size_t k = 0; k < variables_.size(); ++k) {
      const double d = displacement_[at(m_.link(variables_[k].link).v_index + variables_[k].dof)];
      sum += stiffness_[k] * d * d;
    }
    return sum;
  }

  /// Solves (J^T J + K + damping) step = -J^T residual - K displacement. DOFs that would leave their limits are fixed, and the step is
  /// solved again for the others.
  void find_step(double damping) {
    const std::size_t n = variables_.size();
    difference(m_, start_, q_, displacement_);
    A_.assign(n * n, 0);
    b_.assign(n, 0);
    for (int r = 0; r < equations_.count; ++r) {
      const double* row = equations_.J.data() + at(r) * n;
      for (std::size_t i = 0; i < n; ++i) {
        if (row[i] == 0) continue;
        b_[i] -= row[i] * equations_.residual[at(r)];
        for (std::size_t j = 0; j <= i; ++j) A_[i * n + j] += row[i] * row[j];
      }
    }
    for (std::size_t i = 0; i < n; ++i) {
      A_[i * n + i] += stiffness_[i] + damping;
      b_[i] -= stiffness_[i] * displacement_[at(m_.link(variables_[i].link).v_index + variables_[i].dof)];
    }
    fixed_.assign(n, 0);
    for (std::size_t round = 0; round <= n; ++round) {
      std::vector<double> L = A_;
      step_ = b_;
      for (std::size_t i = 0; i < n; ++i) {
        if (!fixed_[i]) continue;
        for (std::size_t j = 0; j < n; ++j) L[std::max(i, j) * n + std::min(i, j)] = i == j ? 1 : 0;
        step_[i] = 0;
      }
      if (!dynamics::factor_cholesky(L, static_cast<int>(n), 0)) {
        std::fill(step_.begin(), step_.end(), 0.0);
        return;
      }
      dynamics::solve_cholesky(L, static_cast<int>(n), step_);
      if (!o_.limits || !fix_blocked()) return;
    }
  }

  /// Fixes DOFs at a limit whose step leads outwards. @return true if there is one more
  bool fix_blocked() {
    bool found = false;
    double x[6];
    for (std::size_t k = 0; k < variables_.size(); ++k) {
      const Link& link = m_.link(variables_[k].link);
      if (fixed_[k] || link.joint.type == JointType::floating) continue;
      const Dof& dof = link.joint.dofs[at(variables_[k].dof)];
      joint_displacement(link.joint, q_.data() + link.q_index, x);
      constexpr double touching = 1e-9;  // rad | m: rounding of a coordinate that was set to its limit
      const double now = x[variables_[k].dof];
      if ((step_[k] > 0 && now >= dof.upper - touching) || (step_[k] < 0 && now <= dof.lower + touching)) fixed_[k] = found = true;
    }
    return found;
  }

  /// out = q moved by the step, shortened to max_turn and projected to the limits. @return maximum step of a DOF, rad
  double apply(std::vector<double>& out) {
    double longest = 0;
    for (std::size_t k = 0; k < variables_.size(); ++k)
      longest = std::max(longest, std::fabs(step_[k]) / (is_translation(m_.link(variables_[k].link).joint, variables_[k].dof) ? lever : 1));
    const double share = longest > max_turn ? max_turn / longest : 1;
    std::vector<double> v(at(m_.nv()), 0.0);
    for (std::size_t k = 0; k < variables_.size(); ++k) v[at(m_.link(variables_[k].link).v_index + variables_[k].dof)] = share * step_[k];
    integrate(m_, q_, v, 1, out);
    if (o_.limits) {
      int link = -1;
      for (const Variable& x : variables_)
        if (x.link != link) clamp_inwards(link = x.link, out.data());
    }
    return share * longest;
  }

  /// Clamps the joint to its limits; a DOF that was outside before may stay there, but not move farther out.
  void clamp_inwards(int i, double* out) const {
    Joint joint = m_.link(i).joint;
    double before[6];
    joint_displacement(joint, start_.data() + m_.link(i).q_index, before);
    for (int k = 0; k < joint.nv(); ++k) {
      Dof& dof = joint.dofs[at(k)];
      dof.lower = std::min(dof.lower, before[k]);
      dof.upper = std::max(dof.upper, before[k]);
    }
    clamp_to_limits(joint, out + m_.link(i).q_index);
  }

  const Mechanism& m_;
  std::span<const PoseGoal> goals_;
  const PoseSolverOptions& o_;
  std::span<double> q_;
  std::vector<double> start_, trial_;
  std::vector<Pose> X_WB_;
  std::vector<Variable> variables_;
  std::vector<double> stiffness_;  // [variables] m^2/rad^2 | 1
  Equations equations_, next_equations_;
  std::vector<double> displacement_;  // [nv] from start_
  std::vector<double> A_, b_, step_;
  std::vector<std::uint8_t> fixed_;
};

}  // namespace

bool clamp_to_limits(const Joint& joint, double* q) {
  if (joint.type == JointType::floating || joint.nv() == 0) return false;
  double x[6], zero[7];
  joint_displacement(joint, q, x);
  bool changed = false;
  for (int k = 0; k < joint.nv(); ++k) {
    const Dof& dof = joint.dofs[at(k)];
    const double inside = std::clamp(x[k], dof.lower, dof.upper);
    changed = changed || inside != x[k];
    x[k] = inside;
  }
  if (!changed) return false;
  joint_neutral(joint, zero);
  joint_integrate(joint, zero, x, 1, q);
  return true;
}

void set_displacement(const Joint& joint, int dof, double value, double* q) {
  if (joint.type == JointType::floating || dof < 0 || dof >= joint.nv()) return;
  double x[6], zero[7];
  joint_displacement(joint, q, x);
  x[dof] = value;
  joint_neutral(joint, zero);
  joint_integrate(joint, zero, x, 1, q);
}

double solve_pose(const Mechanism& m, std::span<const PoseGoal> goals, const PoseSolverOptions& options, std::span<double> q) {
  return Solver(m, goals, options, q).run();
}

}  // namespace ugoki::posing
