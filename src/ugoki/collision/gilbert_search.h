#pragma once
// The general search of Gilbert's method. It is compiled once per SIMD width (gilbert.cpp, gilbert_avx2.cpp, gilbert_avx512.cpp), with the
// same operations in the same order, so that all widths give the same bits. Everything has internal linkage on purpose: the linker must not
// merge a function compiled for wide registers with one for other processors.

#include <cmath>

#include "ugoki/collision/gilbert.h"
#include "ugoki/collision/simplex.h"
#include "ugoki/collision/support_point.h"

namespace ugoki::collision {
namespace {  // NOLINT(google-build-namespaces): see above

constexpr double rounding = 1e-15;  ///< relative to the coordinates: rounding error of a difference of support points
constexpr double touch = 1e-14;     ///< relative to the coordinates: cores (support.h) closer than this are touching

constexpr int max_restarts = 5;  ///< restarts from a single point before the search returns not_converged

static inline bool all_finite(const Pose& X) {
  const double sum = X.R.xx + X.R.xy + X.R.xz + X.R.yx + X.R.yy + X.R.yz + X.R.zx + X.R.zy + X.R.zz + X.p.x + X.p.y + X.p.z;
  return sum - sum == 0;
}

/// Interface of the search to a hull with prepared hill climbing (Hull::walk).
struct HullCore {
  const Support& s;
  const Hull& h;
  explicit HullCore(const Support& of) : s(of), h(*of.hull) {}
  /// True if the core has finitely many corners.
  static constexpr bool polytope() { return true; }
  [[nodiscard]] SupportPoint support(const Vec3& d, std::int32_t hint) const {
    const std::int32_t v = walk_to_extreme(h, d, hint);
    return {h.vertices[static_cast<std::size_t>(v)], v};
  }
  /// Sets p [m] to the position of vertex v. @return false if the hull has no vertex v
  [[nodiscard]] bool corner(std::int32_t v, Vec3& p) const {
    if (static_cast<std::size_t>(v) >= h.vertices.size()) return false;
    p = h.vertices[static_cast<std::size_t>(v)];
    return true;
  }
  /// Vertex at which a search along the direction d starts.
  [[nodiscard]] std::int32_t seed(const Vec3& d) const { return seed_vertex(h, d); }
  [[nodiscard]] Vec3 centre() const { return h.centre; }
  /// Radius [m] of the sphere about centre() that contains the core.
  [[nodiscard]] double extent() const { return h.radius; }
};

/// Interface of the search to any other bounded core, with the members of HullCore.
struct AnyCore {
  const Support& s;
  explicit AnyCore(const Support& of) : s(of) {}
  [[nodiscard]] bool polytope() const { return s.kind != SupportKind::cylinder && s.kind != SupportKind::ellipsoid; }
  [[nodiscard]] SupportPoint support(const Vec3& d, std::int32_t hint) const { return support_point(s, d, hint); }
  [[nodiscard]] bool corner(std::int32_t v, Vec3& p) const { return corner_of(s, v, p); }
  [[nodiscard]] std::int32_t seed(const Vec3& d) const { return s.kind == SupportKind::hull ? seed_vertex(*s.hull, d) : 0; }
  [[nodiscard]] Vec3 centre() const { return centre_of(s); }
  [[nodiscard]] double extent() const { return bounding_radius(s) - s.radius; }
};

/// One query. The search runs in the frame of a, on the Minkowski difference a - b of the cores. v_ is the point of the current simplex
/// closest to the origin; its length is an upper bound of the distance. Each support point along -v_ gives a lower bound of the distance
/// and a new corner of the simplex.
template <class A, class B>
class Search {
 public:
  Search(const Support& a, const Pose& X_WA, const Support& b, const Pose& X_WB, GilbertCache& cache, const GilbertOptions& options)
      : a_(a), b_(b), X_WA_(X_WA), cache_(cache), options_(options) {
    R_ = X_WA.R.transposed() * X_WB.R;
    p_ = transpose_times(X_WA.R, X_WB.p - X_WA.p);
    radii_ = a.radius + b.radius;
    size_ = a_.extent() + b_.extent();
  }

  GilbertResult run() {
    GilbertResult out;
    const Vec3 between = a_.centre() - (R_ * b_.centre() + p_);
    scale_ = size_ + std::fabs(p_.x) + std::fabs(p_.y) + std::fabs(p_.z);
    if (!(scale_ - scale_ == 0)) return out;
    const double tolerance = std::fmax(options_.tolerance * (size_ + radii_), 4 * rounding * scale_);
    const double beyond = options_.farthest + radii_;
    const bool warm = start(between);
    double vv = dot(v_, v_);
    double lower2 = 0;  // m^2: square of the maximum lower bound so far
    out.status = GilbertStatus::not_converged;
    int restarts = 0;
    std::int32_t ha = 0, hb = 0;
    if (warm) nearest_hints(ha, hb);
    while (out.iterations < options_.max_iterations) {
      if (!(vv > touch * touch * scale_ * scale_)) {
        out.status = GilbertStatus::touching;
        break;
      }
      if (!warm && out.iterations < 2) {
        ha = a_.seed(-v_);
        hb = b_.seed(transpose_times(R_, v_));
      }
      Corner c = support(ha, hb);
      ha = c.ia;
      hb = c.ib;
      ++out.iterations;
      const double vw = dot(v_, c.w);
      if (vw > 0) {
        const double l2 = vw * vw / vv;
        if (l2 > lower2) lower2 = l2;
        if (lower2 > beyond * beyond) {
          out.status = GilbertStatus::beyond;
          if (simplex_.count > 0) break;
        }
      }
      const double gap = vv - vw;
      if (simplex_.count > 0 && (gap <= 0 || gap * gap <= tolerance * tolerance * vv || is_in_simplex(c))) {
        out.status = GilbertStatus::separated;
        break;
      }
      simplex_.corner[simplex_.count++] = c;
      bool inside;
      const Vec3 v = reduce(simplex_, rounding * scale_, inside);
      if (inside) {
        out.status = GilbertStatus::touching;
        break;
      }
      const double next = dot(v, v);
      v_ = v;
      if (out.status == GilbertStatus::beyond) break;
      if (simplex_.count > 1 && !(next < vv) && out.iterations > 1) {
        // The simplex is so small that rounding prevents progress: restart from the last support point, which is almost the closest point.
        if (++restarts > max_restarts) break;
        simplex_.count = 1;
        simplex_.corner[0] = c;
        simplex_.weight[0] = 1;
        v_ = c.w;
        vv = dot(v_, v_);
        continue;
      }
      vv = next;
    }
    finish(out, lower2, tolerance);
    return out;
  }

