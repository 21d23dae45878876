#pragma once
// Gilbert's method for two hulls in fast motion, when the closest vertices change at nearly every query. The direction between the hulls is
// predicted. One step along this direction gives a corner of the Minkowski difference of the hulls. The edges at this corner that most
// likely contain the closest point are tested. The prediction affects only the speed, not the result. Internal linkage on purpose: see
// gilbert_search.h. Design: docs/design/convex-distance.md.
//
// Ring: a vertex and its neighbours. Fan: a corner of the difference with four edges that start at it (lane_fan.h).

#include "ugoki/collision/hull_search.h"
#include "ugoki/collision/lane_fan.h"

namespace ugoki::collision {
namespace {  // NOLINT(google-build-namespaces): see gilbert_search.h

constexpr int max_fans = 4;  ///< count of rings inspected, including the predicted step, before search_rings() is used

/// Stores lanes 0 to 2 of x in `out`.
static inline void store3(Vec3& out, const Four& x) { __builtin_memcpy(static_cast<void*>(&out), &x, sizeof out); }

/// Search of two hulls in fast motion.
class HullLeap : public HullSearch {
 public:
  using HullSearch::HullSearch;

  /// Returns false if the general search (gilbert_search.h) must be used.
  bool run(GilbertResult& out) {
    a0_[0] = cache_.a[0];
    b0_[0] = cache_.b[0];
    if (cache_.count <= 0 || static_cast<std::size_t>(a0_[0]) >= a_.walk.nodes.size() ||
        static_cast<std::size_t>(b0_[0]) >= b_.walk.nodes.size())
      return false;
    const Four3 down_a = predicted_in(X_WA_, 1), down_b = predicted_in(X_WB_, -1);
    std::int32_t ia = step_along(a_, a0_[0], down_a), ib = step_along(b_, b0_[0], down_b);
    const LanePose X = between(X_WA_, X_WB_);
    const Measures measures(*this, X);
    for (int k = 2;; ++k) {
      const HullWalk::Node &node_a = a_.walk.nodes[static_cast<std::size_t>(ia)], &node_b = b_.walk.nodes[static_cast<std::size_t>(ib)];
      const Four3 a = own(node_a), own_b = own(node_b), b = X(own_b), p = a - b;
      const Edges edges_a{low(node_a) - a, high(node_a) - a}, edges_b{X.turn(own_b - low(node_b)), X.turn(own_b - high(node_b))};
      const TwoLowest in_a = two_steepest(edges_a, p), in_b = two_steepest(edges_b, p);
      const Four3 e = fan_of(edges_a, in_a, edges_b, in_b);
      const LaneFan fan(e, p);
      const Four3& v = fan.v;
      const double vv = dot(v, v)[0], vw = dot(v, p)[0], d = std::sqrt(vv), slack = equal_height * measures.scale * d;
      const Four lowest = lesser(lesser(dot(v, edges_a.low), dot(v, edges_a.high)), lesser(dot(v, edges_b.low), dot(v, edges_b.high)));
      const bool proved = d > min_apart * measures.scale && vw > 0 && vv - vw <= measures.tolerance * d && !any_of(lowest < all(-slack));
      const Corners corners = corners_of(fan, node_a, in_a, ia, node_b, in_b, ib);
      std::int32_t next_a = ia, next_b = ib;
      if (!proved || (node_a.more_count | node_b.more_count) > 0) {
        if (!(d > min_apart * measures.scale)) {
          cache_.trend = {};
          return false;
        }
        next_a = step(a_, edges_a, a, 1, v, slack, node_a, ia, MakeIdentity());
        next_b = step(b_, edges_b, b, -1, v, slack, node_b, ib, MakePose{X_WA_, X_WB_});
      }
      if (proved && next_a == ia && next_b == ib) {
        const Four on_e = fan.first_of_a ? fan.s : all(0.0), on_f = fan.second_of_a ? fan.t : all(0.0);
        out.iterations = k;
        finish_leap(out, v, a + take(e * on_e + fan.f * on_f, fan.named), d, vw);
        remember_corners(corners, take(fan.s, fan.named)[0], take(fan.t, fan.named)[0]);
        return true;
      }
      if (k == max_fans || (next_a == ia && next_b == ib))
        return HullLeap(*this).continue_from({take(e, fan.named), take(fan.f, fan.named), p, v}, take(fan.s, fan.named)[0],
                                             take(fan.t, fan.named)[0], corners, next_a, next_b, out, measures, k);
      ia = next_a;
      ib = next_b;
    }
  }

