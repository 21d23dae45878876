#include "ugoki/collision/advancement.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/check.h"
#include "ugoki/collision/core.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::collision {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Motion of a body at one time, as needed to bound the approach of two bodies.
struct Mover {
  const Collider& shape;
  Pose X_WS;
  Vec3 v, w;     // world; v: m/s, of the bounding sphere's centre; w: rad/s
  double a = 0;  // m/s^2, of the centre; alpha: rad/s^2; both are upper bounds until the end of the step
  double alpha = 0;
};

/// Maximum distance [m] of the body's points from its centre. For convex bodies only the points of the core (support.h) count: the approach
/// is bounded for the cores, because rotation does not change the radius around them.
double reach(const Mover& m, bool convex) { return convex ? m.shape.bound - m.shape.support.radius : m.shape.bound; }

/// Bound of the approach of two bodies. Their distance d decreases within a time s at most to d(t) - (speed s + acceleration s^2 / 2).
struct Approach {
  double speed = 0;         // m/s
  double acceleration = 0;  // m/s^2, not negative

  /// Upper bound [m] of the approach within s [s].
  [[nodiscard]] double within(double s) const { return std::max(speed, 0.0) * s + 0.5 * acceleration * s * s; }
  /// Minimum time [s] in which the bodies can approach by `gap` > 0 [m]; infinite: never.
  [[nodiscard]] double time_for(double gap) const {
    const double root = std::sqrt(std::max(speed * speed + 2 * acceleration * gap, 0.0));
    const double divisor = speed + root;
    return divisor > 0 ? 2 * gap / divisor : infinity;
  }
};

/// Computes the bound of the approach of bodies a and b along n.
/// @param n unit, world: from b towards a, separates the bodies or their convex hulls; null: bound for every direction
Approach approach_of(const Mover& a, const Mover& b, const Vec3* n) {
  const double ra = reach(a, n != nullptr && a.shape.convex), rb = reach(b, n != nullptr && b.shape.convex);
  Approach out;
  if (n != nullptr)
    out.speed = dot(*n, b.v - a.v) + norm(cross(*n, a.w)) * ra + norm(cross(*n, b.w)) * rb;
  else
    out.speed = norm(b.v - a.v) + norm(a.w) * ra + norm(b.w) * rb;
  out.acceleration = a.a + b.a + a.alpha * ra + b.alpha * rb;
  return out;
}

/// Result of check_pair().
struct PairCheck {
  PairDistance near;
  double safe = 0;     ///< s: for this time the bodies stay farther apart than half the tolerance; infinite: until the end of the step
  bool known = false;  ///< false: a pose or velocity is not finite, or a shape has no surface
};

/// Measures the distance between bodies a and b, and computes a time in which they cannot touch.
/// @param remaining s: time until the end of the step
PairCheck check_pair(const Mover& a, const Mover& b, double remaining, double tolerance, PairCache& cache, DistanceWorkspace& workspace) {
  PairCheck out;
  const double maximum = approach_of(a, b, nullptr).within(remaining);
  if (!(maximum < infinity)) return out;
  out.near = find_pair_distance(a.shape, a.X_WS, b.shape, b.X_WS, maximum + tolerance, cache, workspace);
  out.known = out.near.lower > -infinity;
  if (!out.known || out.near.lower <= tolerance) return out;
  if (!out.near.exact && out.near.lower >= maximum + tolerance) {
    out.safe = infinity;
    return out;
  }
  const double gap = out.near.lower - 0.5 * tolerance;
  const bool separates = out.near.method != DistanceMethod::bubble;
  out.safe = approach_of(a, b, separates ? &out.near.n : nullptr).time_for(gap);
  return out;
}

/// Removes the spin of cylinders and capsules about their own axis, which does not move their surface. The remaining angular velocity
/// turns with the axis; its rate of change is added to alpha.
Mover without_spin(const Mover& m) {
  if (m.shape.shape.type != ShapeType::cylinder && m.shape.shape.type != ShapeType::capsule) return m;
  Mover out = m;
  const Vec3 axis = m.X_WS.R.column(2);
  out.w = m.w - axis * dot(axis, m.w);
  out.alpha = m.alpha + norm(m.w) * norm(out.w);
  return out;
}

}  // namespace

