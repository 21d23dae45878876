#pragma once
// Gilbert's search of two hulls in slow motion, for the translation units that compile it for each width of registers: the same operations
// in the same order, so the same bits. Everything stays in lanes and is chosen by masks, so that nothing waits for memory or for
// a branch that cannot be foretold: the hulls are looked at ring by ring (a vertex and its neighbours), one ring of each a step.
// Internal linkage on purpose: see gilbert_search.h.

#include <cmath>

#include "ugoki/collision/gilbert_search.h"
#include "ugoki/collision/lane_simplex.h"

#ifdef __clang__
#define UGOKI_UNPREDICTABLE(condition) __builtin_unpredictable(condition)
#else
#define UGOKI_UNPREDICTABLE(condition) (condition)
#endif

namespace ugoki::collision {
namespace {  // NOLINT(google-build-namespaces): see above

constexpr int most_rings = 24;        ///< looked at before the general search takes over
constexpr double least_apart = 1e-5;  ///< of the coordinates: nearer pairs are the general search's
constexpr double level = 1e-15;       ///< of the coordinates: neighbours that are higher by less are as high

/// Leaves points where they are.
struct InPlace {
  Four3 operator()(const Four3& q) const { return q; }
};

/// A pose, each of its numbers in all lanes.
struct LanePose {
  Four3 x, y, z;  ///< rows
  Four3 p;        ///< m

  Four3 operator()(const Four3& q) const {
    return {x.x * q.x + x.y * q.y + x.z * q.z + p.x, y.x * q.x + y.y * q.y + y.z * q.z + p.y, z.x * q.x + z.y * q.y + z.z * q.z + p.z};
  }
  Four3 turn(const Four3& q) const {
    return {x.x * q.x + x.y * q.y + x.z * q.z, y.x * q.x + y.y * q.y + y.z * q.z, z.x * q.x + z.y * q.y + z.z * q.z};
  }
};

/// Row `row` of a pose's matrix; the last lane is whatever follows it there.
static inline Four row_of(const Pose& X, int row) {
  static_assert(sizeof(Pose) == 12 * sizeof(double));
  Four out;
  __builtin_memcpy(&out, reinterpret_cast<const char*>(&X) + row * 24, sizeof out);
  return out;
}

/// Pose of b in a.
static inline LanePose between(const Pose& X_WA, const Pose& X_WB) {
  const Four a0 = row_of(X_WA, 0), a1 = row_of(X_WA, 1), a2 = row_of(X_WA, 2);
  const Four b0 = row_of(X_WB, 0), b1 = row_of(X_WB, 1), b2 = row_of(X_WB, 2);
  const Mat3& A = X_WA.R;
  const Four x = all(A.xx) * b0 + all(A.yx) * b1 + all(A.zx) * b2;
  const Four y = all(A.xy) * b0 + all(A.yy) * b1 + all(A.zy) * b2;
  const Four z = all(A.xz) * b0 + all(A.yz) * b1 + all(A.zz) * b2;
  const Four p = a0 * all(X_WB.p.x - X_WA.p.x) + a1 * all(X_WB.p.y - X_WA.p.y) + a2 * all(X_WB.p.z - X_WA.p.z);
  return {spread(x), spread(y), spread(z), spread(p)};
}

/// Where a step on a hull has led, in the frame of a.
struct Place {
  Four3 at;  ///< m, all lanes the same
  std::int32_t vertex;
  bool moved;
};

/// How points of a hull come into the frame of a, made when it is needed.
struct StayInPlace {
  InPlace operator()() const { return {}; }
};
struct MoveBetween {
  const Pose &X_WA, &X_WB;
  LanePose operator()() const { return between(X_WA, X_WB); }
};

/// A step among the neighbours beyond eight, after one among the eight. Makes the motion anew, so that nothing of the search must lie in
/// memory for it.
template <class Make>
[[gnu::noinline]] static Place step_beyond(const Hull& h, const HullWalk::Node& node, Make make, Four3 v, double slack, Place best) {
  const auto move = make();
  const auto more = static_cast<std::size_t>(node.more), count = static_cast<std::size_t>(node.more_count);
  for (std::size_t i = more; i < more + count; ++i) {
    const std::int32_t vertex = h.walk.overflow[i];
    const Four3 at = move(all(h.vertices[static_cast<std::size_t>(vertex)]));
    if (dot(v, at)[0] < dot(v, best.at)[0] - (best.moved ? 0 : slack)) best = {at, vertex, true};
  }
  return best;
}

/// A vertex and its neighbours.
struct Ring {
  std::int32_t vertex;
  const HullWalk::Node* node;
  Four3 low, high;  ///< m, frame of a: the neighbours
};

/// @param move from the hull's frame to that of a
template <class Move>
static inline Ring ring_at(const Hull& h, std::int32_t vertex, const Move& move) {
  const HullWalk::Node& node = h.walk.nodes[static_cast<std::size_t>(vertex)];
  return {vertex, &node, move(Four3{four_at(node.x), four_at(node.y), four_at(node.z)}),
          move(Four3{four_at(node.x + 4), four_at(node.y + 4), four_at(node.z + 4)})};
}

/// One step down along v: to the lowest neighbour (of which those that differ by rounding are as good), or none.
/// @param at the ring's middle in the frame of a, all lanes the same
template <class Make>
static inline Place step_down(const Hull& h, const Ring& ring, const Four3& at, const Make& make, const Four3& v, double slack) {
  const Four lowest = lowest_with_lane(dot(v, ring.low), dot(v, ring.high));
  const FourInts lower = lowest < dot(v, at) - all(slack);
  Place out;
  out.at = select(
      lower, {lane_of(ring.low.x, ring.high.x, lowest), lane_of(ring.low.y, ring.high.y, lowest), lane_of(ring.low.z, ring.high.z, lowest)},
      at);
  out.moved = lower[0] != 0;
  out.vertex = UGOKI_UNPREDICTABLE(out.moved) ? ring.node->vertex[lane_in(lowest)] : ring.vertex;
  if (ring.node->more_count > 0) [[unlikely]]
    return step_beyond(h, *ring.node, make, v, slack, out);
  return out;
}

constexpr std::int32_t brisk = 400;   ///< GilbertTrend::pace above which the direction is followed
constexpr double trust = 0.65;        ///< how much of what was not foretold is the motion's and not the facets'
constexpr double trust_change = 0.1;  ///< the same of its change from query to query

/// A direction more, about 1 long: level and change are smoothed (Holt 1957).
static inline void follow(GilbertTrend& trend, const Four& n) {
  const Four next = four_at(trend.next.data()), change = four_at(trend.change.data());
  const Four ahead = n * (trust + trust_change) + (next * (1 - trust - trust_change) + change), turned = change + (n - next) * trust_change;
  __builtin_memcpy(trend.next.data(), &ahead, sizeof ahead);
  __builtin_memcpy(trend.change.data(), &turned, sizeof turned);
}

/// Counts vertices passed, and follows the direction where they are many.
static inline void watch(GilbertTrend& trend, std::int32_t passed, const Vec3& n, double distance) {
  trend.pace += 32 * passed - (trend.pace >> 5);
  if (trend.pace <= brisk) [[likely]] {
    trend.inverse_distance = 0;
    return;
  }
  if (trend.inverse_distance == 0) {
    trend.next = {n.x, n.y, n.z, 0};
    trend.change = {};
  }
  follow(trend, Four{n.x, n.y, n.z, 0});
  trend.inverse_distance = 1 / distance;
}

/// Search of two hulls from what the last query left.
class HullSearch {
 public:
  HullSearch(const Support& a, const Pose& X_WA, const Support& b, const Pose& X_WB, GilbertCache& cache, const GilbertOptions& options)
      : sa_(a), sb_(b), a_(*a.hull), b_(*b.hull), X_WA_(X_WA), X_WB_(X_WB), cache_(cache), options_(options) {}