 private:
  /// Edges from a vertex to its first eight neighbours.
  struct Edges {
    Four3 low, high;  ///< m: edges to neighbours 0 ... 3 and 4 ... 7
  };

  /// Positions [m, hull's frame] of neighbours 0 ... 3 of the node's vertex.
  static Four3 low(const HullWalk::Node& node) { return {four_at(node.x), four_at(node.y), four_at(node.z)}; }
  /// Positions [m, hull's frame] of neighbours 4 ... 7 of the node's vertex.
  static Four3 high(const HullWalk::Node& node) { return {four_at(node.x + 4), four_at(node.y + 4), four_at(node.z + 4)}; }
  /// Position [m, hull's frame] of the node's vertex, in all lanes.
  static Four3 own(const HullWalk::Node& node) { return {all(node.own[0]), all(node.own[1]), all(node.own[2])}; }

  /// One descent step from vertex i: returns the neighbour at which v . (a - b) is minimal, or i if no neighbour is lower by more than
  /// slack [m^2].
  /// @param at m, frame of a: position of vertex i
  /// @param sign +1 for hull a, -1 for hull b: sign of the edges in the difference a - b
  template <class Make>
  static std::int32_t step(const Hull& h, const Edges& e, const Four3& at, double sign, const Four3& v, double slack,
                           const HullWalk::Node& node, std::int32_t i, const Make& make) {
    const Four lowest = lowest_with_lane(dot(v, e.low), dot(v, e.high));
    const bool lower = lowest[0] < -slack;
    const std::int32_t next = UGOKI_UNPREDICTABLE(lower) ? node.vertex[lane_in(lowest)] : i;
    if (node.more_count == 0) [[likely]]
      return next;
    const Four3 edge{pick(e.low.x, e.high.x, lowest), pick(e.low.y, e.high.y, lowest), pick(e.low.z, e.high.z, lowest)};
    return step_beyond(h, node, make, v * all(sign), slack, {lower ? at + edge * all(sign) : at, next, lower}).vertex;
  }

  /// The predicted direction in the frame of the pose X, times `sign`; the same in all lanes.
  Four3 predicted_in(const Pose& X, double sign) const {
    const std::array<double, 4>& n = cache_.trend.next;
    return spread(row_of(X, 0) * all(sign * n[0]) + row_of(X, 1) * all(sign * n[1]) + row_of(X, 2) * all(sign * n[2]));
  }

  /// Index of the lowest neighbour of vertex i along v (hull's frame), or i if none is lower.
  static std::int32_t step_along(const Hull& h, std::int32_t i, const Four3& v) {
    const HullWalk::Node& node = h.walk.nodes[static_cast<std::size_t>(i)];
    const Four lowest = lowest_with_lane(dot(v, low(node)), dot(v, high(node)));
    const FourInts lower = lowest < dot(v, own(node));
    const std::int32_t next = node.vertex[lane_in(lowest)];
    return UGOKI_UNPREDICTABLE(lower[0] != 0) ? next : i;
  }

  /// The two edges e with the lowest p . e: from corner p, the distance from the origin decreases fastest along them.
  static TwoLowest two_steepest(const Edges& e, const Four3& p) { return two_lowest_with_lanes(dot(p, e.low), dot(p, e.high)); }

  /// Edges of a fan: two edges of a in lanes 0 and 2, two edges of b in lanes 1 and 3.
  static Four3 fan_of(const Edges& a, const TwoLowest& in_a, const Edges& b, const TwoLowest& in_b) {
    const FourInts front = {-1, -1, 0, 0};
    const Four at_a = front ? in_a.first : in_a.second, at_b = front ? in_b.first : in_b.second;
    return select(LaneFan::first_of_a, {pick(a.low.x, a.high.x, at_a), pick(a.low.y, a.high.y, at_a), pick(a.low.z, a.high.z, at_a)},
                  {pick(b.low.x, b.high.x, at_b), pick(b.low.y, b.high.y, at_b), pick(b.low.z, b.high.z, at_b)});
  }