Pose BodyMotion::at(const Vec3& centre, double time) const {
  Pose X;
  X.R = to_matrix(exp_map(w * time)) * X_WS.R;
  X.p = X_WS * centre + v * time - X.R * centre;
  return X;
}

BodyMotion motion_between(const Collider& collider, const Pose& from, const Pose& to, double dt) {
  const Vec3 turn = log_map(to_quat(to.R * from.R.transposed()));
  return {from, turn / dt, (to * collider.centre - from * collider.centre) / dt};
}

Impact find_impact(const Collider& a, const BodyMotion& motion_a, const Collider& b, const BodyMotion& motion_b, double dt,
                   PairCache& cache, DistanceWorkspace& workspace, const AdvancementOptions& options) {
  Impact out;
  out.status = ImpactStatus::not_converged;
  while (out.iterations < options.max_iterations) {
    const Mover at_a{a, motion_a.at(a.centre, out.time), motion_a.v, motion_a.w, 0, 0};
    const Mover at_b{b, motion_b.at(b.centre, out.time), motion_b.v, motion_b.w, 0, 0};
    const PairCheck check = check_pair(at_a, at_b, dt - out.time, options.tolerance, cache, workspace);
    ++out.iterations;
    out.near = check.near;
    if (!check.known) {
      out.status = ImpactStatus::not_finite;
      return out;
    }
    if (check.safe <= 0) {
      out.status = out.time > 0 ? ImpactStatus::impact : ImpactStatus::touching;
      return out;
    }
    if (out.time + check.safe >= dt) {
      out.status = ImpactStatus::none;
      out.time = dt;
      return out;
    }
    out.time += check.safe;
  }
  return out;
}

ImpactSearch::ImpactSearch(const Scene& scene, const AdvancementOptions& options) : scene_(scene), options_(options) {
  ground_.shape.type = ShapeType::height_field;  // a type without closed form selects Gilbert's method on the half-space
  ground_.support = Support::half_space();
  for (const MechanismPtr& m : scene.systems()) {
    System& s = systems_.emplace_back();
    s.q.resize(static_cast<std::size_t>(m->nq()));
    const auto links = static_cast<std::size_t>(m->link_count());
    s.X_WB.resize(links);
    s.V.resize(links);
    s.bounds.resize(links);
  }
  sweeps_.resize(scene.shapes().size());
  system_sweeps_.resize(scene.systems().size());
  for (const SceneShape& shape : scene.shapes()) {
    half_width_.push_back(half_width_of(shape));
    const Vec3 centre = shape.shape.X_BS * shape.centre;
    balls_.push_back({shape.system, shape.link, centre, norm(centre), shape.bound});
  }
}

/// Computes poses and velocities at the beginning of the step, and upper bounds of the motion of each link at constant joint velocities:
///   |w| <= |w_parent| + |w_joint|,   |w'| <= |w'_parent| + |w_parent| |w_joint|,
///   |a| <= |a_parent| + (|w'_parent| + |w_parent|^2) L + 2 |w_parent| |v_joint|
/// w: angular velocity of the link; w': its rate of change; a: acceleration of the link's origin; w_joint, v_joint: angular and linear
/// velocity of the joint; L: maximum distance between the origins of the link and its parent.
void ImpactSearch::prepare(std::size_t system, const SystemMotion& motion, double dt) {
  System& s = systems_[system];
  const Mechanism& m = *scene_.systems()[system];
  UGOKI_CHECK(static_cast<int>(motion.q.size()) == m.nq() && static_cast<int>(motion.v.size()) == m.nv());
  s.time = 0;
  if (motion.X_WB.empty())
    calc_poses(m, motion.q, s.X_WB);
  else
    std::ranges::copy(motion.X_WB, s.X_WB.begin());
  for (int i = 0; i < m.link_count(); ++i) {
    const Link& link = m.link(i);
    const Joint& joint = link.joint;
    const double *q = motion.q.data() + link.q_index, *v = motion.v.data() + link.v_index;
    const LinkBound parent = link.parent < 0 ? LinkBound{} : s.bounds[static_cast<std::size_t>(link.parent)];
    const Pose X_J = joint_pose(joint, q);
    Vec6 S[6], rate, V;
    const int dofs = joint_subspace(joint, q, S);
    if (link.parent >= 0) V = (joint.X_PJ * X_J).motion_to_child(s.V[static_cast<std::size_t>(link.parent)]);
    for (int k = 0; k < dofs; ++k) {
      rate += S[k] * v[k];
      V += S[k] * v[k];
    }
    s.V[static_cast<std::size_t>(i)] = V;
    double w = norm(rate.w), alpha = 0;
    const double slide = norm(rate.v);
    if (joint.type == JointType::universal) {
      w = std::fabs(v[0]) + std::fabs(v[1]);
      alpha = std::fabs(v[0] * v[1]);
    }
    const double length = norm(joint.X_PJ.p) + norm(X_J.p) + slide * dt;
    LinkBound& out = s.bounds[static_cast<std::size_t>(i)];
    out.w = parent.w + w;
    out.alpha = parent.alpha + parent.w * w + alpha;
    out.a = parent.a + (parent.alpha + parent.w * parent.w) * length + 2 * parent.w * slide;
  }
}

