#include "ugoki/collision/penetration.h"

#include <cmath>
#include <utility>

#include "ugoki/collision/difference.h"
#include "ugoki/collision/polytope.h"
#include "ugoki/spatial/rotation.h"

namespace ugoki::collision {

PenetrationWorkspace::PenetrationWorkspace() : polytope_(new Polytope) {}
PenetrationWorkspace::~PenetrationWorkspace() { delete polytope_; }
PenetrationWorkspace::PenetrationWorkspace(PenetrationWorkspace&& other) noexcept : polytope_(std::exchange(other.polytope_, nullptr)) {}
PenetrationWorkspace& PenetrationWorkspace::operator=(PenetrationWorkspace&& other) noexcept {
  std::swap(polytope_, other.polytope_);
  return *this;
}

namespace {

constexpr double flat = 1e-14;  ///< of the coordinates: thinner has no inside

/// What the expansion finds: the way out of the difference of the cores.
struct WayOut {
  Vec3 n;            ///< unit, frame of a: out of the difference, that is from a towards b
  double depth = 0;  ///< m: how far the difference reaches along n
  double lower = 0;  ///< m: it reaches no less far in any direction
  Vec3 on_a;         ///< m, frame of a
  int iterations = 0;
  bool converged = false;
};

class Expansion {
 public:
  /// @param shared m, frame of a: a point of both cores
  Expansion(const Difference& difference, const GilbertCache& cache, Polytope& polytope, double size, double tolerance, const Vec3& shared)
      : difference_(difference), cache_(cache), polytope_(polytope), size_(size), tolerance_(tolerance), shared_(shared) {}

  WayOut run(int max_iterations) {
    if (!start()) return best_;
    while (best_.iterations < max_iterations) {
      const std::int32_t f = polytope_.nearest();
      const PolytopeFace face = polytope_.face(f);
      best_.lower = face.d;
      best_.converged = best_.depth - face.d <= tolerance_;
      if (best_.converged) break;
      const Corner& hint = polytope_.corner(face.corner[0]);
      const Corner c = difference_.support(face.n, hint.ia, hint.ib);
      ++best_.iterations;
      const double reach = dot(face.n, c.w);
      if (reach < best_.depth) {
        best_.n = face.n;
        best_.depth = reach;
      }
      best_.converged = reach - face.d <= tolerance_;
      if (best_.converged || !polytope_.add_beyond(c, f)) break;
    }
    find_point();
    return best_;
  }

  /// Corners of the face that the way out leads through.
  [[nodiscard]] const Corner* corners() const { return through_; }
  [[nodiscard]] int corner_count() const { return through_count_; }

 private:
  Corner look(const Vec3& d) {
    const Corner c = difference_.support(d, 0, 0);
    ++best_.iterations;
    return c;
  }

  /// The point of the surface on the way out: of all faces as near as the nearest (several may lie in its plane) the closest.
  void find_point() {
    const Vec3 foot = best_.n * best_.depth;
    double least = 1e300;
    for (std::int32_t f = 0; f < polytope_.face_count(); ++f) {
      const PolytopeFace& face = polytope_.face(f);
      if (!face.alive || face.d > best_.depth + tolerance_) continue;
      for (int turn = 0; turn < 3; ++turn) {  // reduce() looks at the features of the last corner
        Simplex s;
        s.count = 3;
        for (int k = 0; k < 3; ++k) {
          s.corner[k] = polytope_.corner(face.corner[(k + turn) % 3]);
          s.corner[k].w -= foot;  // nearest to the foot, not to the origin
        }
        bool inside;
        const Vec3 off = reduce(s, 0, inside);
        if (!(dot(off, off) < least)) continue;
        least = dot(off, off);
        best_.on_a = {};
        for (int k = 0; k < s.count; ++k) best_.on_a += s.corner[k].a * s.weight[k];
        for (int k = 0; k < 3; ++k) through_[k] = polytope_.corner(face.corner[k]);
      }
    }
    through_count_ = 3;
  }

  /// The difference has no inside: it is the point, line or plane of `count` points, and n is square on it.
  bool end_flat(const Vec3& n, const Corner* c, int count) {
    const double up = dot(n, look(n).w), down = -dot(n, look(-n).w);
    best_.n = down < up ? -n : n;
    best_.depth = down < up ? down : up;
    best_.lower = std::fmin(best_.depth, 0);
    best_.on_a = shared_;
    best_.converged = true;
    for (int k = 0; k < count; ++k) through_[k] = c[k];
    through_count_ = count;
    return false;
  }

  void collect(const Corner& c) {
    if (found_count_ < most_found) found_[found_count_++] = c;
  }

  /// Farthest of the points found so far by `measure`.
  template <class Measure>
  int farthest(Measure measure) const {
    int best = 0;
    double greatest = -1;
    for (int k = 0; k < found_count_; ++k)
      if (const double m = measure(found_[k].w); m > greatest) greatest = m, best = k;
    return best;
  }

