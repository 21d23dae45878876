#include "ugoki/contact/guarded_step.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/check.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::contact {
namespace {

/// Maps a surface point from its position p [m, world] at the end of the step back to its position at the beginning. @return m, world.
/// For round shapes, rotation about their axis of symmetry is ignored, because it does not change the contact.
/// @param now, end poses of the link at the beginning and at the end
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

/// Frobenius norm |T - R| = 2 sqrt(2) sin(angle / 2), where `angle` is the rotation angle between the two orientations.
double turn_between(const Mat3& R, const Mat3& T) {
  double square = 0;
  for (int k = 0; k < 3; ++k) {
    const Vec3 d = T.column(k) - R.column(k);
    square += dot(d, d);
  }
  return std::sqrt(square);
}

// m: pairs whose penetration depth is expensive to compute (needs_gap()) are kept this far apart, so that at rest only their distance is
// needed.
constexpr double resting_gap = 2e-5;
constexpr double too_deep = 1e-3;  // m: if a deeper overlap is left after all passes, the step is split into substeps

// Limits of the work in one step. With them, a step of absurd content (inertia 1e-9 kg m^2, force 1e5 N) takes 0.1 s instead of seconds.
// In a step that is not split, each island uses at most GuardOptions::passes times 1e6 operations (VelocitySolver).
constexpr double max_newton_operations = 2e7;         // estimated floating-point operations of Newton's method
constexpr std::int64_t max_distances = 40'000;        // distances measured to find passages; also distances measured to find swept contacts
constexpr std::int64_t max_distances_of_shape = 500;  // additional distances to find passages, for each shape of the scene

// Fields of ContactPoint::key. collision::find_contacts() uses feature indices below first_feature.
constexpr std::uint64_t feature_mask = (1U << 24) - 1, first_feature = 0xf00000, shape_mask = (1U << 20) - 1;

}  // namespace

GuardedStep::GuardedStep(const collision::Scene& scene, Stepper& stepper, const GuardOptions& options)
    : scene_(&scene), stepper_(&stepper), options_(options), workspace_(scene), search_(scene), swept_(scene) {
  UGOKI_CHECK(scene.systems().size() == static_cast<std::size_t>(stepper.system_count()));
  for (const MechanismPtr& m : scene.systems()) {
    const auto links = static_cast<std::size_t>(m->link_count());
    for (States* states : {&attempt_begin_, &step_begin_}) {
      states->q.emplace_back(static_cast<std::size_t>(m->nq()));
      states->v.emplace_back(static_cast<std::size_t>(m->nv()));
    }
    size_.resize(size_.size() + links);
    end_.emplace_back(*m);
  }
  for (const dynamics::KnownKinematics& end : end_) views_.emplace_back(end.values().X_WB);
  moved_.resize(views_.size());
  may_pass_.resize(views_.size());
  half_thickness_.assign(size_.size(), HUGE_VAL);
  motions_.resize(views_.size());
  first_link_ = {0};
  for (const std::span<const Pose> poses : views_) first_link_.push_back(first_link_.back() + poses.size());
  for (const collision::SceneShape& s : scene.shapes()) {
    const std::size_t link = first_link_[static_cast<std::size_t>(s.system)] + static_cast<std::size_t>(s.link);
    size_[link] = std::max(size_[link], norm(s.shape.X_BS.p) + s.reach);
    // The thickness of a mesh is that of its box, which a slanted sheet does not fill: use half of it.
    const double thickness = s.shape.type == ShapeType::mesh ? 0.5 * s.thickness : s.thickness;
    half_thickness_[link] = std::min(half_thickness_[link], thickness);
  }
  for (auto* list : {&contacts_, &found_, &near_, &all_contacts_}) list->reserve(12 * scene.shapes().size() + 64);
  forces_.reserve(12 * scene.shapes().size() + 64);
}

/// Calculates the kinematics of one system at the end of the pass.
void GuardedStep::set_end(std::size_t s, const StepSystem& system) {
  end_[s].update(stepper_->mechanism(static_cast<int>(s)), system.q, system.v);
  views_[s] = end_[s].values().X_WB;
}

void GuardedStep::set_end(std::span<const StepSystem> systems) {
  stepper_->for_each_system([&](std::size_t s) { set_end(s, systems[s]); });
}

