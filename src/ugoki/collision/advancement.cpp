#include "ugoki/collision/advancement.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/check.h"
#include "ugoki/collision/core.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::collision {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// A body at a moment, as far as the bound needs it.
struct Mover {
  const Collider& shape;
  Pose X_WS;
  Vec3 v, w;     // m/s of the centre, rad/s; world
  double a = 0;  // m/s^2, rad/s^2: greatest accelerations until the end
  double alpha = 0;
};

/// How far [m] points of the body can be from its centre, less what is round about a core: turning does not move that.
double reach(const Mover& m, bool convex) { return convex ? m.shape.bound - m.shape.support.radius : m.shape.bound; }

/// d(t + s) >= d(t) - (speed s + acceleration s^2 / 2), whichever of the two points is nearest.
struct Approach {
  double speed = 0;         // m/s
  double acceleration = 0;  // m/s^2, not negative

  [[nodiscard]] double within(double s) const { return std::max(speed, 0.0) * s + 0.5 * acceleration * s * s; }
  /// Time in which they can come closer by `gap` > 0; infinite: never.
  [[nodiscard]] double time_for(double gap) const {
    const double root = std::sqrt(std::max(speed * speed + 2 * acceleration * gap, 0.0));
    const double divisor = speed + root;
    return divisor > 0 ? 2 * gap / divisor : infinity;
  }
};

/// Along n, from b towards a, that separates convex bodies (or hulls); without n, in any direction.
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

/// What one look at a pair tells.
struct Look {
  PairDistance near;
  double safe = 0;  ///< s from now in which they do not come closer than half the tolerance; infinite: not until the end
  bool known = false;
};

Look look_at(const Mover& a, const Mover& b, double remaining, double tolerance, PairCache& cache, DistanceWorkspace& workspace) {
  Look out;
  const double most = approach_of(a, b, nullptr).within(remaining);
  if (!(most < infinity)) return out;
  out.near = find_pair_distance(a.shape, a.X_WS, b.shape, b.X_WS, most + tolerance, cache, workspace);
  out.known = out.near.lower > -infinity;
  if (!out.known || out.near.lower <= tolerance) return out;
  if (!out.near.exact && out.near.lower >= most + tolerance) {
    out.safe = infinity;
    return out;
  }
  const double gap = out.near.lower - 0.5 * tolerance;
  const bool separates = out.near.method != DistanceMethod::bubble;
  out.safe = approach_of(a, b, separates ? &out.near.n : nullptr).time_for(gap);
  return out;
}

/// A spin about the axis of what is round about it moves nothing; what is left turns with the axis.
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
    const Look look = look_at(at_a, at_b, dt - out.time, options.tolerance, cache, workspace);
    ++out.iterations;
    out.near = look.near;
    if (!look.known) {
      out.status = ImpactStatus::not_finite;
      return out;
    }
    if (look.safe <= 0) {
      out.status = out.time > 0 ? ImpactStatus::impact : ImpactStatus::touching;
      return out;
    }
    if (out.time + look.safe >= dt) {
      out.status = ImpactStatus::none;
      out.time = dt;
      return out;
    }
    out.time += look.safe;
  }
  return out;
}

ImpactSearch::ImpactSearch(const Scene& scene, const AdvancementOptions& options) : scene_(scene), options_(options) {
  ground_.shape.type = ShapeType::height_field;  // no closed form
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
  for (const SceneShape& shape : scene.shapes()) half_width_.push_back(half_width_of(shape));
}

