#include "ugoki/posing/pose_edit.h"

#include <algorithm>
#include <cmath>

#include "ugoki/mechanism/state.h"
#include "ugoki/motion_edit/mirror.h"
#include "ugoki/posing/pose_solver.h"

namespace ugoki::posing {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

bool is_ancestor(const Mechanism& m, int ancestor, int link) {
  for (int i = link; i >= 0; i = m.link(i).parent)
    if (i == ancestor) return true;
  return false;
}

/// Applies edits to one pose.
class Editor {
 public:
  Editor(const Mechanism& m, const PoseEditOptions& options, std::span<double> q) : m_(m), o_(options), q_(q), X_WB_(at(m.link_count())) {
    calc_poses(m_, q_, X_WB_);
    for (const int pin : o_.pins) pinned_.push_back({pin, {}, X_WB_[at(pin)].p, true, X_WB_[at(pin)].R});
    moves_.assign(at(m_.link_count()), 0);
  }

  Result<void> operator()(const TurnEdit& e) {
    const Link& link = m_.link(e.link);
    double* own = q_.data() + link.q_index;
    Vec6 S[6];
    double v[6] = {};
    for (int k = 0, n = joint_subspace(link.joint, own, S); k < n; ++k) v[k] = dot(S[k].w, e.axis) * e.angle;
    joint_integrate(link.joint, own, v, 1, own);
    if (o_.limits) clamp_to_limits(link.joint, own);
    hold_pins(e.link);
    return {};
  }
  Result<void> operator()(const SetEdit& e) {
    const Link& link = m_.link(e.link);
    const Dof& dof = link.joint.dofs[at(e.dof)];
    set_displacement(link.joint, e.dof, o_.limits ? std::clamp(e.value, dof.lower, dof.upper) : e.value, q_.data() + link.q_index);
    hold_pins(e.link);
    return {};
  }
  Result<void> operator()(const ReachEdit& e) {
    std::vector<PoseGoal> goals = {{e.link, e.point, e.target, false, {}}};
    if (e.moves == Reach::body || m_.has_loops()) {
      std::fill(moves_.begin(), moves_.end(), std::uint8_t{1});
      if (e.moves == Reach::limb && m_.link(0).joint.type == JointType::floating) moves_[0] = 0;
      for (const PoseGoal& pin : pinned_)
        if (pin.link != e.link) goals.push_back(pin);
    } else {
      for (const int link : limb_of(m_, e.link)) moves_[at(link)] = 1;
    }
    solve(goals);
    return {};
  }
  Result<void> operator()(const MirrorEdit&) {
    Motion still;
    still.mechanism = m_.name();
    still.frames = 1;
    still.nq = m_.nq();
    still.q.assign(q_.begin(), q_.end());
    Result<Motion> mirrored = motion_edit::mirror(m_, still);
    if (!mirrored) return fail(std::move(mirrored.error()));
    std::copy(mirrored->q.begin(), mirrored->q.end(), q_.begin());
    return {};
  }
  Result<void> operator()(const BlendEdit& e) {
    double v[6];
    for (const int i : e.links) {
      const Link& link = m_.link(i);
      double* own = q_.data() + link.q_index;
      joint_difference(link.joint, own, e.q.data() + link.q_index, v);
      if (link.joint.type == JointType::floating) v[3] = v[4] = 0;  // the character stays where it is; only its height changes
      joint_integrate(link.joint, own, v, e.share, own);
    }
    if (m_.has_loops()) {
      std::fill(moves_.begin(), moves_.end(), std::uint8_t{1});
      if (m_.link(0).joint.type == JointType::floating) moves_[0] = 0;
      solve({});
    }
    return {};
  }

 private:
  /// Leads pinned links back to their pose after the joint of `turned` was set. This joint is held; if a pinned link is below it, all
  /// others may move, because a turned thigh keeps its foot only if the pelvis moves.
  void hold_pins(int turned) {
    std::vector<PoseGoal> goals;
    bool below = false;
    for (const PoseGoal& pin : pinned_) {
      if (pin.link == turned) continue;
      goals.push_back(pin);
      below = below || is_ancestor(m_, turned, pin.link);
    }
    if (!below) goals.clear();
    if (goals.empty() && !m_.has_loops()) return;
    std::fill(moves_.begin(), moves_.end(), std::uint8_t{1});
    moves_[at(turned)] = 0;
    if (!below && m_.link(0).joint.type == JointType::floating) moves_[0] = 0;
    solve(goals);
  }
  void solve(std::span<const PoseGoal> goals) { (void)solve_pose(m_, goals, {moves_, o_.limits}, q_); }

  const Mechanism& m_;
  const PoseEditOptions& o_;
  std::span<double> q_;
  std::vector<Pose> X_WB_;
  std::vector<PoseGoal> pinned_;
  std::vector<std::uint8_t> moves_;
};

Error check_link(const Mechanism& m, int link) {
  if (link >= 0 && link < m.link_count()) return {};
  return {ErrorCode::range, "link", "The mechanism " + m.name() + " has no link " + std::to_string(link) + ".",
          "Use an index from 0 to " + std::to_string(m.link_count() - 1) + "."};
}

struct Checker {
  const Mechanism& m;
  Error operator()(const TurnEdit& e) const { return check_link(m, e.link); }
  Error operator()(const SetEdit& e) const {
    if (Error wrong = check_link(m, e.link); !wrong.empty()) return wrong;
    if (e.dof >= 0 && e.dof < m.link(e.link).joint.nv()) return {};
    return {ErrorCode::range, "dof", "The joint of link " + m.link(e.link).name + " has no DOF " + std::to_string(e.dof) + ".",
            "The joint has " + std::to_string(m.link(e.link).joint.nv()) + " DOFs, counted from 0."};
  }
  Error operator()(const ReachEdit& e) const { return check_link(m, e.link); }
  Error operator()(const MirrorEdit&) const { return {}; }
  Error operator()(const BlendEdit& e) const {
    for (const int link : e.links)
      if (Error wrong = check_link(m, link); !wrong.empty()) return wrong;
    if (e.q.size() == at(m.nq())) return {};
    return {ErrorCode::structure, "pose", "The pose has another number of coordinates than the mechanism " + m.name() + ".",
            "Use a pose that was stored for this mechanism."};
  }
};

}  // namespace

std::vector<int> limb_of(const Mechanism& m, int link) {
  std::vector<int> limb;
  for (int i = link; i >= 0; i = m.link(i).parent) {
    const int child = m.link(i).child;
    const bool branches = i != link && child >= 0 && m.link(child).sibling >= 0;
    if (branches || (m.link(i).parent < 0 && i != link)) break;
    limb.push_back(i);
  }
  std::reverse(limb.begin(), limb.end());
  return limb;
}

Result<void> edit_pose(const Mechanism& m, const PoseEdit& edit, const PoseEditOptions& options, std::span<double> q) {
  if (Error wrong = std::visit(Checker{m}, edit); !wrong.empty()) return fail(std::move(wrong));
  for (const int pin : options.pins)
    if (Error wrong = check_link(m, pin); !wrong.empty()) return fail(std::move(wrong));
  return std::visit(Editor(m, options, q), edit);
}

}  // namespace ugoki::posing
