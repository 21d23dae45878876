#include "ugoki/contact/contact_search.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/check.h"
#include "ugoki/contact/velocity_solver.h"

namespace ugoki::contact {

ContactSearch::ContactSearch(const collision::Scene& scene, double margin)
    : scene_(&scene), margin_(margin), workspace_(scene), swept_(scene), views_(scene.systems().size()), fast_(scene.systems().size()) {
  for (const MechanismPtr& m : scene.systems()) {
    own_.emplace_back(*m);
    sizes_.emplace_back(static_cast<std::size_t>(m->link_count()), -1.0);
  }
  for (const collision::SceneShape& shape : scene.shapes()) {
    double& size = sizes_[static_cast<std::size_t>(shape.system)][static_cast<std::size_t>(shape.link)];
    size = std::max(size, norm(shape.shape.X_BS.p) + shape.reach);
  }
  contacts_.reserve(12 * scene.shapes().size() + 64);
}

void ContactSearch::set_executor(Executor* executor) {
  std::size_t dofs = 0;
  for (const MechanismPtr& m : scene_->systems()) dofs += static_cast<std::size_t>(m->nv());
  executor_ = dofs >= min_parallel_dofs ? executor : nullptr;
}

/// Returns true if a point of the system's shapes moves farther than half the margin in one step; contacts must then be searched along the
/// motion.
bool ContactSearch::is_fast(std::size_t system, const dynamics::Kinematics& k, double dt) const {
  const double limit = 0.5 * margin_ / dt;
  for (std::size_t i = 0; i < k.X_WB.size(); ++i) {
    const double size = sizes_[system][i];
    const Vec6& V = k.V[i];
    if (size >= 0 && !(norm(V.v + cross(V.w, k.X_WB[i].p - k.p0)) + norm(V.w) * size <= limit)) return true;
  }
  return false;
}

std::vector<collision::ContactPoint>& ContactSearch::find(std::span<const collision::SystemMotion> systems, double dt,
                                                          std::span<const dynamics::KnownKinematics> known) {
  UGOKI_CHECK(known.empty() || known.size() == systems.size());
  parallel_for(executor_, systems.size(), [&](std::size_t s, int) {
    const dynamics::Kinematics* k = known.empty() ? nullptr : known[s].find(systems[s].q, systems[s].v);
    if (k == nullptr) {
      own_[s].update(*scene_->systems()[s], systems[s].q, systems[s].v);
      k = &own_[s].values();
    }
    views_[s] = k->X_WB;
    fast_[s] = is_fast(s, *k, dt) ? 1 : 0;
  });
  workspace_.forget();  // contacts must depend only on the state, so that a restored run gives the same bits
  collision::find_contacts(*scene_, views_, margin_, workspace_, contacts_);
  if (std::ranges::any_of(fast_, [](char fast) { return fast != 0; })) swept_.add(systems, views_, dt, margin_, contacts_);
  return contacts_;
}

}  // namespace ugoki::contact