/// Calculates the poses at the end of the pass, and marks in moved_ the systems whose end positions must be checked for overlaps, and in
/// may_pass_ those whose motion must be checked for passages.
void GuardedStep::update_end_poses(std::span<const StepSystem> systems, double dt) {
  stepper_->for_each_system([&](std::size_t s) {
    const double* size = size_.data() + first_link_[s];
    if (repeated_ && !stepper_->has_changed(static_cast<int>(s))) {
      moved_[s] = 0;
      return;
    }
    const std::span<const Pose> begin = stepper_->workspace(static_cast<int>(s)).X_WB;
    set_end(s, systems[s]);
    const std::span<const Pose> end = end_[s].values().X_WB;
    double motion = 0;
    for (std::size_t i = 0; i < end.size(); ++i, ++size) {
      constexpr double inv_sqrt2 = 0.7071067811865476;  // |T - R| / sqrt(2): distance that a point at unit distance from the axis moves.
      motion = std::max(motion, norm(end[i].p - begin[i].p) + inv_sqrt2 * turn_between(begin[i].R, end[i].R) * *size);
    }
    moved_[s] = motion > options_.depth ? 1 : 0;
    may_pass_[s] = may_pass(s, dt) ? 1 : 0;
  });
}

/// Adds contacts for the overlaps at the end of the pass. @return whether contacts were added
bool GuardedStep::add_overlaps(std::span<const collision::ContactPoint> given, double dt) {
  collision::find_contacts(*scene_, views_, -options_.depth, workspace_, found_, moved_);
  depth_ = 0;
  bool added = false;
  for (collision::ContactPoint& c : found_) {
    if (stepper_->is_gripped(c)) continue;
    // An overlap that has existed since the beginning of the step is pushed out at the recovery speed, not within this step.
    double before = 0, along = -1;
    bool known = false;
    for (const collision::ContactPoint& g : given) {
      if (((g.key ^ c.key) & ~feature_mask) != 0) continue;
      before = std::min(before, g.distance);
      along = std::max(along, dot(g.n, c.n));
      known = true;
    }
    // A body that has gone through a thin non-convex wall has the opposite contact normal: do not push it further through.
    if (known && along < -0.5 && c.distance < -too_deep && !is_convex_pair(c)) continue;
    // Deep overlaps exist from the beginning of the simulation. Further passes cannot remove contradictions between their normals.
    if (before < -StepperOptions::deep_overlap && c.distance > before - too_deep) continue;
    if (c.distance > before - (before < -options_.depth ? 0.02 : 0.25) * options_.depth) continue;
    depth_ = std::max(depth_, before - c.distance);
    if (passes_ == options_.passes) continue;
    const double gap = c.distance;
    // Map the point back with the body that turns more, because an error of the point's position has the larger effect on that body.
    const Vec3 end_point = c.p;
    double u = 0, turned = -1;
    for (int side = 0; side < 2; ++side) {
      const int at = side == 0 ? c.system_a : c.system_b, link = side == 0 ? c.link_a : c.link_b;
      if (at < 0) continue;
      const auto l = static_cast<std::size_t>(link);
      const Pose &now = stepper_->workspace(at).X_WB[l], &end = end_[static_cast<std::size_t>(at)].values().X_WB[l];
      const double turn = turn_between(now.R, end.R);
      if (turn <= turned) continue;
      turned = turn;
      c.p = carry_back(scene_->shapes()[static_cast<std::size_t>(c.key >> (side == 0 ? 44 : 24)) & shape_mask].shape, now, end, end_point);
    }
    for (int side = 0; side < 2; ++side) {
      const int at = side == 0 ? c.system_a : c.system_b, link = side == 0 ? c.link_a : c.link_b;
      if (at >= 0) u += (side == 0 ? 1 : -1) * dot(c.n, stepper_->velocity_after(at, link, c.p));
    }
    // If the points separate to first order and the overlap still grows, they must separate faster, by at most the recovery speed per pass.
    c.distance = std::max(gap - before - dt * u, -dt * (std::max(u, 0.0) + stepper_->options().recovery_speed));
    c.key = (c.key & ~feature_mask) | (first_feature + contacts_.size());
    contacts_.push_back(c);
    added = true;
  }
  return added;
}