 private:
  Corner support(std::int32_t ha, std::int32_t hb) const {
    const SupportPoint a = a_.support(-v_, ha), b = b_.support(transpose_times(R_, v_), hb);
    return {a.p - (R_ * b.p + p_), a.p, a.vertex, b.vertex};
  }

  /// True if the corner is already in the simplex, so that the search cannot improve further (polytopes only).
  bool is_in_simplex(const Corner& c) const {
    if (!a_.polytope() || !b_.polytope()) return false;
    for (int k = 0; k < simplex_.count; ++k)
      if (simplex_.corner[k].ia == c.ia && simplex_.corner[k].ib == c.ib) return true;
    return false;
  }

  /// Sets simplex_ and v_ from the closest features of the previous query at the new poses. If the cache has none, sets only v_.
  /// @return true if the simplex was set
  bool start(const Vec3& between) {
    simplex_.count = 0;
    if (a_.polytope() && b_.polytope() && cache_.count > 0 && cache_.count <= 3) {
      for (int k = 0; k < cache_.count; ++k) {
        const auto i = static_cast<std::size_t>(k);
        Vec3 pa, pb;
        if (!a_.corner(cache_.a[i], pa) || !b_.corner(cache_.b[i], pb)) {
          simplex_.count = 0;
          break;
        }
        simplex_.corner[simplex_.count++] = {pa - (R_ * pb + p_), pa, cache_.a[i], cache_.b[i]};
      }
    }
    if (simplex_.count > 0) {
      bool inside;
      v_ = reduce(simplex_, rounding * scale_, inside);
      return true;
    }
    v_ = dot(cache_.n, cache_.n) > 0.5 ? cache_.n : between;
    if (!(dot(v_, v_) > 0)) v_ = {1, 0, 0};
    return false;
  }

  /// Sets the start vertices ha of a and hb of b to those of the simplex corner with the maximum weight.
  void nearest_hints(std::int32_t& ha, std::int32_t& hb) const {
    int best = 0;
    for (int k = 1; k < simplex_.count; ++k)
      if (simplex_.weight[k] > simplex_.weight[best]) best = k;
    ha = simplex_.corner[best].ia;
    hb = simplex_.corner[best].ib;
  }

  /// Fills in the result and the cache.
  void finish(GilbertResult& out, double lower2, double tolerance) {
    const double lower = std::sqrt(lower2);
    Vec3 on_a, w;
    for (int k = 0; k < simplex_.count; ++k) {
      on_a += simplex_.corner[k].a * simplex_.weight[k];
      w += simplex_.corner[k].w * simplex_.weight[k];
    }
    if (out.status == GilbertStatus::touching) {
      out.distance = out.lower = -radii_;
      out.pa = out.pb = X_WA_ * on_a;
      remember();
      return;
    }
    const double d = norm(v_);
    const Vec3 n = v_ / d;
    // v_ comes from the normal of a face, which is wrong for slivers. If v_ differs from the weighted sum w of the corners, w is used.
    const Vec3 off = w - v_;
    const double reached = dot(off, off) <= tolerance * tolerance ? d : norm(w);
    if (out.status != GilbertStatus::beyond)
      out.status = reached - lower <= tolerance ? GilbertStatus::separated : GilbertStatus::not_converged;
    out.distance = reached - radii_;
    out.lower = std::fmin(lower, reached) - radii_;
    out.n = X_WA_.R * n;
    out.pa = X_WA_ * (on_a - n * a_.s.radius);
    out.pb = out.pa - out.n * out.distance;
    cache_.n = n;
    remember();
  }

  /// Stores the vertices of the simplex in the cache.
  void remember() {
    cache_.count = simplex_.count < 3 ? simplex_.count : 3;
    for (int k = 0; k < cache_.count; ++k) {
      cache_.a[static_cast<std::size_t>(k)] = simplex_.corner[k].ia;
      cache_.b[static_cast<std::size_t>(k)] = simplex_.corner[k].ib;
    }
  }

  A a_;
  B b_;
  const Pose& X_WA_;
  GilbertCache& cache_;
  const GilbertOptions& options_;
  Mat3 R_;      ///< rotation of b in a
  Vec3 p_, v_;  ///< m, frame of a; p_: position of b; v_: point of the difference closest to the origin so far
  Simplex simplex_;
  double radii_ = 0;  ///< m: sum of the radii by which the cores are inflated
  double size_ = 0;   ///< m: sum of the bounding radii of the cores
  double scale_ = 0;  ///< m: upper bound of the coordinates, to which rounding errors are relative
};

}  // namespace
}  // namespace ugoki::collision
