#include "ugoki/contact/guarded_step.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/check.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::contact {
namespace {

/// Where a point of a shape's surface at the end is at the beginning. Round shapes touch at the same place however they spin.
Vec3 carry_back(const Shape& shape, const Pose& now, const Pose& end, const Vec3& p) {
  const Pose X_now = now * shape.X_BS, X_end = end * shape.X_BS;
  const Vec3 arm = p - X_end.p;
  switch (shape.type) {
    case ShapeType::sphere: return X_now.p + arm;
    case ShapeType::capsule:
    case ShapeType::cylinder: return X_now.p + to_matrix(rotation_between(X_end.R.column(2), X_now.R.column(2))) * arm;
    default: break;
  }
  return now * (end.inverse() * p);
}

/// How far it turns: |R' - R|.
double turn_between(const Mat3& R, const Mat3& T) {
  double square = 0;
  for (int k = 0; k < 3; ++k) {
    const Vec3 d = T.column(k) - R.column(k);
    square += dot(d, d);
  }
  return std::sqrt(square);
}

constexpr std::uint64_t feature_mask = (1U << 24) - 1, first_feature = 0xf00000,
                        shape_mask = (1U << 20) - 1;  // of keys; find_contacts makes smaller ones for few

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
      constexpr double root_half = 0.7071067811865476;
      way = std::max(way, norm(end_[s][i].p - begin[i].p) + root_half * turn_between(begin[i].R, end_[s][i].R) * *size);
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
    // The point is taken where it is on the body that turns more: there an error of its place costs most.
    const Vec3 there = c.p;
    double u = 0, turned = -1;
    for (int side = 0; side < 2; ++side) {
      const int at = side == 0 ? c.system_a : c.system_b, link = side == 0 ? c.link_a : c.link_b;
      if (at < 0) continue;
      const auto l = static_cast<std::size_t>(link);
      const Pose &now = stepper_->workspace(at).X_WB[l], &end = end_[static_cast<std::size_t>(at)][l];
      const double turn = turn_between(now.R, end.R);
      if (turn <= turned) continue;
      turned = turn;
      c.p = carry_back(scene_->shapes()[static_cast<std::size_t>(c.key >> (side == 0 ? 44 : 24)) & shape_mask].shape, now, end, there);
    }
    for (int side = 0; side < 2; ++side) {
      const int at = side == 0 ? c.system_a : c.system_b, link = side == 0 ? c.link_a : c.link_b;
      if (at >= 0) u += (side == 0 ? 1 : -1) * dot(c.n, stepper_->velocity_after(at, link, c.p));
    }
    // Where the points part to first order, and still end up deeper, they must part faster; never by a leap.
    c.distance = std::max(gap - before - dt * u, -dt * (std::max(u, 0.0) + stepper_->options().recovery_speed));
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