void ImpactSearch::move_to(std::size_t system, double time) {
  System& s = systems_[system];
  if (s.time == time) return;
  const Mechanism& m = *scene_.systems()[system];
  const SystemMotion& motion = motions_[system];
  integrate(m, motion.q, motion.v, time, s.q);
  calc_poses(m, s.q, s.X_WB);
  calc_velocities(m, s.q, motion.v, s.V);
  s.time = time;
}

ImpactSearch::Moving ImpactSearch::moving(int shape, double time) {
  if (shape < 0) return {{Mat3::identity(), {0, 0, scene_.ground().height}}, {}, {}, 0, 0};
  const SceneShape& part = scene_.shapes()[static_cast<std::size_t>(shape)];
  const auto k = static_cast<std::size_t>(part.system), link = static_cast<std::size_t>(part.link);
  move_to(k, time);
  const System& s = systems_[k];
  const Pose& X = s.X_WB[link];
  const Vec3 at = part.shape.X_BS * part.centre;  // m, link's frame: centre of the bounding sphere
  const LinkBound& bound = s.bounds[link];
  Moving out;
  out.X_WS = X * part.shape.X_BS;
  out.w = X.R * s.V[link].w;
  out.v = X.R * (s.V[link].v + cross(s.V[link].w, at));
  out.alpha = bound.alpha;
  out.a = bound.a + (bound.alpha + bound.w * bound.w) * norm(at);
  return out;
}

void ImpactSearch::add_candidate(int a, int b) {
  const SceneShape& sa = scene_.shapes()[static_cast<std::size_t>(a)];
  const Sweep& wa = sweeps_[static_cast<std::size_t>(a)];
  if (b < 0) {
    if (!sa.movable || wa.travel < min_travel_ || wa.centre.z - wa.radius > scene_.ground().height + options_.tolerance) return;
  } else {
    const Sweep& wb = sweeps_[static_cast<std::size_t>(b)];
    if (wa.travel + wb.travel < min_travel_) return;
    const SceneShape& sb = scene_.shapes()[static_cast<std::size_t>(b)];
    if ((!sa.movable && !sb.movable) || !can_collide(sa.shape, sb.shape)) return;
    const Vec3 gap = wa.centre - wb.centre;
    const double reach = wa.radius + wb.radius + options_.tolerance;
    if (dot(gap, gap) > reach * reach) return;
  }
  candidates_.push_back({a, b, 0, 0, {}});
}

/// Sets the box of each system that contains its swept spheres, enlarged by the tolerance, and the maximum travel of its shapes.
void ImpactSearch::find_system_sweeps() {
  const double tolerance = options_.tolerance;
  for (std::size_t s = 0; s < system_sweeps_.size(); ++s) {
    SystemSweep& out = system_sweeps_[s];
    out = {};
    for (int i = scene_.first_shape(static_cast<int>(s)); i < scene_.first_shape(static_cast<int>(s) + 1); ++i) {
      const Sweep& w = sweeps_[static_cast<std::size_t>(i)];
      const double r = w.radius + 0.5 * tolerance;
      out.travel = std::max(out.travel, w.travel);
      out.low = {std::min(out.low.x, w.centre.x - r), std::min(out.low.y, w.centre.y - r), std::min(out.low.z, w.centre.z - r)};
      out.high = {std::max(out.high.x, w.centre.x + r), std::max(out.high.y, w.centre.y + r), std::max(out.high.z, w.centre.z + r)};
    }
  }
}