  /// Vertices of a and b at the face of the fan (lane_fan.h) that is closest to the origin: [0] at its corner, [1] and [2] at the ends of
  /// its two edges.
  struct Corners {
    std::int32_t a[3], b[3];
    bool parallelogram;  ///< true: the feature is the face spanned by an edge of a and an edge of b
  };
  static Corners corners_of(const LaneFan& fan, const HullWalk::Node& a, const TwoLowest& in_a, std::int32_t ia, const HullWalk::Node& b,
                            const TwoLowest& in_b, std::int32_t ib) {
    const std::int32_t ends_a[4] = {a.vertex[lane_in(in_a.first)], ia, a.vertex[lane_in(in_a.second)], ia};
    const std::int32_t ends_b[4] = {ib, b.vertex[lane_in(in_b.first)], ib, b.vertex[lane_in(in_b.second)]};
    const int first = fan.lane(), second = LaneFan::second_lane(first);
    return {{ia, ends_a[first], ends_a[second]}, {ib, ends_b[first], ends_b[second]}, first == 0 || first == 3};
  }

  /// Fills in the result, and updates the direction in the cache.
  /// @param v m, frame of a: closest point of the difference; d = |v|
  /// @param on_a m, frame of a: closest point on the core of a
  /// @param vw m^2: v . corner; vw / d is the lower bound
  [[gnu::always_inline]] void finish_leap(GilbertResult& out, const Four3& v, const Four3& on_a, double d, double vw) {
    const double radii = sa_.radius + sb_.radius, inverse = 1 / d, lower = vw * inverse;
    const Four r0 = row_of(X_WA_, 0), r1 = row_of(X_WA_, 1), r2 = row_of(X_WA_, 2);
    const Four xz = __builtin_shufflevector(r0, r1, 0, 4, 2, 6), y = __builtin_shufflevector(r0, r1, 1, 5, 1, 5);
    const Four3 columns{__builtin_shufflevector(xz, r2, 0, 1, 4, 4), __builtin_shufflevector(y, r2, 0, 1, 5, 5),
                        __builtin_shufflevector(xz, r2, 2, 3, 6, 6)};
    Four at;
    __builtin_memcpy(&at, reinterpret_cast<const char*>(&X_WA_) + 64, sizeof at);
    const Four along = dot(columns, v), n = along * all(inverse);
    const Four pa = dot(columns, on_a) + shuffle<1, 2, 3, 3>(at) - n * all(sa_.radius);
    out.status = lower > options_.farthest + radii ? GilbertStatus::beyond : GilbertStatus::separated;
    out.distance = d - radii;
    out.lower = (lower < d ? lower : d) - radii;
    store3(out.n, n);
    store3(out.pa, pa);
    store3(out.pb, pa - n * all(d - radii));
    cache_.n = Vec3{v.x[0], v.y[0], v.z[0]} * inverse;
    // The direction is normalised with the previous distance, because the square root and division of this query are not yet available.
    predict_next(cache_.trend, along * all(cache_.trend.inverse_distance));
    cache_.trend.inverse_distance = inverse;
  }

  /// Updates the rate of changed vertices, and stores the closest vertices in the cache.
  /// @param s, t coordinates of the closest point along the two edges (LaneFan)
  [[gnu::always_inline]] void remember_corners(const Corners& corners, double s, double t) {
    cache_.trend.pace += 32 * ((corners.a[0] != a0_[0] ? 1 : 0) + (corners.b[0] != b0_[0] ? 1 : 0)) - (cache_.trend.pace >> 5);
    for (std::size_t k = 0; k < 3; ++k) {
      cache_.a[k] = corners.a[k];
      cache_.b[k] = corners.b[k];
    }
    cache_.count = t > 0 ? 3 : s > 0 ? 2 : 1;
  }