  /// False where the general search must do it: nothing is known of the pair yet, or it is too close, or does not converge at once.
  bool run(GilbertResult& out) {
    if (!is_cached()) return false;
    const LanePose X = between(X_WA_, X_WB_);
    const Four3 on_a = corners(a_, a0_), on_b = X(corners(b_, b0_));
    LaneSimplex simplex;
    simplex.w = on_a - on_b;
    simplex.ia = FourInts{a0_[1], a0_[2], a0_[0], a0_[0]};
    simplex.ib = FourInts{b0_[1], b0_[2], b0_[0], b0_[0]};
    simplex.alive = all(std::int64_t{cache_.count}) > FourInts{1, 2, 3, 3};
    return go_on(out, X, Measures(*this, X), simplex, {third(on_a), a0_[0], false}, {third(on_b), b0_[0], false}, true, 1);
  }

 protected:
  /// What is small and what is not.
  struct Measures {
    double tolerance, scale;  ///< m: greatest gap; size of the coordinates
    Measures(const HullSearch& of, const LanePose& X) {
      const double size = of.a_.radius + of.b_.radius;
      tolerance = of.options_.tolerance * (size + of.sa_.radius + of.sb_.radius);
      scale = size + std::fabs(X.p.x[0]) + std::fabs(X.p.y[0]) + std::fabs(X.p.z[0]);
    }
  };

  /// Ring by ring from a corner to the nearest point.
  /// @param news whether the corner (a, b) is not among those of the simplex
  /// @param k rings looked at, this one included
  [[gnu::always_inline]] bool go_on(GilbertResult& out, const LanePose& X, const Measures& measures, LaneSimplex simplex, Place a, Place b,
                                    bool news, int k) {
    const double tolerance = measures.tolerance, scale = measures.scale, least = least_apart * scale;
    for (; k < most_rings; ++k) {
      // Before the simplex is reduced, as they do not wait for it.
      const Ring ring_a = ring_at(a_, a.vertex, InPlace()), ring_b = ring_at(b_, b.vertex, X);
      if (news) simplex.add(a.at - b.at, a.vertex, b.vertex);
      const Four3 v = simplex.v;
      const double vv = dot(v, v)[0], d = std::sqrt(vv);
      if (!(d > least)) return false;
      const double slack = level * scale * d;
      a = step_down(a_, ring_a, a.at, StayInPlace(), v, slack);
      b = step_down(b_, ring_b, b.at, MoveBetween{X_WA_, X_WB_}, {-v.x, -v.y, -v.z}, slack);
      const double vw = dot(v, a.at - b.at)[0];
      if (!(vw > 0)) return false;
      news = vv - vw > tolerance * d;
      if (!news && !a.moved && !b.moved) {
        out.iterations = k;
        return finish(out, simplex, d, vw / d, tolerance, ring_a.vertex, ring_b.vertex);
      }
    }
    return false;
  }