/// Collects the pairs of shapes of two systems whose swept spheres overlap.
void ImpactSearch::add_candidates_between(int system_a, int system_b) {
  const SystemSweep &a = system_sweeps_[static_cast<std::size_t>(system_a)], &b = system_sweeps_[static_cast<std::size_t>(system_b)];
  if (a.travel + b.travel < min_travel_ || a.low.y > b.high.y || b.low.y > a.high.y || a.low.z > b.high.z || b.low.z > a.high.z) return;
  for (int i = scene_.first_shape(system_a); i < scene_.first_shape(system_a + 1); ++i) {
    const Sweep& w = sweeps_[static_cast<std::size_t>(i)];
    const double r = w.radius + 0.5 * options_.tolerance;
    if (w.travel + b.travel < min_travel_ || w.centre.x - r > b.high.x || b.low.x > w.centre.x + r || w.centre.y - r > b.high.y ||
        b.low.y > w.centre.y + r || w.centre.z - r > b.high.z || b.low.z > w.centre.z + r)
      continue;
    for (int j = scene_.first_shape(system_b); j < scene_.first_shape(system_b + 1); ++j) add_candidate(i, j);
  }
}

/// Collects the pairs whose swept spheres overlap. The boxes of the systems are sorted along x, so that only systems whose sweeps overlap
/// along x are compared.
void ImpactSearch::find_candidates() {
  candidates_.clear();
  const int systems = static_cast<int>(scene_.systems().size()), shapes = static_cast<int>(scene_.shapes().size());
  if (scene_.options().with_ground)
    for (int i = 0; i < shapes; ++i) add_candidate(i, -1);
  for (int s = 0; s < systems; ++s)
    if (scene_.self_collision(s))
      for (const ShapePair& p : scene_.self_pairs(s)) add_candidate(p.a, p.b);
  if (!scene_.options().between_systems) return;
  find_system_sweeps();
  order_.clear();
  for (int s = 0; s < systems; ++s) order_.push_back({system_sweeps_[static_cast<std::size_t>(s)].low.x, s});
  std::ranges::sort(order_);
  for (std::size_t k = 0; k < order_.size(); ++k) {
    const double end = system_sweeps_[static_cast<std::size_t>(order_[k].second)].high.x;
    for (std::size_t l = k + 1; l < order_.size() && order_[l].first <= end; ++l)
      add_candidates_between(std::min(order_[k].second, order_[l].second), std::max(order_[k].second, order_[l].second));
  }
}

SceneImpact ImpactSearch::make_impact(const Candidate& c, const PairDistance& d, ImpactStatus status) const {
  const SceneShape& a = scene_.shapes()[static_cast<std::size_t>(c.a)];
  SceneImpact out;
  out.status = status;
  out.time = c.time;
  out.shape_a = c.a;
  out.shape_b = c.b;
  out.contact.system_a = a.system;
  out.contact.link_a = a.link;
  out.contact.p = (d.pa + d.pb) * 0.5;
  out.contact.n = d.n;
  out.contact.distance = d.distance;
  out.contact.friction = a.ground_friction;
  out.contact.restitution = a.ground_restitution;
  if (c.b >= 0) {
    const SceneShape& b = scene_.shapes()[static_cast<std::size_t>(c.b)];
    out.contact.system_b = b.system;
    out.contact.link_b = b.link;
    out.contact.friction = pair_friction(a.shape, b.shape);
    out.contact.restitution = std::max(a.shape.restitution, b.shape.restitution);
  }
  return out;
}