  /// Edge or face of a fan that is closest to the origin: m, frame of a, the same in all lanes.
  struct Feature {
    Four3 first, second, p, v;  ///< the feature's two edges, its corner p, and v, its point closest to the origin
  };

  /// Continues with search_rings() from the simplex of the corners of `feature`.
  /// @param s, t coordinates (0 ... 1) of the closest point along the two edges of the feature
  /// @param ia, ib vertices of a and b whose rings are inspected next
  /// @param k count of rings inspected so far
  [[gnu::noinline]] bool continue_from(Feature feature, double s, double t, Corners corners, std::int32_t ia, std::int32_t ib,
                                       GilbertResult& out, Measures measures, int k) {
    const LanePose X = between(X_WA_, X_WB_);
    const bool beyond = corners.parallelogram && s + t > 1;  // closest point in the half of the parallelogram opposite to p
    LaneSimplex simplex;
    const Four3 first = feature.p + feature.first, second = feature.p + feature.second,
                corner = beyond ? first + feature.second : feature.p;
    const FourInts one = {-1, 0, 0, 0}, two = {0, -1, 0, 0};
    simplex.w = select(one, first, select(two, second, corner));
    // The opposite corner is formed by the end vertex of the edge of a and the end vertex of the edge of b.
    const std::int32_t ca = beyond ? (corners.a[1] != corners.a[0] ? corners.a[1] : corners.a[2]) : corners.a[0];
    const std::int32_t cb = beyond ? (corners.b[1] != corners.b[0] ? corners.b[1] : corners.b[2]) : corners.b[0];
    simplex.ia = FourInts{corners.a[1], corners.a[2], ca, ca};
    simplex.ib = FourInts{corners.b[1], corners.b[2], cb, cb};
    simplex.weight = beyond ? Four{1 - t, 1 - s, s + t - 1, 0} : Four{s, t, 1 - s - t, 0};
    simplex.alive = simplex.weight > all(0.0);
    simplex.v = feature.v;
    const Four3 a = own(a_.walk.nodes[static_cast<std::size_t>(ia)]), b = X(own(b_.walk.nodes[static_cast<std::size_t>(ib)]));
    const double vv = dot(feature.v, feature.v)[0];
    const bool is_new = vv - dot(feature.v, a - b)[0] > measures.tolerance * std::sqrt(vv);
    return search_rings(out, X, measures, simplex, {a, ia, false}, {b, ib, false}, is_new, k + 1);
  }
};

/// Distance between two hulls with Hull::walk, by the general search (gilbert_search.h).
[[gnu::noinline]] static GilbertResult general_distance(const Support& a, const Pose& X_WA, const Support& b, const Pose& X_WB,
                                                        GilbertCache& cache, const GilbertOptions& options) {
  if (!all_finite(X_WA) || !all_finite(X_WB)) return {};
  return Search<HullCore, HullCore>(a, X_WA, b, X_WB, cache, options).run();
}

/// Distance between two hulls with Hull::walk that moved far since the previous query. Not inlined, so that this function takes no
/// registers from the code for hulls that moved little.
[[gnu::noinline]] static GilbertResult fast_motion_distance(const Support& a, const Pose& X_WA, const Support& b, const Pose& X_WB,
                                                            GilbertCache& cache, const GilbertOptions& options) {
  GilbertResult out;
  if (HullLeap(a, X_WA, b, X_WB, cache, options).run(out)) return out;
  return general_distance(a, X_WA, b, X_WB, cache, options);
}

/// Distance between two hulls with Hull::walk. Selects the search for fast or slow motion; the general search is the fallback.
static inline GilbertResult hull_distance(const Support& a, const Pose& X_WA, const Support& b, const Pose& X_WB, GilbertCache& cache,
                                          const GilbertOptions& options) {
  if (cache.trend.pace > fast_pace) [[unlikely]]
    return fast_motion_distance(a, X_WA, b, X_WB, cache, options);
  GilbertResult out;
  if (HullSearch(a, X_WA, b, X_WB, cache, options).run(out)) return out;
  return general_distance(a, X_WA, b, X_WB, cache, options);
}

}  // namespace
}  // namespace ugoki::collision
#undef UGOKI_UNPREDICTABLE
