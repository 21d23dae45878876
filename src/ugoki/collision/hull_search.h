#pragma once
// Gilbert's method for two hulls that move little between two queries: a fast search from the closest features of the previous query. It is
// compiled once per SIMD width, with the same operations in the same order, so that all widths give the same bits. Values stay in SIMD
// lanes and are selected by masks, which avoids stalls on memory and on branches that the processor cannot predict. Each step inspects one
// ring of each hull. Ring: a vertex and its neighbours. Internal linkage on purpose: see gilbert_search.h. Design:
// docs/design/convex-distance.md.

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

constexpr int max_rings = 24;           ///< count of rings inspected before the general search is used
constexpr double min_apart = 1e-5;      ///< relative to the coordinates: pairs closer than this use the general search
constexpr double equal_height = 1e-15;  ///< relative to the coordinates: smaller differences of height are rounding errors

/// The identity transform.
struct Identity {
  Four3 operator()(const Four3& q) const { return q; }
};

/// A pose with each of its coefficients in all lanes.
struct LanePose {
  Four3 x, y, z;  ///< rows of the rotation matrix
  Four3 p;        ///< m: translation

  Four3 operator()(const Four3& q) const {
    return {x.x * q.x + x.y * q.y + x.z * q.z + p.x, y.x * q.x + y.y * q.y + y.z * q.z + p.y, z.x * q.x + z.y * q.y + z.z * q.z + p.z};
  }
  /// Rotates a direction.
  Four3 turn(const Four3& q) const {
    return {x.x * q.x + x.y * q.y + x.z * q.z, y.x * q.x + y.y * q.y + y.z * q.z, z.x * q.x + z.y * q.y + z.z * q.z};
  }
};

/// Row `row` of a pose's rotation matrix. Lane 3 contains the value that follows in memory; do not use it.
static inline Four row_of(const Pose& X, int row) {
  static_assert(sizeof(Pose) == 12 * sizeof(double));
  Four out;
  __builtin_memcpy(&out, reinterpret_cast<const char*>(&X) + row * 24, sizeof out);
  return out;
}

/// Pose of frame B in frame A, from the world poses of both frames.
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

/// Result of a step from a vertex of a hull, in the frame of a.
struct VertexStep {
  Four3 at;  ///< m: position of `vertex`, the same in all lanes
  std::int32_t vertex;
  bool moved;
};

/// Function objects that make the transform from a hull's frame to the frame of a: MakeIdentity for hull a, MakePose for hull b.
struct MakeIdentity {
  Identity operator()() const { return {}; }
};
struct MakePose {
  const Pose &X_WA, &X_WB;
  LanePose operator()() const { return between(X_WA, X_WB); }
};

/// Continues a descent step with the neighbours after the eighth (HullWalk::overflow).
/// @param make makes the transform again, so that the caller need not keep it in memory for this rare case
/// @param best result among the first eight neighbours
template <class Make>
[[gnu::noinline]] static VertexStep step_beyond(const Hull& h, const HullWalk::Node& node, Make make, Four3 v, double slack,
                                                VertexStep best) {
  const auto move = make();
  const auto more = static_cast<std::size_t>(node.more), count = static_cast<std::size_t>(node.more_count);
  for (std::size_t i = more; i < more + count; ++i) {
    const std::int32_t vertex = h.walk.overflow[i];
    const Four3 at = move(all(h.vertices[static_cast<std::size_t>(vertex)]));
    if (dot(v, at)[0] < dot(v, best.at)[0] - (best.moved ? 0 : slack)) best = {at, vertex, true};
  }
  return best;
}

/// A vertex and its first eight neighbours.
struct Ring {
  std::int32_t vertex;
  const HullWalk::Node* node;
  Four3 low, high;  ///< m, frame of a: positions of neighbours 0 ... 3 and 4 ... 7
};

/// The ring of a vertex (the vertex and its first eight neighbours) in the frame of a.
/// @param move transform from the hull's frame to that of a
template <class Move>
static inline Ring ring_at(const Hull& h, std::int32_t vertex, const Move& move) {
  const HullWalk::Node& node = h.walk.nodes[static_cast<std::size_t>(vertex)];
  return {vertex, &node, move(Four3{four_at(node.x), four_at(node.y), four_at(node.z)}),
          move(Four3{four_at(node.x + 4), four_at(node.y + 4), four_at(node.z + 4)})};
}