  /// A tetrahedron with the points of the last query and some more; false where the difference is flat (then all is done).
  bool start() {
    best_.depth = 1e300;
    recall();
    if (found_count_ < 4)
      for (int k = 0; k < 3; ++k) {
        Vec3 d;
        d[k] = 1;
        collect(look(d));
        collect(look(-d));
      }
    const double thin = flat * size_;
    Corner t[4];
    t[0] = found_[0];
    t[1] = found_[farthest([&](const Vec3& w) { return norm(w - t[0].w); })];
    const Vec3 along = t[1].w - t[0].w;
    const double length = norm(along);
    if (!(length > thin)) return end_flat(dot(cache_.n, cache_.n) > 0.5 ? -cache_.n : Vec3{0, 0, 1}, t, 1);
    const Vec3 axis = along / length;
    const auto from_line = [&](const Vec3& w) { return norm(cross(axis, w - t[0].w)); };
    t[2] = found_[farthest(from_line)];
    if (!(from_line(t[2].w) > 1e-3 * size_)) widen(axis);
    t[2] = found_[farthest(from_line)];
    if (!(from_line(t[2].w) > thin)) return end_flat(any_perpendicular(axis), t, 2);
    const Vec3 normal = normalized(cross(axis, t[2].w - t[0].w));
    const auto from_plane = [&](const Vec3& w) { return std::fabs(dot(normal, w - t[0].w)); };
    t[3] = found_[farthest(from_plane)];
    if (!(from_plane(t[3].w) > 1e-3 * size_)) {
      collect(look(normal));
      collect(look(-normal));
    }
    t[3] = found_[farthest(from_plane)];
    if (!(from_plane(t[3].w) > thin) || !polytope_.start(t[0], t[1], t[2], t[3])) return end_flat(normal, t, 3);
    for (int k = 0; k < found_count_; ++k) (void)polytope_.add(found_[k]);
    return true;
  }

  void widen(const Vec3& axis) {
    const Vec3 u = any_perpendicular(axis), v = cross(axis, u);
    collect(look(u));
    collect(look(-u));
    collect(look(v));
    collect(look(-v));
  }

  /// The corners that Gilbert's method, or the last query, left in the cache.
  void recall() {
    for (int k = 0; k < cache_.count && k < 3; ++k) {
      const auto i = static_cast<std::size_t>(k);
      Vec3 a, b;
      if (!corner_of(difference_.a, cache_.a[i], a) || !corner_of(difference_.b, cache_.b[i], b)) return;
      collect({a - (difference_.R * b + difference_.p), a, cache_.a[i], cache_.b[i]});
    }
    if (dot(cache_.n, cache_.n) > 0.5) {
      collect(look(-cache_.n));
      collect(look(cache_.n));
    }
  }

  static constexpr int most_found = 24;
  const Difference& difference_;
  const GilbertCache& cache_;
  Polytope& polytope_;
  double size_, tolerance_;
  Vec3 shared_;
  WayOut best_;
  Corner found_[most_found];
  int found_count_ = 0;
  Corner through_[3];
  int through_count_ = 0;
};

DistanceStatus to_status(const GilbertResult& g) {
  switch (g.status) {
    case GilbertStatus::separated: return g.distance > 0 ? DistanceStatus::separated : DistanceStatus::penetrating;
    case GilbertStatus::touching: return DistanceStatus::penetrating;
    case GilbertStatus::beyond: return DistanceStatus::beyond;
    case GilbertStatus::not_converged: return DistanceStatus::not_converged;
    case GilbertStatus::not_bounded: return DistanceStatus::not_bounded;
    case GilbertStatus::not_finite: break;
  }
  return DistanceStatus::not_finite;
}

}  // namespace

SignedDistance signed_distance(const Support& a, const Pose& X_WA, const Support& b, const Pose& X_WB, GilbertCache& cache,
                               PenetrationWorkspace& workspace, const GilbertOptions& options) {
  const GilbertResult g = gilbert_distance(a, X_WA, b, X_WB, cache, options);
  const bool plane = a.kind == SupportKind::half_space || b.kind == SupportKind::half_space;
  if (g.status != GilbertStatus::touching || plane) return {to_status(g), g.distance, g.lower, g.distance, g.pa, g.pb, g.n, g.iterations};

  const Difference difference(a, X_WA, b, X_WB);
  const double sizes = bounding_radius(a) + bounding_radius(b);
  const double scale = sizes + norm(difference.p);
  const double tolerance = std::fmax(options.tolerance * sizes, 4e-15 * scale);
  Expansion expansion(difference, cache, workspace.polytope(), scale, tolerance, transpose_times(X_WA.R, g.pa - X_WA.p));
  const WayOut way = expansion.run(2 * options.max_iterations);

  SignedDistance out;
  out.status = way.converged ? DistanceStatus::penetrating : DistanceStatus::not_converged;
  out.distance = -way.depth - a.radius - b.radius;
  out.lower = out.distance;  // they come apart along n
  out.upper = -way.lower - a.radius - b.radius;
  out.iterations = g.iterations + way.iterations;
  out.n = X_WA.R * -way.n;
  out.pa = X_WA * (way.on_a + way.n * a.radius);
  out.pb = out.pa - out.n * out.distance;
  cache.n = -way.n;
  cache.count = expansion.corner_count();
  for (int k = 0; k < cache.count; ++k) {
    const auto i = static_cast<std::size_t>(k);
    cache.a[i] = expansion.corners()[k].ia;
    cache.b[i] = expansion.corners()[k].ib;
  }
  return out;
}

}  // namespace ugoki::collision