void ImpactSearch::prepare_all(double dt, double min_travel) {
  min_travel_ = min_travel;
  for (std::size_t s = 0; s < motions_.size(); ++s) prepare(s, motions_[s], dt);
  for (std::size_t i = 0; i < sweeps_.size(); ++i) {
    const Ball& ball = balls_[i];
    const System& s = systems_[static_cast<std::size_t>(ball.system)];
    const auto link = static_cast<std::size_t>(ball.link);
    const LinkBound& bound = s.bounds[link];
    const Vec6& V = s.V[link];
    const Vec3 v = s.X_WB[link].R * (V.v + cross(V.w, ball.centre));
    const double a = bound.a + (bound.alpha + bound.w * bound.w) * ball.lever, speed = norm(v);
    // The swept sphere is centred at the midpoint of the path of the shape's centre at constant velocity.
    sweeps_[i] = {s.X_WB[link] * ball.centre + v * (0.5 * dt), ball.radius + 0.5 * dt * speed + 0.5 * a * dt * dt,
                  speed * dt + 0.5 * a * dt * dt + (norm(V.w) * dt + 0.5 * bound.alpha * dt * dt) * ball.radius};
  }
}

SceneImpact ImpactSearch::find(std::span<const SystemMotion> systems, double dt, double margin) {
  UGOKI_CHECK(systems.size() == systems_.size());
  motions_ = systems;
  prepare_all(dt, margin);  // pairs that start closer than margin are skipped; others cannot touch if they travel less than margin
  find_candidates();
  // The candidate with the earliest safe time is checked next. The first candidate that touches is therefore the first impact.
  const auto later = [&](std::uint32_t x, std::uint32_t y) {
    return candidates_[x].time != candidates_[y].time ? candidates_[x].time > candidates_[y].time : x > y;
  };
  queue_.clear();
  for (std::uint32_t i = 0; i < candidates_.size(); ++i) queue_.push_back(i);
  SceneImpact out;
  out.time = dt;
  out.pairs = static_cast<int>(candidates_.size());
  int distances = 0;
  while (!queue_.empty()) {
    Candidate& c = candidates_[queue_.front()];
    std::pop_heap(queue_.begin(), queue_.end(), later);
    const Moving a = moving(c.a, c.time), b = moving(c.b, c.time);
    const Collider& shape_b = c.b < 0 ? ground_ : static_cast<const Collider&>(scene_.shapes()[static_cast<std::size_t>(c.b)]);
    const PairCheck check = check_pair({scene_.shapes()[static_cast<std::size_t>(c.a)], a.X_WS, a.v, a.w, a.a, a.alpha},
                                       {shape_b, b.X_WS, b.v, b.w, b.a, b.alpha}, dt - c.time, options_.tolerance, c.cache, workspace_);
    ++distances;
    ++c.iterations;
    --work_left_;
    const bool is_contact = c.time == 0 && check.known && check.near.exact && check.near.distance <= margin;
    const bool touches = !is_contact && !(check.safe > 0), exhausted = c.iterations >= options_.max_iterations || is_exhausted();
    if (touches || (exhausted && c.time + check.safe < dt && !is_contact)) {
      const ImpactStatus status = !check.known ? ImpactStatus::not_finite : touches ? ImpactStatus::impact : ImpactStatus::not_converged;
      const int pairs = out.pairs;
      out = make_impact(c, check.near, status);
      out.pairs = pairs;
      break;
    }
    c.time += check.safe;
    if (is_contact || c.time >= dt) {
      queue_.pop_back();
    } else {
      std::push_heap(queue_.begin(), queue_.end(), later);
    }
  }
  out.distances = distances;
  return out;
}

