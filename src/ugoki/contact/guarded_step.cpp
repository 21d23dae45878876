#include "ugoki/contact/guarded_step.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/check.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::contact {
namespace {

constexpr std::uint64_t feature_mask = (1U << 24) - 1, first_feature = 0xf00000;  // of keys; find_contacts makes smaller ones for few

}  // namespace

GuardedStep::GuardedStep(const collision::Scene& scene, Stepper& stepper, const GuardOptions& options)
    : scene_(&scene), stepper_(&stepper), options_(options), workspace_(scene) {
  UGOKI_CHECK(scene.systems().size() == static_cast<std::size_t>(stepper.system_count()));
  for (const MechanismPtr& m : scene.systems()) {
    const auto links = static_cast<std::size_t>(m->link_count());
    q_.emplace_back(static_cast<std::size_t>(m->nq()));
    v_.emplace_back(static_cast<std::size_t>(m->nv()));
    end_.emplace_back(links);
    size_.resize(size_.size() + links);
  }
  for (const auto& poses : end_) views_.emplace_back(poses);
  moved_.resize(views_.size());
  std::vector<std::size_t> first = {0};
  for (const auto& poses : end_) first.push_back(first.back() + poses.size());
  for (const collision::SceneShape& s : scene.shapes()) {
    double& size = size_[first[static_cast<std::size_t>(s.system)] + static_cast<std::size_t>(s.link)];
    size = std::max(size, norm(s.shape.X_BS.p) + s.reach);
  }
  contacts_.reserve(12 * scene.shapes().size() + 64);
  found_.reserve(12 * scene.shapes().size() + 64);
}

/// Poses at the end, and which systems are no longer where they were.
void GuardedStep::move(std::span<const StepSystem> systems) {
  const double* size = size_.data();
  for (std::size_t s = 0; s < systems.size(); ++s) {
    const std::span<const Pose> begin = stepper_->workspace(static_cast<int>(s)).X_WB;
    calc_poses(stepper_->mechanism(static_cast<int>(s)), systems[s].q, end_[s]);
    double way = 0;
    for (std::size_t i = 0; i < end_[s].size(); ++i, ++size) {
      const Mat3 &R = begin[i].R, &T = end_[s][i].R;
      double turn = 0;
      for (int k = 0; k < 3; ++k) {
        const Vec3 d = T.column(k) - R.column(k);
        turn += dot(d, d);
      }
      way = std::max(way, norm(end_[s][i].p - begin[i].p) + std::sqrt(0.5 * turn) * *size);
    }
    moved_[s] = way > options_.depth ? 1 : 0;
  }
}

/// @return whether contacts were added
bool GuardedStep::add_overlaps(std::span<const collision::ContactPoint> given, double dt) {
  collision::find_contacts(*scene_, views_, -options_.depth, workspace_, found_, moved_);
  depth_ = 0;
  bool added = false;
  for (collision::ContactPoint& c : found_) {
    // What was deep at the beginning is being pushed out, at its own speed.
    double before = 0;
    for (const collision::ContactPoint& g : given)
      if (((g.key ^ c.key) & ~feature_mask) == 0) before = std::min(before, g.distance);
    if (c.distance > before - 0.25 * options_.depth) continue;
    depth_ = std::max(depth_, -c.distance);
    if (passes_ == options_.passes) continue;
    const double gap = c.distance;
    Vec3 now[2] = {c.p, c.p};  // where the two points are at the beginning
    double u = 0;
    for (int side = 0; side < 2; ++side) {
      const int at = side == 0 ? c.system_a : c.system_b, link = side == 0 ? c.link_a : c.link_b;
      if (at < 0) continue;
      const auto l = static_cast<std::size_t>(link);
      now[side] = stepper_->workspace(at).X_WB[l] * (end_[static_cast<std::size_t>(at)][l].inverse() * c.p);
    }
    c.p = c.system_b < 0 ? now[0] : (now[0] + now[1]) * 0.5;
    for (int side = 0; side < 2; ++side) {
      const int at = side == 0 ? c.system_a : c.system_b, link = side == 0 ? c.link_a : c.link_b;
      if (at >= 0) u += (side == 0 ? 1 : -1) * dot(c.n, stepper_->velocity_after(at, link, c.p));
    }
    c.distance = gap - before - dt * u;
    c.key = (c.key & ~feature_mask) | (first_feature + contacts_.size());
    contacts_.push_back(c);
    added = true;
  }
  return added;
}

StepReport GuardedStep::step(std::span<StepSystem> systems, std::span<const collision::ContactPoint> contacts, double dt) {
  for (std::size_t s = 0; s < systems.size(); ++s) {
    std::ranges::copy(systems[s].q, q_[s].begin());
    std::ranges::copy(systems[s].v, v_[s].begin());
  }
  contacts_.assign(contacts.begin(), contacts.end());
  StepReport report;
  for (passes_ = 1;; ++passes_) {
    report = stepper_->step(systems, contacts_, dt, contacts.size());
    if (report.status != StepStatus::ok) break;
    move(systems);
    if (!add_overlaps(contacts, dt)) return report;
    for (std::size_t s = 0; s < systems.size(); ++s) {
      std::ranges::copy(q_[s], systems[s].q.begin());
      std::ranges::copy(v_[s], systems[s].v.begin());
    }
  }
  for (std::size_t s = 0; s < systems.size(); ++s) {
    std::ranges::copy(q_[s], systems[s].q.begin());
    std::ranges::copy(v_[s], systems[s].v.begin());
  }
  return report;
}

}  // namespace ugoki::contact