  static Four3 third(const Four3& q) {
    const auto lane = [](const Four& x) { return __builtin_shufflevector(x, x, 2, 2, 2, 2); };
    return {lane(q.x), lane(q.y), lane(q.z)};
  }

  /// Whether the cache names vertices of these hulls; entries beyond its count become its first.
  bool is_cached() {
    const std::int32_t count = cache_.count;
    if (count <= 0 || count > 3) return false;
    const auto na = static_cast<std::uint32_t>(a_.vertices.size()), nb = static_cast<std::uint32_t>(b_.vertices.size());
    bool in = true;
    for (std::int32_t k = 0; k < 3; ++k) {
      const auto i = static_cast<std::size_t>(k < count ? k : 0);
      a0_[k] = cache_.a[i];
      b0_[k] = cache_.b[i];
      in = in & (static_cast<std::uint32_t>(a0_[k]) < na) & (static_cast<std::uint32_t>(b0_[k]) < nb);
    }
    return in;
  }

  /// The cached corners; the first of them in lane 2.
  static Four3 corners(const Hull& h, const std::int32_t* i) {
    const double *r = h.walk.nodes[static_cast<std::size_t>(i[0])].own, *p = h.walk.nodes[static_cast<std::size_t>(i[1])].own,
                 *q = h.walk.nodes[static_cast<std::size_t>(i[2])].own;
    return {Four{p[0], q[0], r[0], r[0]}, Four{p[1], q[1], r[1], r[1]}, Four{p[2], q[2], r[2], r[2]}};
  }

  [[gnu::always_inline]] bool finish(GilbertResult& out, const LaneSimplex& simplex, double d, double lower, double tolerance,
                                     std::int32_t ia, std::int32_t ib) {
    const Four& weight = simplex.weight;
    const Vec3 v{simplex.v.x[0], simplex.v.y[0], simplex.v.z[0]};
    Vec3 on_a, w;
    for (int k = 0; k < 3; ++k) {
      const double* at = a_.walk.nodes[static_cast<std::size_t>(simplex.ia[k])].own;
      on_a += Vec3{at[0], at[1], at[2]} * weight[k];
      w += Vec3{simplex.w.x[k], simplex.w.y[k], simplex.w.z[k]} * weight[k];
    }
    const Vec3 off = w - v;
    if (!(ugoki::dot(off, off) <= tolerance * tolerance && d - lower <= tolerance)) return false;
    const Vec3 n = v * (1 / d);
    const double radii = sa_.radius + sb_.radius;
    out.status = lower > options_.farthest + radii ? GilbertStatus::beyond : GilbertStatus::separated;
    out.distance = d - radii;
    out.lower = std::fmin(lower, d) - radii;
    out.n = X_WA_.R * n;
    out.pa = X_WA_ * (on_a - n * sa_.radius);
    out.pb = out.pa - out.n * out.distance;
    cache_.n = n;
    watch(cache_.trend, (a0_[0] != ia ? 1 : 0) + (b0_[0] != ib ? 1 : 0), out.n, d);
    remember(simplex, ia, ib);
    return true;
  }

  /// The middles of the last rings first.
  [[gnu::always_inline]] void remember(const LaneSimplex& simplex, std::int32_t ia, std::int32_t ib) {
    std::size_t count = 0, middle = 0;
    for (int k = 0; k < 3; ++k) {
      cache_.a[count] = static_cast<std::int32_t>(simplex.ia[k]);
      cache_.b[count] = static_cast<std::int32_t>(simplex.ib[k]);
      const bool alive = simplex.alive[k] != 0;
      middle = alive && simplex.ia[k] == ia && simplex.ib[k] == ib ? count : middle;
      count += alive ? 1 : 0;
    }
    const std::int32_t a = cache_.a[middle], b = cache_.b[middle];
    cache_.a[middle] = cache_.a[0];
    cache_.b[middle] = cache_.b[0];
    cache_.a[0] = a;
    cache_.b[0] = b;
    cache_.count = static_cast<std::int32_t>(count);
  }

  const Support &sa_, &sb_;
  const Hull &a_, &b_;
  const Pose &X_WA_, &X_WB_;
  GilbertCache& cache_;
  const GilbertOptions& options_;
  std::int32_t a0_[3], b0_[3];  ///< vertices of the cache
};

}  // namespace
}  // namespace ugoki::collision