/// True if the penetration depth of two convex bodies may exceed the limit of find_passage() before `end` [s]. The depth stays below the
/// limit until c.time. This holds because the signed distance between convex bodies decreases at most as fast as their points approach
/// along its normal, also while they overlap. `both` is the sum of the half widths. The search stops 2 % of `both` before the limit. Each
/// iteration aims at 1 % of `both` before the limit, so that the number of iterations stays small.
bool ImpactSearch::passes_through(Candidate& c, double end, double dt) {
  constexpr int max_checks = 20000;  // limits the loop; a pair that reaches this count is reported as unsafe
  const SceneShape &sa = scene_.shapes()[static_cast<std::size_t>(c.a)], &sb = scene_.shapes()[static_cast<std::size_t>(c.b)];
  const double both = half_width_[static_cast<std::size_t>(c.a)] + half_width_[static_cast<std::size_t>(c.b)];
  double deepest = 0.5 * both;
  for (int check_count = 0; check_count < max_checks && !is_exhausted(); ++check_count) {
    --work_left_;
    const Moving at_a = moving(c.a, c.time), at_b = moving(c.b, c.time);
    const Mover a = without_spin({sa, at_a.X_WS, at_a.v, at_a.w, at_a.a, at_a.alpha});
    const Mover b = without_spin({sb, at_b.X_WS, at_b.v, at_b.w, at_b.a, at_b.alpha});
    const double maximum = approach_of(a, b, nullptr).within(dt - c.time);
    if (!(maximum < infinity) || (c.time == 0 && maximum < both)) return false;
    const PairDistance d = find_pair_distance(sa, a.X_WS, sb, b.X_WS, maximum + options_.tolerance, c.cache, workspace_);
    if (!(d.lower > -infinity)) return false;
    if (c.time == 0) deepest = std::max(deepest, -d.distance + 0.1 * both);  // a pair that overlaps at the beginning may keep its depth
    if (maximum < d.lower + deepest) return false;
    const double left = d.lower + deepest;
    if (!(left > 0.02 * both)) return true;
    c.time += approach_of(a, b, norm(d.n) > 0.5 ? &d.n : nullptr).time_for(left - 0.01 * both);
    if (c.time >= end) return false;
  }
  return true;  // max_checks or limit_work() is reached: the rest of the step is not proved safe
}

/// True if, before `end` [s], the core of the pair's convex shape may come closer to the surface of the other shape than `tolerance`.
bool ImpactSearch::core_touches(Candidate& c, double end, double dt) {
  constexpr int max_checks = 20000;  // limits the loop; a pair that reaches this count is reported as unsafe
  const SceneShape &sa = scene_.shapes()[static_cast<std::size_t>(c.a)], &sb = scene_.shapes()[static_cast<std::size_t>(c.b)];
  const Core* const core = (sa.convex ? sa : sb).core.get();
  if (core == nullptr) return false;
  const double depth = core->depth;
  double tolerance = 0.1 * depth;  // m: stop before the core touches, so that its side of the surface is known in the next step
  for (int check_count = 0; check_count < max_checks && !is_exhausted(); ++check_count) {
    --work_left_;
    const Moving at_a = moving(c.a, c.time), at_b = moving(c.b, c.time);
    const Mover a =
        without_spin({sa.convex ? core->collider : static_cast<const Collider&>(sa), at_a.X_WS, at_a.v, at_a.w, at_a.a, at_a.alpha});
    const Mover b =
        without_spin({sb.convex ? core->collider : static_cast<const Collider&>(sb), at_b.X_WS, at_b.v, at_b.w, at_b.a, at_b.alpha});
    if (c.time == 0 && approach_of(a, b, nullptr).within(dt) < 0.02 * depth) return false;
    PairCheck check = check_pair(a, b, dt - c.time, tolerance, c.cache, workspace_);
    if (c.time == 0 && check.known && !(check.safe > 0)) {
      tolerance = 0.5 * check.near.lower;
      if (!(tolerance > 1e-9 * depth)) return false;  // a core that touches at the beginning may stay where it is
      check = check_pair(a, b, dt, tolerance, c.cache, workspace_);
    }
    if (!check.known || check.safe == infinity) return false;
    if (!(check.safe > 0)) return true;
    c.time += check.safe;
    if (c.time >= end) return false;
  }
  return true;  // max_checks or limit_work() is reached: the rest of the step is not proved safe
}

SceneImpact ImpactSearch::find_passage(std::span<const SystemMotion> systems, double dt) {
  UGOKI_CHECK(systems.size() == systems_.size());
  motions_ = systems;
  prepare_all(dt, 0);
  find_candidates();
  SceneImpact out;
  out.time = dt;
  for (Candidate& c : candidates_) {
    if (c.b < 0) continue;
    const int convex =
        (scene_.shapes()[static_cast<std::size_t>(c.a)].convex ? 1 : 0) + (scene_.shapes()[static_cast<std::size_t>(c.b)].convex ? 1 : 0);
    if (convex == 0 || !(convex == 2 ? passes_through(c, out.time, dt) : core_touches(c, out.time, dt))) continue;
    out = make_impact(c, {}, ImpactStatus::impact);
  }
  return out;
}

}  // namespace ugoki::collision