bool GuardedStep::is_convex_pair(const collision::ContactPoint& c) const {
  const auto convex = [&](int bits) { return scene_->shapes()[static_cast<std::size_t>(c.key >> bits) & shape_mask].convex; };
  return c.system_b < 0 || (convex(44) && convex(24));
}

/// Whether the penetration depth of this pair of shapes is expensive to compute, while the distance is cheap.
bool GuardedStep::needs_gap(const collision::ContactPoint& c) const {
  if (c.system_b < 0) return false;
  const collision::SceneShape &a = scene_->shapes()[static_cast<std::size_t>(c.key >> 44) & shape_mask],
                              &b = scene_->shapes()[static_cast<std::size_t>(c.key >> 24) & shape_mask];
  return a.convex && b.convex && !(collision::has_closed_form(a.shape.type) && collision::has_closed_form(b.shape.type));
}

void GuardedStep::States::save(std::span<const StepSystem> systems) {
  for (std::size_t s = 0; s < systems.size(); ++s) {
    std::ranges::copy(systems[s].q, q[s].begin());
    std::ranges::copy(systems[s].v, v[s].begin());
  }
}

void GuardedStep::States::restore(std::span<const StepSystem> systems) const {
  for (std::size_t s = 0; s < systems.size(); ++s) {
    std::ranges::copy(q[s], systems[s].q.begin());
    std::ranges::copy(v[s], systems[s].v.begin());
  }
}

/// Solves the step without substeps, and repeats the solution while bodies overlap at the end of the step.
StepReport GuardedStep::step_whole(std::span<StepSystem> systems, std::span<const collision::ContactPoint> contacts, double dt) {
  attempt_begin_.save(systems);
  contacts_.assign(contacts.begin(), contacts.end());
  for (collision::ContactPoint& c : contacts_)
    if (needs_gap(c)) c.distance -= resting_gap;
  StepReport report;
  std::size_t known = contacts_.size();
  for (passes_ = 1;; ++passes_) {
    // New contacts with restitution are impacts: they need a complete step. Otherwise only the islands of new contacts are solved again.
    const auto added = std::span(contacts_).subspan(known);
    repeated_ = passes_ > 1 &&
                std::ranges::none_of(added, [&](const collision::ContactPoint& c) { return c.restitution > 0 || !stepper_->can_add(c); });
    report = repeated_ ? stepper_->repeat(systems, contacts_, dt) : stepper_->step(systems, contacts_, dt, contacts.size());
    known = contacts_.size();
    if (report.status != StepStatus::ok) break;
    if (passes_ == 1) {
      for (std::size_t s = 0; s < systems.size(); ++s) views_[s] = stepper_->workspace(static_cast<int>(s)).X_WB;
      collision::begin_from(*scene_, views_, contacts, workspace_);
      for (std::size_t s = 0; s < systems.size(); ++s) views_[s] = end_[s].values().X_WB;
    }
    update_end_poses(systems, dt);
    if (!add_overlaps(contacts, dt)) return report;
    attempt_begin_.restore(systems);
  }
  attempt_begin_.restore(systems);
  return report;
}

/// Whether a link of the system may pass through another: it moves by more than its half thickness. The motion is estimated from the
/// velocities of the links at the end of the pass, plus a quarter for links that are faster within the step.
bool GuardedStep::may_pass(std::size_t s, double dt) const {
  const dynamics::Kinematics& end = end_[s].values();
  std::size_t at = first_link_[s];
  for (std::size_t i = 0; i < end.V.size(); ++i, ++at) {
    const Vec6& V = end.V[i];
    const Vec3 origin = V.v + cross(V.w, end.X_WB[i].p - end.p0);
    if (1.25 * dt * (norm(origin) + norm(V.w) * size_[at]) > half_thickness_[at]) return true;
  }
  return false;
}

/// Finds when a body first passes through another at the present velocities. @return s: time from attempt_begin_ until then; dt: never
double GuardedStep::find_passage(std::span<const StepSystem> systems, double dt) {
  if (std::ranges::none_of(may_pass_, [](char may) { return may != 0; })) return dt;
  for (std::size_t s = 0; s < systems.size(); ++s) motions_[s] = {attempt_begin_.q[s], systems[s].v};
  return search_.find_passage(motions_, dt).time;
}

