#include "ugoki/studio/body_drag.h"

#include <algorithm>
#include <utility>

#include "ugoki/mechanism/state.h"

namespace ugoki::studio {
namespace {

constexpr double overlap = -2e-3;  // m: links that overlap more at the beginning do not collide with each other

collision::SceneOptions scene_options() {
  collision::SceneOptions options;
  options.self_collision = true;
  return options;
}
contact::StepperOptions stepper_options() {
  contact::StepperOptions options;
  options.gravity = {};
  return options;
}
std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace

BodyDrag::BodyDrag(MechanismPtr mechanism, std::span<const double> q, BodyDragOptions options)
    : mechanism_(std::move(mechanism)),
      options_(std::move(options)),
      scene_({mechanism_}, {.height = options_.ground}, scene_options()),
      search_(scene_, 0.02),
      stepper_({mechanism_}, stepper_options()),
      ws_(*mechanism_),
      q_(q.begin(), q.end()),
      v_(at(mechanism_->nv())),
      posture_(q_),
      tau_(v_.size()),
      gain_(v_.size()),
      velocity_(v_.size()),
      external_(at(mechanism_->link_count())),
      pinned_(at(mechanism_->link_count())) {
  std::vector<Pose> X(at(mechanism_->link_count()));
  calc_poses(*mechanism_, q_, X);
  std::vector<contact::Grip> grips;
  for (const int link : options_.pins) {
    if (link == options_.link || link < 0 || link >= mechanism_->link_count() || pinned_[at(link)]) continue;
    pinned_[at(link)] = 1;
    contact::Grip grip;
    grip.link_a = link;
    grip.p_b = X[at(link)].p;
    grip.hold = to_quat(X[at(link)].R);
    grip.rigid = 1;
    grip.key = static_cast<std::uint64_t>(link);
    grips.push_back(grip);
  }
  stepper_.set_grips(grips);
  const collision::SystemMotion motion{q_, v_};
  for (const collision::ContactPoint& c : search_.find({&motion, 1}, options_.step))
    if (c.link_b >= 0 && c.distance < overlap) overlapping_.emplace_back(c.link_a, c.link_b);
}

bool BodyDrag::is_ignored(const collision::ContactPoint& c) const {
  if (c.link_b < 0) return pinned_[at(c.link_a)] != 0;  // its pin holds it; the floor would push a sole that sinks in by a millimetre
  return std::ranges::find(overlapping_, std::pair{c.link_a, c.link_b}) != overlapping_.end();
}

void BodyDrag::set_posture() {
  const double dt = options_.step;
  for (int i = 0; i < mechanism_->link_count(); ++i) {
    const Link& link = mechanism_->link(i);
    double error[6];
    joint_difference(link.joint, q_.data() + link.q_index, posture_.data() + link.q_index, error);
    const bool root = link.joint.type == JointType::floating && link.parent < 0;
    for (int k = 0; k < link.joint.nv(); ++k) {
      const std::size_t dof = at(link.v_index + k);
      const double inertia = ws_.M[at(ws_.row_start[dof] + ws_.depth[dof])];
      const double kp = root ? 0 : inertia * options_.posture * options_.posture;
      const double kd = inertia * (root ? options_.root_damping : 2 * options_.posture);
      // kp (error - dt v') - kd v' = gain (velocity - v')
      gain_[dof] = kd + dt * kp;
      velocity_[dof] = gain_[dof] > 0 ? kp * error[k] / gain_[dof] : 0;
    }
  }
}

Result<void> BodyDrag::advance(const Vec3& target, double seconds) {
  const double dt = options_.step;
  for (remainder_ += seconds; remainder_ >= dt; remainder_ -= dt) {
    const Vec3 force = lsi::calc_pull(*mechanism_, ws_, q_, v_, options_.link, options_.point, target, dt, options_.pull);
    const Vec3 p = ws_.X_WB[at(options_.link)] * options_.point;
    std::ranges::fill(external_, Vec6{});
    external_[at(options_.link)] = {cross(p, force), force};
    set_posture();
    const collision::SystemMotion motion{q_, v_};
    std::vector<collision::ContactPoint>& contacts = search_.find({&motion, 1}, dt);
    std::erase_if(contacts, [&](const collision::ContactPoint& c) { return is_ignored(c); });
    contact::StepSystem system{q_, v_, tau_, external_, gain_, velocity_};
    const contact::StepReport report = stepper_.step({&system, 1}, contacts, dt);
    if (report.status == contact::StepStatus::ok) continue;
    remainder_ = 0;
    const int dof = std::max(report.dof, 0);
    int link = 0;
    while (link + 1 < mechanism_->link_count() && mechanism_->link(link + 1).v_index <= dof) ++link;
    return fail(ErrorCode::range, "edit", "The simulation of the drag failed at the link '" + mechanism_->link(link).name + "'.",
                "Release the drag, and drag with \"Limb\" or \"Body\".");
  }
  return {};
}

}  // namespace ugoki::studio
