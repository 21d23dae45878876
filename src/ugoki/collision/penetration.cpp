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

/// Relative to the size of the coordinates: a Minkowski difference thinner than this counts as flat, without an interior.
constexpr double flat = 1e-14;

/// Result of the expansion: the shortest translation that moves the origin out of the Minkowski difference of the cores (support.h).
struct MinimumTranslation {
  Vec3 n;            ///< unit, frame of a: outward from the difference, that is from a towards b
  double depth = 0;  ///< m: extent of the difference along n, measured from the origin
  double lower = 0;  ///< m: lower bound of the extent in every direction
  Vec3 on_a;         ///< m, frame of a: deepest point on the core of a
  int iterations = 0;
  bool converged = false;
};

/// The expanding polytope algorithm for the difference of two overlapping cores.
class Expansion {
 public:
  /// @param size m: scale of the coordinates, for thresholds
  /// @param tolerance m: accepted gap between `depth` and `lower`
  /// @param shared m, frame of a: a point of both cores
  Expansion(const Difference& difference, const GilbertCache& cache, Polytope& polytope, double size, double tolerance, const Vec3& shared)
      : difference_(difference), cache_(cache), polytope_(polytope), size_(size), tolerance_(tolerance), shared_(shared) {}

  MinimumTranslation run(int max_iterations) {
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

  /// Corners of the polytope feature through which the minimum translation leaves the difference: the warm start of the next query.
  [[nodiscard]] const Corner* corners() const { return exit_corners_; }
  [[nodiscard]] int corner_count() const { return exit_count_; }

 private:
  Corner support(const Vec3& d) {
    const Corner c = difference_.support(d, 0, 0);
    ++best_.iterations;
    return c;
  }

  /// Finds on_a, the point of a that belongs to the point of the polytope's surface closest to n * depth. Several faces may be in the same
  /// plane. Therefore all faces that are as close to the origin as the closest face are tried.
  void find_point() {
    const Vec3 foot = best_.n * best_.depth;
    double min_off2 = 1e300;
    for (std::int32_t f = 0; f < polytope_.face_count(); ++f) {
      const PolytopeFace& face = polytope_.face(f);
      if (!face.alive || face.d > best_.depth + tolerance_) continue;
      for (int turn = 0; turn < 3; ++turn) {  // reduce() considers only features with the last corner, so each corner is the last one once
        Simplex s;
        s.count = 3;
        for (int k = 0; k < 3; ++k) {
          s.corner[k] = polytope_.corner(face.corner[(k + turn) % 3]);
          s.corner[k].w -= foot;  // moves the origin to the foot
        }
        bool inside;
        const Vec3 off = reduce(s, 0, inside);
        if (!(dot(off, off) < min_off2)) continue;
        min_off2 = dot(off, off);
        best_.on_a = {};
        for (int k = 0; k < s.count; ++k) best_.on_a += s.corner[k].a * s.weight[k];
        for (int k = 0; k < 3; ++k) exit_corners_[k] = polytope_.corner(face.corner[k]);
      }
    }
    exit_count_ = 3;
  }

  /// Completes best_ for a flat difference: a point, segment or polygon spanned by `count` (1 to 3) points. n is perpendicular to it.
  /// @return always false
  bool end_flat(const Vec3& n, const Corner* c, int count) {
    const double up = dot(n, support(n).w), down = -dot(n, support(-n).w);
    best_.n = down < up ? -n : n;
    best_.depth = down < up ? down : up;
    best_.lower = std::fmin(best_.depth, 0);
    best_.on_a = shared_;
    best_.converged = true;
    for (int k = 0; k < count; ++k) exit_corners_[k] = c[k];
    exit_count_ = count;
    return false;
  }

  void collect(const Corner& c) {
    if (found_count_ < max_found) found_[found_count_++] = c;
  }

  /// Index of the collected point with the maximum measure(w).
  template <class Measure>
  int farthest(Measure measure) const {
    int best = 0;
    double best_measure = -1;
    for (int k = 0; k < found_count_; ++k)
      if (const double m = measure(found_[k].w); m > best_measure) best_measure = m, best = k;
    return best;
  }

  /// Builds the first tetrahedron from the points of the last query and some extreme points. Returns false if the difference is flat;
  /// best_ is then complete.
  bool start() {
    best_.depth = 1e300;
    collect_cached();
    if (found_count_ < 4)
      for (int k = 0; k < 3; ++k) {
        Vec3 d;
        d[k] = 1;
        collect(support(d));
        collect(support(-d));
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
    // A triangle or tetrahedron thinner than 1e-3 of the size is a poor start: more extreme points are collected first.
    if (!(from_line(t[2].w) > 1e-3 * size_)) widen(axis);
    t[2] = found_[farthest(from_line)];
    if (!(from_line(t[2].w) > thin)) return end_flat(any_perpendicular(axis), t, 2);
    const Vec3 normal = normalized(cross(axis, t[2].w - t[0].w));
    const auto from_plane = [&](const Vec3& w) { return std::fabs(dot(normal, w - t[0].w)); };
    t[3] = found_[farthest(from_plane)];
    if (!(from_plane(t[3].w) > 1e-3 * size_)) {
      collect(support(normal));
      collect(support(-normal));
    }
    t[3] = found_[farthest(from_plane)];
    if (!(from_plane(t[3].w) > thin) || !polytope_.start(t[0], t[1], t[2], t[3])) return end_flat(normal, t, 3);
    for (int k = 0; k < found_count_; ++k) (void)polytope_.add(found_[k]);
    return true;
  }

  /// Collects extreme points in four directions perpendicular to `axis`.
  void widen(const Vec3& axis) {
    const Vec3 u = any_perpendicular(axis), v = cross(axis, u);
    collect(support(u));
    collect(support(-u));
    collect(support(v));
    collect(support(-v));
  }

  /// Collects the corners in the cache, which Gilbert's method or the last query stored, and the extreme points along the cached normal.
  void collect_cached() {
    for (int k = 0; k < cache_.count && k < 3; ++k) {
      const auto i = static_cast<std::size_t>(k);
      Vec3 a, b;
      if (!corner_of(difference_.a, cache_.a[i], a) || !corner_of(difference_.b, cache_.b[i], b)) return;
      collect({a - (difference_.R * b + difference_.p), a, cache_.a[i], cache_.b[i]});
    }
    if (dot(cache_.n, cache_.n) > 0.5) {
      collect(support(-cache_.n));
      collect(support(cache_.n));
    }
  }

  static constexpr int max_found = 24;
  const Difference& difference_;
  const GilbertCache& cache_;
  Polytope& polytope_;
  double size_, tolerance_;
  Vec3 shared_;
  MinimumTranslation best_;
  Corner found_[max_found];
  int found_count_ = 0;
  Corner exit_corners_[3];
  int exit_count_ = 0;
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
  const MinimumTranslation translation = expansion.run(2 * options.max_iterations);

  SignedDistance out;
  out.status = translation.converged ? DistanceStatus::penetrating : DistanceStatus::not_converged;
  out.distance = -translation.depth - a.radius - b.radius;
  out.lower = out.distance;  // n separates the shapes after this translation: the true depth is not larger
  out.upper = -translation.lower - a.radius - b.radius;
  out.iterations = g.iterations + translation.iterations;
  out.n = X_WA.R * -translation.n;
  out.pa = X_WA * (translation.on_a + translation.n * a.radius);
  out.pb = out.pa - out.n * out.distance;
  cache.n = -translation.n;
  cache.count = expansion.corner_count();
  for (int k = 0; k < cache.count; ++k) {
    const auto i = static_cast<std::size_t>(k);
    cache.a[i] = expansion.corners()[k].ia;
    cache.b[i] = expansion.corners()[k].ib;
  }
  return out;
}

}  // namespace ugoki::collision