/// Poses and velocities at the beginning, and bounds of the accelerations at constant joint velocities:
///   |w| <= |w_parent| + |w_joint|,   |w'| <= |w'_parent| + |w_parent| |w_joint|,
///   |a| <= |a_parent| + (|w'_parent| + |w_parent|^2) L + 2 |w_parent| |v_joint|,   L: from origin to origin, at most
void ImpactSearch::prepare(std::size_t system, const SystemMotion& motion, double dt) {
  System& s = systems_[system];
  const Mechanism& m = *scene_.systems()[system];
  UGOKI_CHECK(static_cast<int>(motion.q.size()) == m.nq() && static_cast<int>(motion.v.size()) == m.nv());
  s.time = -1;
  move_to(system, 0);
  for (int i = 0; i < m.link_count(); ++i) {
    const Link& link = m.link(i);
    const Joint& joint = link.joint;
    const double *q = motion.q.data() + link.q_index, *v = motion.v.data() + link.v_index;
    const LinkBound parent = link.parent < 0 ? LinkBound{} : s.bounds[static_cast<std::size_t>(link.parent)];
    Vec6 S[6], rate;
    const int freedoms = joint_subspace(joint, q, S);
    for (int k = 0; k < freedoms; ++k) rate += S[k] * v[k];
    double w = norm(rate.w), alpha = 0;
    const double slide = norm(rate.v);
    if (joint.type == JointType::universal) {
      w = std::fabs(v[0]) + std::fabs(v[1]);
      alpha = std::fabs(v[0] * v[1]);
    }
    const double length = norm(joint.X_PJ.p) + norm(joint_pose(joint, q).p) + slide * dt;
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
  const Vec3 at = part.shape.X_BS * part.centre;  // in the link's frame
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
    if (!sa.movable || wa.way < least_way_ || wa.centre.z - wa.radius > scene_.ground().height + options_.tolerance) return;
  } else {
    const Sweep& wb = sweeps_[static_cast<std::size_t>(b)];
    if (wa.way + wb.way < least_way_) return;
    if (!sa.movable && !scene_.shapes()[static_cast<std::size_t>(b)].movable) return;
    const Vec3 gap = wa.centre - wb.centre;
    const double reach = wa.radius + wb.radius + options_.tolerance;
    if (dot(gap, gap) > reach * reach) return;
  }
  candidates_.push_back({a, b, 0, 0, {}});
}

/// Between systems: sorted along x, so that only shapes whose ways overlap there are compared.
void ImpactSearch::find_candidates() {
  candidates_.clear();
  const int systems = static_cast<int>(scene_.systems().size()), shapes = static_cast<int>(scene_.shapes().size());
  if (scene_.options().with_ground)
    for (int i = 0; i < shapes; ++i) add_candidate(i, -1);
  for (int s = 0; s < systems; ++s)
    if (scene_.self_collision(s))
      for (const ShapePair& p : scene_.self_pairs(s)) add_candidate(p.a, p.b);
  if (!scene_.options().between_systems) return;
  order_.clear();
  for (int i = 0; i < shapes; ++i) {
    const Sweep& w = sweeps_[static_cast<std::size_t>(i)];
    order_.push_back({w.centre.x - w.radius, i});
  }
  std::ranges::sort(order_);
  for (std::size_t k = 0; k < order_.size(); ++k) {
    const int i = order_[k].second;
    const Sweep& w = sweeps_[static_cast<std::size_t>(i)];
    const double end = w.centre.x + w.radius + options_.tolerance;
    for (std::size_t l = k + 1; l < order_.size() && order_[l].first <= end; ++l) {
      const int j = order_[l].second;
      if (scene_.shapes()[static_cast<std::size_t>(i)].system != scene_.shapes()[static_cast<std::size_t>(j)].system)
        add_candidate(std::min(i, j), std::max(i, j));
    }
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
    out.contact.friction = std::sqrt(a.shape.friction * b.shape.friction);
    out.contact.restitution = std::max(a.shape.restitution, b.shape.restitution);
  }
  return out;
}

void ImpactSearch::prepare_all(double dt, double least_way) {
  least_way_ = least_way;
  for (std::size_t s = 0; s < motions_.size(); ++s) prepare(s, motions_[s], dt);
  for (std::size_t i = 0; i < sweeps_.size(); ++i) {
    const Moving m = moving(static_cast<int>(i), 0);
    const SceneShape& shape = scene_.shapes()[i];
    // The middle of the centre's way, were it straight.
    const double way = norm(m.v) * dt + 0.5 * m.a * dt * dt;
    sweeps_[i] = {m.X_WS * shape.centre + m.v * (0.5 * dt), shape.bound + 0.5 * dt * norm(m.v) + 0.5 * m.a * dt * dt,
                  way + (norm(m.w) * dt + 0.5 * m.alpha * dt * dt) * shape.bound};
  }
}

SceneImpact ImpactSearch::find(std::span<const SystemMotion> systems, double dt, double margin) {
  UGOKI_CHECK(systems.size() == systems_.size());
  motions_ = systems;
  prepare_all(dt, margin);  // what is nearer is left out, and others cannot touch
  find_candidates();
  // Whoever may be first is looked at next, so that the first that touches is the first of all.
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
    const Look look = look_at({scene_.shapes()[static_cast<std::size_t>(c.a)], a.X_WS, a.v, a.w, a.a, a.alpha},
                              {shape_b, b.X_WS, b.v, b.w, b.a, b.alpha}, dt - c.time, options_.tolerance, c.cache, workspace_);
    ++distances;
    ++c.iterations;
    const bool left_out = c.time == 0 && look.known && look.near.exact && look.near.distance <= margin;
    const bool touches = !left_out && !(look.safe > 0), exhausted = c.iterations >= options_.max_iterations;
    if (touches || (exhausted && c.time + look.safe < dt && !left_out)) {
      const ImpactStatus status = !look.known ? ImpactStatus::not_finite : touches ? ImpactStatus::impact : ImpactStatus::not_converged;
      const int pairs = out.pairs;
      out = make_impact(c, look.near, status);
      out.pairs = pairs;
      break;
    }
    c.time += look.safe;
    if (left_out || c.time >= dt) {
      queue_.pop_back();
    } else {
      std::push_heap(queue_.begin(), queue_.end(), later);
    }
  }
  out.distances = distances;
  return out;
}

