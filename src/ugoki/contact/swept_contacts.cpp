#include "ugoki/contact/swept_contacts.h"

#include <algorithm>

#include "ugoki/mechanism/state.h"

namespace ugoki::contact {
namespace {

constexpr std::uint64_t ground_index = (1U << 20) - 1, feature = (1U << 24) - 1;  // as find_contacts makes its keys

}  // namespace

SweptContacts::SweptContacts(const collision::Scene& scene) : scene_(&scene), search_(scene) {
  std::size_t nq = 0, nv = 0, links = 0;
  for (const MechanismPtr& m : scene.systems()) {
    nq = std::max(nq, static_cast<std::size_t>(m->nq()));
    nv = std::max(nv, static_cast<std::size_t>(m->nv()));
    links = std::max(links, m->links().size());
  }
  q_.resize(nq);
  still_.resize(nv);
  X_.resize(links);
  motions_.reserve(scene.systems().size());
}

int SweptContacts::add(std::span<const collision::SystemMotion> systems, std::span<const std::span<const Pose>> X_WB, double dt,
                       double margin, std::vector<collision::ContactPoint>& contacts) {
  constexpr int most = 32;
  motions_.assign(systems.begin(), systems.end());
  int added = 0;
  while (added < most) {
    const collision::SceneImpact impact = search_.find(motions_, dt, 0.5 * margin);
    if (impact.status != collision::ImpactStatus::impact && impact.status != collision::ImpactStatus::not_converged) break;
    collision::ContactPoint c = impact.contact;
    Vec3 now[2] = {c.p, c.p};  // where the points that will meet are at the beginning
    double way[2] = {0, 0};
    for (int side = 0; side < 2; ++side) {
      const int at = side == 0 ? c.system_a : c.system_b, link = side == 0 ? c.link_a : c.link_b;
      if (at < 0) continue;
      const auto s = static_cast<std::size_t>(at);
      const Mechanism& m = *scene_->systems()[s];
      const std::span<double> q(q_.data(), motions_[s].q.size());
      const std::span<Pose> X(X_.data(), m.links().size());
      integrate(m, motions_[s].q, motions_[s].v, impact.time, q);
      calc_poses(m, q, X);
      now[side] = X_WB[s][static_cast<std::size_t>(link)] * (X[static_cast<std::size_t>(link)].inverse() * c.p);
      way[side] = norm(c.p - now[side]);
    }
    c.distance = std::max(dot(c.n, now[0] - now[1]), 0.0);
    c.p = way[0] >= way[1] ? now[0] : now[1];
    const std::uint64_t b = impact.shape_b < 0 ? ground_index : static_cast<std::uint64_t>(impact.shape_b);
    c.key = (static_cast<std::uint64_t>(impact.shape_a) << 44) | (b << 24) | feature;
    contacts.push_back(c);
    ++added;
    // The next impact is that of others.
    bool moved = false;
    for (const int at : {c.system_a, c.system_b}) {
      if (at < 0) continue;
      collision::SystemMotion& motion = motions_[static_cast<std::size_t>(at)];
      moved = moved || std::ranges::any_of(motion.v, [](double v) { return v != 0; });
      motion.v = {still_.data(), motion.v.size()};
    }
    if (!moved) break;
  }
  return added;
}

}  // namespace ugoki::contact
