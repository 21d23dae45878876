#include "ugoki/contact/contact_search.h"

#include <algorithm>
#include <cmath>

#include "ugoki/contact/velocity_solver.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::contact {

ContactSearch::ContactSearch(const collision::Scene& scene, double margin)
    : scene_(&scene), margin_(margin), workspace_(scene), swept_(scene), reach_(scene.systems().size()) {
  for (const collision::SceneShape& shape : scene.shapes()) {
    const Mechanism& m = *scene.systems()[static_cast<std::size_t>(shape.system)];
    double& reach = reach_[static_cast<std::size_t>(shape.system)];
    if (m.link_count() == 1 && m.link(0).joint.type == JointType::floating) reach = std::max(reach, norm(shape.shape.X_BS.p) + shape.reach);
  }
  for (const MechanismPtr& m : scene.systems()) poses_.emplace_back(static_cast<std::size_t>(m->link_count()));
  for (const auto& p : poses_) views_.emplace_back(p);
  contacts_.reserve(12 * scene.shapes().size() + 64);
}

void ContactSearch::set_executor(Executor* executor) {
  std::size_t dofs = 0;
  for (const MechanismPtr& m : scene_->systems()) dofs += static_cast<std::size_t>(m->nv());
  executor_ = dofs >= min_parallel_dofs ? executor : nullptr;
}

/// Returns true if a body may move farther than half the margin in one step; contacts must then be searched along the motion. Joint
/// velocities in rad/s and m/s have the same limit, because links are about 1 m long.
bool ContactSearch::is_fast(std::span<const collision::SystemMotion> systems, double dt) const {
  const double limit = 0.5 * margin_ / dt;
  for (std::size_t i = 0; i < systems.size(); ++i) {
    const std::span<const double> v = systems[i].v;
    if (reach_[i] > 0) {
      if (norm(Vec3{v[3], v[4], v[5]}) + norm(Vec3{v[0], v[1], v[2]}) * reach_[i] > limit) return true;
    } else if (std::ranges::any_of(v, [limit](double x) { return std::fabs(x) > limit; })) {
      return true;
    }
  }
  return false;
}

std::vector<collision::ContactPoint>& ContactSearch::find(std::span<const collision::SystemMotion> systems, double dt) {
  parallel_for(executor_, systems.size(), [&](std::size_t s, int) {
    if (shared_ != nullptr) views_[s] = shared_->find(s, systems[s].q);
    if (shared_ != nullptr && !views_[s].empty()) return;
    calc_poses(*scene_->systems()[s], systems[s].q, poses_[s]);
    views_[s] = poses_[s];
  });
  workspace_.forget();  // contacts must depend only on the state, so that a restored run gives the same bits
  collision::find_contacts(*scene_, views_, margin_, workspace_, contacts_);
  if (is_fast(systems, dt)) swept_.add(systems, views_, dt, margin_, contacts_);
  return contacts_;
}

}  // namespace ugoki::contact