/// One descent step: to the neighbour with the minimum v . x, or to the ring's own vertex if no neighbour is lower by more than slack.
/// @param at m, frame of a: position of the ring's vertex, the same in all lanes
/// @param slack m^2: smaller differences of v . x are rounding
template <class Make>
static inline VertexStep step_down(const Hull& h, const Ring& ring, const Four3& at, const Make& make, const Four3& v, double slack) {
  const Four lowest = lowest_with_lane(dot(v, ring.low), dot(v, ring.high));
  const FourInts lower = lowest < dot(v, at) - all(slack);
  VertexStep out;
  out.at = select(
      lower, {lane_of(ring.low.x, ring.high.x, lowest), lane_of(ring.low.y, ring.high.y, lowest), lane_of(ring.low.z, ring.high.z, lowest)},
      at);
  out.moved = lower[0] != 0;
  out.vertex = UGOKI_UNPREDICTABLE(out.moved) ? ring.node->vertex[lane_in(lowest)] : ring.vertex;
  if (ring.node->more_count > 0) [[unlikely]]
    return step_beyond(h, *ring.node, make, v, slack, out);
  return out;
}

constexpr std::int32_t fast_pace = 400;  ///< GilbertTrend::pace above which the motion is fast: 0.4 changed vertices per query
constexpr double level_gain = 0.65;      ///< smoothing gain of the direction; the rest of a prediction error is attributed to hull facets
constexpr double change_gain = 0.1;      ///< smoothing gain of the direction's change per query

/// Updates the predicted direction with the direction n (length about 1) of this query, by double exponential smoothing (Holt 1957).
static inline void predict_next(GilbertTrend& trend, const Four& n) {
  const Four next = four_at(trend.next.data()), change = four_at(trend.change.data());
  const Four ahead = n * (level_gain + change_gain) + (next * (1 - level_gain - change_gain) + change),
             turned = change + (n - next) * change_gain;
  __builtin_memcpy(trend.next.data(), &ahead, sizeof ahead);
  __builtin_memcpy(trend.change.data(), &turned, sizeof turned);
}

/// Updates GilbertTrend::pace and, in fast motion, the predicted direction.
/// @param passed count of hulls (0 ... 2) whose closest vertex changed in this query
static inline void update_trend(GilbertTrend& trend, std::int32_t passed, const Vec3& n, double distance) {
  trend.pace += 32 * passed - (trend.pace >> 5);
  if (trend.pace <= fast_pace) [[likely]] {
    trend.inverse_distance = 0;
    return;
  }
  if (trend.inverse_distance == 0) {
    trend.next = {n.x, n.y, n.z, 0};
    trend.change = {};
  }
  predict_next(trend, Four{n.x, n.y, n.z, 0});
  trend.inverse_distance = 1 / distance;
}

/// Search of two hulls from the closest features of the previous query. The general search (gilbert_search.h) is the fallback.
class HullSearch {
 public:
  HullSearch(const Support& a, const Pose& X_WA, const Support& b, const Pose& X_WB, GilbertCache& cache, const GilbertOptions& options)
      : sa_(a), sb_(b), a_(*a.hull), b_(*b.hull), X_WA_(X_WA), X_WB_(X_WB), cache_(cache), options_(options) {}

  /// Returns false if the general search must be used: the cache is empty, the hulls are too close, or the search does not converge. The
  /// cache is then unchanged.
  bool run(GilbertResult& out) {
    if (!is_cached()) return false;
    const LanePose X = between(X_WA_, X_WB_);
    const Four3 on_a = corners(a_, a0_), on_b = X(corners(b_, b0_));
    LaneSimplex simplex;
    simplex.w = on_a - on_b;
    simplex.ia = FourInts{a0_[1], a0_[2], a0_[0], a0_[0]};
    simplex.ib = FourInts{b0_[1], b0_[2], b0_[0], b0_[0]};
    simplex.alive = all(std::int64_t{cache_.count}) > FourInts{1, 2, 3, 3};
    return search_rings(out, X, Measures(*this, X), simplex, {lane_2(on_a), a0_[0], false}, {lane_2(on_b), b0_[0], false}, true, 1);
  }

