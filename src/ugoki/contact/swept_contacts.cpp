#include "ugoki/contact/swept_contacts.h"

#include <algorithm>

#include "ugoki/mechanism/state.h"

namespace ugoki::contact {
namespace {

// Parts of a contact key in the layout of collision::find_contacts(): the index for the ground, and the first feature of swept contacts.
constexpr std::uint64_t ground_index = (1U << 20) - 1, first_feature = 0xffff00;

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
  kinematics_.resize(scene.systems().size());
}

SweptContacts::Side SweptContacts::side_at(int system, int link, std::span<const std::span<const Pose>> X_WB, double time) {
  Side out;
  if (system < 0) return out;
  const auto s = static_cast<std::size_t>(system);
  const Mechanism& m = *scene_->systems()[s];
  const collision::SystemMotion& motion = motions_[s];
  out.system = system;
  out.link = link;
  const std::span<double> q(q_.data(), motion.q.size());
  const std::span<Pose> X(X_.data(), m.links().size());
  integrate(m, motion.q, motion.v, time, q);
  calc_poses(m, q, X);
  out.now = X_WB[s][static_cast<std::size_t>(link)];
  out.then = X[static_cast<std::size_t>(link)];
  if (!kinematics_[s]) kinematics_[s] = std::make_unique<dynamics::Kinematics>(m);
  dynamics::update_kinematics(m, motion.q, motion.v, *kinematics_[s]);
  return out;
}

/// Sets points_ to the contact manifold at the impact (several points if a blade meets a plate flat), or else to the point found by the
/// search.
void SweptContacts::find_points(const collision::SceneImpact& impact, const Side& a, const Side& b, double margin) {
  const collision::SceneShape& shape_a = scene_->shapes()[static_cast<std::size_t>(impact.shape_a)];
  const Pose X_a = a.then * shape_a.shape.X_BS;
  if (impact.shape_b < 0) {
    std::int32_t hint = 0;
    collision::find_ground_manifold(shape_a, X_a, scene_->ground().height, margin, hint, work_, points_);
  } else {
    const collision::SceneShape& shape_b = scene_->shapes()[static_cast<std::size_t>(impact.shape_b)];
    collision::GilbertCache cache;
    collision::find_manifold(shape_a, X_a, shape_b, b.then * shape_b.shape.X_BS, margin, cache, work_, points_);
  }
  if (points_.count == 0) points_.add(impact.contact.p, impact.contact.n, impact.contact.distance, 0);
}

int SweptContacts::add(std::span<const collision::SystemMotion> systems, std::span<const std::span<const Pose>> X_WB, double dt,
                       double margin, std::vector<collision::ContactPoint>& contacts) {
  constexpr int maximum = 32;
  motions_.assign(systems.begin(), systems.end());
  for (std::size_t k = 0; k < motions_.size(); ++k) motions_[k].X_WB = X_WB[k];
  int added = 0;
  while (added < maximum) {
    const collision::SceneImpact impact = search_.find(motions_, dt, 0.5 * margin);
    if (impact.status != collision::ImpactStatus::impact && impact.status != collision::ImpactStatus::not_converged) break;
    collision::ContactPoint c = impact.contact;
    const Side a = side_at(c.system_a, c.link_a, X_WB, impact.time), b = side_at(c.system_b, c.link_b, X_WB, impact.time);
    find_points(impact, a, b, 0.5 * margin);
    const std::uint64_t shape_b = impact.shape_b < 0 ? ground_index : static_cast<std::uint64_t>(impact.shape_b);
    const auto velocity = [&](const Side& side, const Vec3& p) {
      return side.system < 0 ? Vec3{} : dynamics::point_velocity(*kinematics_[static_cast<std::size_t>(side.system)], side.link, p);
    };
    for (int i = 0; i < points_.count; ++i) {
      const collision::ManifoldPoint& point = points_.points[static_cast<std::size_t>(i)];
      const Vec3 on_a = a.back(point.p), on_b = b.back(point.p);
      const bool by_a = norm(point.p - on_a) >= norm(point.p - on_b);
      c.p = by_a ? on_a : on_b;
      c.n = point.n;
      const Vec3 v = velocity(a, c.p) - velocity(b, c.p);
      // If the body rotates far within the step, the normal at the impact is not opposed to the present velocity: rotate the normal back.
      if (dot(c.n, v) > -0.5 * norm(v)) c.n = by_a ? a.back_with(point.n) : b.back_with(point.n);
      c.distance = std::max(point.distance - impact.time * dot(c.n, v), 0.0);
      c.key = (static_cast<std::uint64_t>(impact.shape_a) << 44) | (shape_b << 24) | (first_feature + static_cast<std::uint64_t>(i));
      contacts.push_back(c);
    }
    ++added;
    // Freeze these two systems, so that the next search finds an impact of other systems.
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
