#include "ugoki/contact/contact_search.h"

#include <algorithm>
#include <cmath>

#include "ugoki/contact/velocity_solver.h"

namespace ugoki::contact {

ContactSearch::ContactSearch(const collision::Scene& scene, double margin)
    : scene_(&scene),
      margin_(margin),
      workspace_(scene),
      swept_(scene),
      own_(std::make_unique<dynamics::SceneKinematics>(dynamics::make_scene_kinematics(scene.systems()))),
      shared_(own_.get()),
      fast_(scene.systems().size()) {
  for (const MechanismPtr& m : scene.systems()) {
    const auto links = static_cast<std::size_t>(m->link_count());
    poses_.emplace_back(links);
    speeds_.emplace_back(links);
    sizes_.emplace_back(links, -1.0);
  }
  for (const collision::SceneShape& shape : scene.shapes()) {
    double& size = sizes_[static_cast<std::size_t>(shape.system)][static_cast<std::size_t>(shape.link)];
    size = std::max(size, norm(shape.shape.X_BS.p) + shape.reach);
  }
  for (const auto& p : poses_) views_.emplace_back(p);
  contacts_.reserve(12 * scene.shapes().size() + 64);
}

void ContactSearch::set_executor(Executor* executor) {
  std::size_t dofs = 0;
  for (const MechanismPtr& m : scene_->systems()) dofs += static_cast<std::size_t>(m->nv());
  executor_ = dofs >= min_parallel_dofs ? executor : nullptr;
}

/// Returns true if a point of the system's shapes moves farther than half the margin in one step; contacts must then be searched along the
/// motion.
bool ContactSearch::is_fast(std::size_t system, double dt) const {
  const double limit = 0.5 * margin_ / dt;
  const std::span<const Pose> X_WB = poses_[system];
  for (std::size_t i = 0; i < X_WB.size(); ++i) {
    const double size = sizes_[system][i];
    const Vec6& V = speeds_[system][i];
    if (size >= 0 && !(norm(V.v + cross(V.w, X_WB[i].p - X_WB[0].p)) + norm(V.w) * size <= limit)) return true;
  }
  return false;
}

std::vector<collision::ContactPoint>& ContactSearch::find(std::span<const collision::SystemMotion> systems, double dt) {
  parallel_for(executor_, systems.size(), [&](std::size_t s, int) {
    (*shared_)[s].update(*scene_->systems()[s], systems[s].q, systems[s].v, poses_[s], speeds_[s]);
    fast_[s] = is_fast(s, dt) ? 1 : 0;
  });
  workspace_.forget();  // contacts must depend only on the state, so that a restored run gives the same bits
  collision::find_contacts(*scene_, views_, margin_, workspace_, contacts_);
  if (std::ranges::any_of(fast_, [](char fast) { return fast != 0; })) swept_.add(systems, views_, dt, margin_, contacts_);
  return contacts_;
}

}  // namespace ugoki::contact