/// Sets near_ to the contacts of the present positions and to those that fast bodies reach within dt.
void GuardedStep::find_contacts(std::span<const StepSystem> systems, double dt) {
  for (std::size_t s = 0; s < systems.size(); ++s) {
    set_end(s, systems[s]);
    motions_[s] = {systems[s].q, systems[s].v};
  }
  collision::find_contacts(*scene_, views_, options_.margin, workspace_, near_);
  swept_.add(motions_, views_, dt, options_.margin, near_);
}

/// Sets the positions to those at `time` [s] after the beginning of the substep. The velocities stay;
/// contacts of the next substep or step stop the bodies.
void GuardedStep::stop_at(std::span<const StepSystem> systems, double time) {
  for (std::size_t s = 0; s < systems.size(); ++s)
    integrate(stepper_->mechanism(static_cast<int>(s)), attempt_begin_.q[s], systems[s].v, time, systems[s].q);
}

/// Adds the contact forces of a substep to the mean over the step. @param fraction length of the substep / length of the step
void GuardedStep::add_forces(double fraction) {
  const std::span<const Vec3> forces = stepper_->contact_forces();
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    if (forces[i] == Vec3{}) continue;
    std::size_t at = 0;
    while (at < all_contacts_.size() && all_contacts_[at].key != contacts_[i].key) ++at;
    if (at == all_contacts_.size()) {
      all_contacts_.push_back(contacts_[i]);
      forces_.emplace_back();
    }
    forces_[at] += forces[i] * fraction;
  }
}

/// Solves the step in substeps. The length of a substep is a power of two times 1/1024 of the step.
StepReport GuardedStep::step_in_substeps(std::span<StepSystem> systems, std::span<const collision::ContactPoint> contacts, double dt) {
  constexpr int units = 1024, max_attempts = 256;
  all_contacts_.assign(contacts.begin(), contacts.end());
  forces_.assign(contacts.size(), Vec3{});
  StepReport report, sum;
  sum.substeps = 0;
  int length = units / 2;
  for (int done = 0, attempts = 0; done < units; ++attempts) {
    const double h = dt * length / units;
    find_contacts(systems, h);
    report = step_whole(systems, near_, h);
    if (report.status != StepStatus::ok) {
      step_begin_.restore(systems);
      return report;
    }
    const double safe = find_passage(systems, h);
    const bool deep = depth_ > too_deep && length > units / 8;  // a wedged body stays deep in any substep, so further halving is useless
    if ((deep || (safe < h && length > 1)) && attempts < max_attempts && !search_.is_exhausted()) {
      attempt_begin_.restore(systems);
      length /= 2;
      continue;
    }
    if (safe < h) stop_at(systems, safe);
    add_forces(static_cast<double>(length) / units);
    report.stops = safe < h ? 1 : 0;
    report.left_overlaps = depth_ > too_deep ? 1 : 0;
    ++sum.substeps;
    sum.add(report);
    done += length;
    while (length < units - done && done % (2 * length) == 0) length *= 2;
    while (length > units - done) length /= 2;
    if (length == 0) break;
  }
  return sum;
}

StepReport GuardedStep::step(std::span<StepSystem> systems, std::span<const collision::ContactPoint> contacts, double dt) {
  stepper_->limit_newton(max_newton_operations);
  search_.limit_work(max_distances + max_distances_of_shape * static_cast<std::int64_t>(scene_->shapes().size()));
  swept_.limit_work(max_distances);
  StepReport report = step_whole(systems, contacts, dt);
  if (report.status == StepStatus::ok && (depth_ > too_deep || find_passage(systems, dt) < dt)) {
    attempt_begin_.restore(systems);
    std::swap(attempt_begin_, step_begin_);
    return step_in_substeps(systems, contacts, dt);
  }
  all_contacts_.assign(contacts_.begin(), contacts_.end());
  std::ranges::copy(contacts, all_contacts_.begin());  // the given distances, without resting_gap
  forces_.assign(stepper_->contact_forces().begin(), stepper_->contact_forces().end());
  return report;
}

}  // namespace ugoki::contact
