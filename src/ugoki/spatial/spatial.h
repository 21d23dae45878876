#pragma once
// 6-D vectors (angular part first), rigid-body inertias with 10 scalars, and poses.
// Source: Featherstone, Rigid Body Dynamics Algorithms (2008), ch. 2 and appendix A.

#include "ugoki/spatial/rotation.h"
#include "ugoki/spatial/vec3.h"

namespace ugoki {

/// Spatial vector. As a motion: w = angular velocity [rad/s], v = velocity of the body point at the frame's origin [m/s].
/// As a force (wrench): w = moment about the frame's origin [N m], v = force [N].
template <class T>
struct Vec6T {
  Vec3T<T> w, v;

  friend constexpr Vec6T operator+(const Vec6T& a, const Vec6T& b) { return {a.w + b.w, a.v + b.v}; }
  friend constexpr Vec6T operator-(const Vec6T& a, const Vec6T& b) { return {a.w - b.w, a.v - b.v}; }
  friend constexpr Vec6T operator-(const Vec6T& a) { return {-a.w, -a.v}; }
  friend constexpr Vec6T operator*(const Vec6T& a, T s) { return {a.w * s, a.v * s}; }
  constexpr Vec6T& operator+=(const Vec6T& b) { return *this = *this + b; }
  constexpr Vec6T& operator-=(const Vec6T& b) { return *this = *this - b; }
  friend constexpr bool operator==(const Vec6T&, const Vec6T&) = default;
};
using Vec6 = Vec6T<double>;

template <class T>
constexpr T dot(const Vec6T<T>& a, const Vec6T<T>& b) {
  return dot(a.w, b.w) + dot(a.v, b.v);
}
/// Spatial cross product a x m: rate of change of a motion m that is constant in a frame moving with velocity a.
template <class T>
constexpr Vec6T<T> cross_motion(const Vec6T<T>& a, const Vec6T<T>& m) {
  return {cross(a.w, m.w), cross(a.w, m.v) + cross(a.v, m.w)};
}
/// Spatial cross product a x* f: rate of change of a force f that is constant in a frame moving with velocity a.
template <class T>
constexpr Vec6T<T> cross_force(const Vec6T<T>& a, const Vec6T<T>& f) {
  return {cross(a.w, f.w) + cross(a.v, f.v), cross(a.w, f.v)};
}

/// Pose of frame B in frame A: p_A = R p_B + p.
template <class T>
struct PoseT {
  Mat3T<T> R = Mat3T<T>::identity();
  Vec3T<T> p;

  friend constexpr PoseT operator*(const PoseT& a, const PoseT& b) { return {a.R * b.R, a.R * b.p + a.p}; }
  constexpr Vec3T<T> operator*(const Vec3T<T>& q) const { return R * q + p; }
  constexpr PoseT inverse() const { return {R.transposed(), -transpose_times(R, p)}; }

  /// Converts a motion from B (about B's origin) to A (about A's origin).
  constexpr Vec6T<T> motion_to_parent(const Vec6T<T>& m) const {
    const Vec3T<T> w = R * m.w;
    return {w, R * m.v + cross(p, w)};
  }
  /// Converts a motion from A (about A's origin) to B (about B's origin).
  constexpr Vec6T<T> motion_to_child(const Vec6T<T>& m) const { return {transpose_times(R, m.w), transpose_times(R, m.v - cross(p, m.w))}; }
  /// Converts a force from B (about B's origin) to A (about A's origin).
  constexpr Vec6T<T> force_to_parent(const Vec6T<T>& f) const {
    const Vec3T<T> g = R * f.v;
    return {R * f.w + cross(p, g), g};
  }
  /// Converts a force from A (about A's origin) to B (about B's origin).
  constexpr Vec6T<T> force_to_child(const Vec6T<T>& f) const { return {transpose_times(R, f.w - cross(p, f.v)), transpose_times(R, f.v)}; }
};
using Pose = PoseT<double>;

/// Symmetric 3 x 3 matrix.
template <class T>
struct Sym3T {
  T xx{}, yy{}, zz{}, xy{}, xz{}, yz{};