 protected:
  /// Tolerance and scale of a query.
  struct Measures {
    double tolerance, scale;  ///< m; tolerance: accepted duality gap; scale: upper bound of the coordinates
    Measures(const HullSearch& of, const LanePose& X) {
      const double size = of.a_.radius + of.b_.radius;
      tolerance = of.options_.tolerance * (size + of.sa_.radius + of.sb_.radius);
      scale = size + std::fabs(X.p.x[0]) + std::fabs(X.p.y[0]) + std::fabs(X.p.z[0]);
    }
  };

  /// Gilbert's iteration: each step inspects the rings of two vertices, descends on both hulls, and adds the new corner to the simplex. It
  /// ends when no neighbour is lower along v and the duality gap is within the tolerance.
  /// @param a, b vertices of hulls a and b at which the search starts
  /// @param is_new true: the corner (a, b) is not yet in the simplex
  /// @param k count of rings inspected so far, including the first of this call
  /// @return false if the general search must be used
  [[gnu::always_inline]] bool search_rings(GilbertResult& out, const LanePose& X, const Measures& measures, LaneSimplex simplex,
                                           VertexStep a, VertexStep b, bool is_new, int k) {
    const double tolerance = measures.tolerance, scale = measures.scale, minimum = min_apart * scale;
    for (; k < max_rings; ++k) {
      // The rings are loaded before the simplex is reduced, as they do not depend on its result.
      const Ring ring_a = ring_at(a_, a.vertex, Identity()), ring_b = ring_at(b_, b.vertex, X);
      if (is_new) simplex.add(a.at - b.at, a.vertex, b.vertex);
      const Four3 v = simplex.v;
      const double vv = dot(v, v)[0], d = std::sqrt(vv);
      if (!(d > minimum)) return false;
      const double slack = equal_height * scale * d;
      a = step_down(a_, ring_a, a.at, MakeIdentity(), v, slack);
      b = step_down(b_, ring_b, b.at, MakePose{X_WA_, X_WB_}, {-v.x, -v.y, -v.z}, slack);
      const double vw = dot(v, a.at - b.at)[0];
      if (!(vw > 0)) return false;
      is_new = vv - vw > tolerance * d;
      if (!is_new && !a.moved && !b.moved) {
        out.iterations = k;
        return finish(out, simplex, d, vw / d, tolerance, ring_a.vertex, ring_b.vertex);
      }
    }
    return false;
  }

  /// Copies lane 2 to all lanes.
  static Four3 lane_2(const Four3& q) {
    const auto lane = [](const Four& x) { return __builtin_shufflevector(x, x, 2, 2, 2, 2); };
    return {lane(q.x), lane(q.y), lane(q.z)};
  }

  /// Loads the vertices of the cache; entries beyond its count repeat the first. @return false if the cache is empty or invalid
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

  /// Positions of three cached vertices: i[1], i[2], i[0] in lanes 0 to 2; lane 3 repeats i[0].
  static Four3 corners(const Hull& h, const std::int32_t* i) {
    const double *r = h.walk.nodes[static_cast<std::size_t>(i[0])].own, *p = h.walk.nodes[static_cast<std::size_t>(i[1])].own,
                 *q = h.walk.nodes[static_cast<std::size_t>(i[2])].own;
    return {Four{p[0], q[0], r[0], r[0]}, Four{p[1], q[1], r[1], r[1]}, Four{p[2], q[2], r[2], r[2]}};
  }

  /// Fills in the result and the cache. @return false if the simplex is too inaccurate
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
    update_trend(cache_.trend, (a0_[0] != ia ? 1 : 0) + (b0_[0] != ib ? 1 : 0), out.n, d);
    remember(simplex, ia, ib);
    return true;
  }

  /// Stores the vertices of the simplex in the cache. The vertices (ia, ib) of the last rings become the first entry of the cache.
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
  std::int32_t a0_[3], b0_[3];  ///< vertices loaded by is_cached()
};

}  // namespace
}  // namespace ugoki::collision