/// The signed distance of convex bodies falls no faster along its normal than their points approach along it, also where they overlap.
bool ImpactSearch::passes(Candidate& c, double end, double dt) {
  constexpr int most_looks = 20000;
  const SceneShape &sa = scene_.shapes()[static_cast<std::size_t>(c.a)], &sb = scene_.shapes()[static_cast<std::size_t>(c.b)];
  const double both = half_width_[static_cast<std::size_t>(c.a)] + half_width_[static_cast<std::size_t>(c.b)];
  double deepest = 0.5 * both;
  for (int look = 0; look < most_looks; ++look) {
    const Moving at_a = moving(c.a, c.time), at_b = moving(c.b, c.time);
    const Mover a = without_spin({sa, at_a.X_WS, at_a.v, at_a.w, at_a.a, at_a.alpha});
    const Mover b = without_spin({sb, at_b.X_WS, at_b.v, at_b.w, at_b.a, at_b.alpha});
    const double most = approach_of(a, b, nullptr).within(dt - c.time);
    if (!(most < infinity) || (c.time == 0 && most < both)) return false;
    const PairDistance d = find_pair_distance(sa, a.X_WS, sb, b.X_WS, most + options_.tolerance, c.cache, workspace_);
    if (!(d.lower > -infinity)) return false;
    if (c.time == 0) deepest = std::max(deepest, -d.distance + 0.1 * both);  // what was deep already may stay so
    if (most < d.lower + deepest) return false;
    const double left = d.lower + deepest;
    if (!(left > 0.02 * both)) return true;
    c.time += approach_of(a, b, norm(d.n) > 0.5 ? &d.n : nullptr).time_for(left - 0.01 * both);
    if (c.time >= end) return false;
  }
  return true;  // not known to be safe any longer
}

/// The core of the one that is convex touches the other's surface.
bool ImpactSearch::core_touches(Candidate& c, double end, double dt) {
  constexpr int most_looks = 20000;
  const SceneShape &sa = scene_.shapes()[static_cast<std::size_t>(c.a)], &sb = scene_.shapes()[static_cast<std::size_t>(c.b)];
  const Core* const core = (sa.convex ? sa : sb).core.get();
  if (core == nullptr) return false;
  const double depth = core->depth;
  double tolerance = 0.1 * depth;  // it stops before it touches, so that the next step knows the side
  for (int look = 0; look < most_looks; ++look) {
    const Moving at_a = moving(c.a, c.time), at_b = moving(c.b, c.time);
    const Mover a =
        without_spin({sa.convex ? core->collider : static_cast<const Collider&>(sa), at_a.X_WS, at_a.v, at_a.w, at_a.a, at_a.alpha});
    const Mover b =
        without_spin({sb.convex ? core->collider : static_cast<const Collider&>(sb), at_b.X_WS, at_b.v, at_b.w, at_b.a, at_b.alpha});
    if (c.time == 0 && approach_of(a, b, nullptr).within(dt) < 0.02 * depth) return false;
    Look near = look_at(a, b, dt - c.time, tolerance, c.cache, workspace_);
    if (c.time == 0 && near.known && !(near.safe > 0)) {
      tolerance = 0.5 * near.near.lower;
      if (!(tolerance > 1e-9 * depth)) return false;  // what was deep already may stay so
      near = look_at(a, b, dt, tolerance, c.cache, workspace_);
    }
    if (!near.known || near.safe == infinity) return false;
    if (!(near.safe > 0)) return true;
    c.time += near.safe;
    if (c.time >= end) return false;
  }
  return true;  // not known to be safe any longer
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
    if (convex == 0 || !(convex == 2 ? passes(c, out.time, dt) : core_touches(c, out.time, dt))) continue;
    out = make_impact(c, {}, ImpactStatus::impact);
  }
  return out;
}

}  // namespace ugoki::collision