  friend constexpr Vec3T<T> operator*(const Sym3T& s, const Vec3T<T>& v) {
    return {s.xx * v.x + s.xy * v.y + s.xz * v.z, s.xy * v.x + s.yy * v.y + s.yz * v.z, s.xz * v.x + s.yz * v.y + s.zz * v.z};
  }
  friend constexpr Sym3T operator+(const Sym3T& a, const Sym3T& b) {
    return {a.xx + b.xx, a.yy + b.yy, a.zz + b.zz, a.xy + b.xy, a.xz + b.xz, a.yz + b.yz};
  }
  friend constexpr Sym3T operator-(const Sym3T& a, const Sym3T& b) {
    return {a.xx - b.xx, a.yy - b.yy, a.zz - b.zz, a.xy - b.xy, a.xz - b.xz, a.yz - b.yz};
  }
  friend constexpr Sym3T operator*(const Sym3T& a, T s) { return {a.xx * s, a.yy * s, a.zz * s, a.xy * s, a.xz * s, a.yz * s}; }
  constexpr Mat3T<T> matrix() const { return {xx, xy, xz, xy, yy, yz, xz, yz, zz}; }
  friend constexpr bool operator==(const Sym3T&, const Sym3T&) = default;
};
using Sym3 = Sym3T<double>;

/// Symmetric part (m + m^T) / 2 of a matrix that is symmetric except for rounding.
template <class T>
constexpr Sym3T<T> symmetric_part(const Mat3T<T>& m) {
  const T half = T(0.5);
  return {m.xx, m.yy, m.zz, half * (m.xy + m.yx), half * (m.xz + m.zx), half * (m.yz + m.zy)};
}
/// Rotational inertia about the origin of a unit point mass at c: |c|^2 1 - c c^T.
template <class T>
constexpr Sym3T<T> point_inertia(const Vec3T<T>& c) {
  return {c.y * c.y + c.z * c.z, c.x * c.x + c.z * c.z, c.x * c.x + c.y * c.y, -c.x * c.y, -c.x * c.z, -c.y * c.z};
}
/// The matrix R S R^T: S in axes that R rotates.
template <class T>
constexpr Sym3T<T> rotated(const Sym3T<T>& s, const Mat3T<T>& R) {
  return symmetric_part(R * (s.matrix() * R.transposed()));
}

/// Rigid-body inertia about the frame's origin: mass [kg], first moment h = mass * centre [kg m], rotational inertia
/// about the ORIGIN [kg m^2].
template <class T>
struct InertiaT {
  T mass{};
  Vec3T<T> h;
  Sym3T<T> I;

  /// Makes an inertia from the mass, the centre of mass and the rotational inertia about the centre of mass.
  static constexpr InertiaT from_centre(T mass, const Vec3T<T>& centre, const Sym3T<T>& about_centre) {
    return {mass, centre * mass, about_centre + point_inertia(centre) * mass};
  }
  /// Inertia times motion: the momentum [N m s; N s] of the body that moves with m.
  friend constexpr Vec6T<T> operator*(const InertiaT& i, const Vec6T<T>& m) {
    return {i.I * m.w + cross(i.h, m.v), m.v * i.mass - cross(i.h, m.w)};
  }
  friend constexpr InertiaT operator+(const InertiaT& a, const InertiaT& b) { return {a.mass + b.mass, a.h + b.h, a.I + b.I}; }
  constexpr InertiaT& operator+=(const InertiaT& b) { return *this = *this + b; }
  friend constexpr bool operator==(const InertiaT&, const InertiaT&) = default;

  constexpr Vec3T<T> centre() const { return mass > T(0) ? h / mass : Vec3T<T>{}; }
  constexpr Sym3T<T> about_centre() const { return mass > T(0) ? I - point_inertia(h) * (T(1) / mass) : I; }
  /// Converts the inertia from frame B to frame A. @param X pose of B in A
  constexpr InertiaT in_parent(const PoseT<T>& X) const {
    const Vec3T<T> hr = X.R * h;
    // Parallel-axis theorem with the first moment hr in A's axes: R I R^T + m (|p|^2 1 - p p^T) + 2 p.hr 1 - p hr^T - hr p^T.
    const Vec3T<T>& p = X.p;
    const T ph = dot(p, hr);
    Sym3T<T> i = rotated(I, X.R) + point_inertia(p) * mass;
    i.xx += T(2) * (ph - p.x * hr.x);
    i.yy += T(2) * (ph - p.y * hr.y);
    i.zz += T(2) * (ph - p.z * hr.z);
    i.xy -= p.x * hr.y + p.y * hr.x;
    i.xz -= p.x * hr.z + p.z * hr.x;
    i.yz -= p.y * hr.z + p.z * hr.y;
    return {mass, hr + p * mass, i};
  }
};
using Inertia = InertiaT<double>;

}  // namespace ugoki
