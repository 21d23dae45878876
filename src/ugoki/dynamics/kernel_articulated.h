#pragma once
// Articulated inertia of one body, and its transformation to another point and across a joint. For kernels_*.cpp only.

#include "ugoki/dynamics/kernel_crossing.h"

namespace ugoki::dynamics {
namespace {  // NOLINT(google-build-namespaces): see spatial/lanes.h

/// Articulated inertia [[I, H], [H^T, M]] and bias force (n, f) about the node's origin.
template <class T>
struct Articulated {
  Sym3T<T> I;
  Mat3T<T> H;
  Sym3T<T> M;
  V3<T> n, f;
};
template <class T>
UGOKI_INLINE void add(Articulated<T>& a, const Articulated<T>& b) {
  a.I = a.I + b.I;
  a.H += b.H;
  a.M = a.M + b.M;
  a.n += b.n;
  a.f += b.f;
}

/// Gyroscopic moment w x I w of a node's body. @param w rad/s: angular velocity of the node, in its own axes
template <class T, class Constant>
UGOKI_INLINE V3<T> gyroscopic(const NodeOrder& o, const NodeConstants<Constant>& c, const V3<T>& w) {
  const T xy = w.x * w.y, xz = w.x * w.z, yz = w.y * w.z;
  V3<T> n{yz * T(c.spread[0]), xz * T(c.spread[1]), xy * T(c.spread[2])};
  if (o.oblique) {
    const T xx = w.x * w.x, yy = w.y * w.y, zz = w.z * w.z, Ixy(c.I[3]), Ixz(c.I[4]), Iyz(c.I[5]);
    n.x += (xy * Ixz - xz * Ixy) + (yy - zz) * Iyz;
    n.y += (yz * Ixy - xy * Iyz) + (zz - xx) * Ixz;
    n.z += (xz * Iyz - yz * Ixz) + (xx - yy) * Ixy;
  }
  return n;
}
/// Articulated inertia and bias force of a node's own body, without its children.
template <class T, class Constant>
UGOKI_INLINE Articulated<T> body(const NodeOrder& o, const NodeConstants<Constant>& c, const V3<T>& w) {
  const T none(0), m(c.mass);
  const V3<T> zero{none, none, none};
  Articulated<T> A{symmetric_of<T>(c.I), Mat3T<T>::skew(vector_of<T>(c.h)), {m, m, m, none, none, none}, zero, zero};
  if (o.massless) return A;
  A.n = gyroscopic(o, c, w);
  if (o.moment != 0) A.f = centripetal(w, o.moment, c.h);
  return A;
}
/// Adds the inertia and bias force of a node's own body to A. @param w as in gyroscopic()
template <class T, class Constant>
UGOKI_INLINE void add_body(Articulated<T>& A, const NodeOrder& o, const NodeConstants<Constant>& c, const V3<T>& w) {
  const T m(c.mass);
  A.I.xx += T(c.I[0]);
  A.I.yy += T(c.I[1]);
  A.I.zz += T(c.I[2]);
  if (o.oblique) {
    A.I.xy += T(c.I[3]);
    A.I.xz += T(c.I[4]);
    A.I.yz += T(c.I[5]);
  }
  for_axes<T>(o.moment, c.h, [&](auto k, T x) {
    constexpr int a = (k + 1) % 3, b = (k + 2) % 3;
    entry<a, b>(A.H) -= x;
    entry<b, a>(A.H) += x;
  });
  A.M.xx += m;
  A.M.yy += m;
  A.M.zz += m;
  A.n += gyroscopic(o, c, w);
  if (o.moment != 0) A.f += centripetal(w, o.moment, c.h);
}

/// Transforms I and H across a revolute joint to the parent's axes. Requires that the z rows of I and H are zero: a joint without armature.
template <Crossing K, class T>
UGOKI_INLINE void up_without_z(const RevoluteCrossing<T, K>& X, Articulated<T>& A) {
  const T none(0);
  const T s = X.s, c = X.c, cs = c * s, cc = c * c, ss = s * s;
  const Sym3T<T> I = A.I;
  const Mat3T<T> H = A.H;
  const T dI = I.xx - I.yy;
  const T Ixx = I.yy + cc * dI - (cs + cs) * I.xy;
  A.I = exchange_up<K>(Sym3T<T>{Ixx, (I.xx + I.yy) - Ixx, none, cs * dI + (cc - ss) * I.xy, none, none});
  const T dH = H.xx - H.yy;
  const T Hxx = H.yy + cc * dH - cs * (H.xy + H.yx);
  const T Hxy = cs * dH + cc * H.xy - ss * H.yx;
  A.H = exchange_up<K>(
      Mat3T<T>{Hxx, Hxy, c * H.xz - s * H.yz, Hxy - (H.xy - H.yx), (H.xx + H.yy) - Hxx, s * H.xz + c * H.yz, none, none, none});
}

/// Changes the reference point of an articulated inertia and its bias force from r e_k to the origin; e_k is the unit vector of axis k.
/// @tparam k 0: x, 1: y, 2: z @tparam zero index of the row of I and H that is zero; 3: none
template <int k, int zero, class T>
UGOKI_INLINE void shift_along(Articulated<T>& a, T r) {
  constexpr int i = (k + 1) % 3, j = (k + 2) % 3;
  Mat3T<T>& H = a.H;
  const T mii = r * entry<i, i>(a.M), mij = r * entry<i, j>(a.M), mjj = r * entry<j, j>(a.M), mik = r * entry<i, k>(a.M),
          mjk = r * entry<j, k>(a.M);
  const T ii = zero == i ? -mij : entry<i, i>(H) - mij, ij = zero == i ? -mjj : entry<i, j>(H) - mjj,
          ik = zero == i ? -mjk : entry<i, k>(H) - mjk;
  const T ji = zero == j ? mii : entry<j, i>(H) + mii, jj = zero == j ? mij : entry<j, j>(H) + mij,
          jk = zero == j ? mik : entry<j, k>(H) + mik;
  if constexpr (zero == i)
    entry<i, i>(a.I) = -(r * ij);
  else
    entry<i, i>(a.I) -= r * (entry<i, j>(H) + ij);
  if constexpr (zero == j)
    entry<j, j>(a.I) = r * ji;
  else
    entry<j, j>(a.I) += r * (entry<j, i>(H) + ji);
  if constexpr (zero == i)
    entry<i, j>(a.I) = r * (ii - entry<j, j>(H));
  else if constexpr (zero == j)
    entry<i, j>(a.I) = r * ii;
  else
    entry<i, j>(a.I) += r * (ii - entry<j, j>(H));
  if constexpr (zero == i)
    entry<i, k>(a.I) = -(r * entry<k, j>(H));
  else if constexpr (zero != k)
    entry<i, k>(a.I) -= r * entry<k, j>(H);
  if constexpr (zero == j)
    entry<j, k>(a.I) = r * entry<k, i>(H);
  else if constexpr (zero != k)
    entry<j, k>(a.I) += r * entry<k, i>(H);
  entry<i, i>(H) = ii;
  entry<i, j>(H) = ij;
  entry<i, k>(H) = ik;
  entry<j, i>(H) = ji;
  entry<j, j>(H) = jj;
  entry<j, k>(H) = jk;
  add_cross<k>(a.n, r, a.f);
}
/// Changes the reference point of an articulated inertia from r to the origin, axis by axis. @param present the nonzero coordinates of r
/// @tparam zero as in shift_along()
template <int zero, class T, class Constant>
UGOKI_INLINE void shift(Articulated<T>& a, Axes present, const Constant* r) {
  switch (present) {
    case 0: return;
    case 1: return shift_along<0, zero>(a, T(r[0]));
    case 2: return shift_along<1, zero>(a, T(r[1]));
    case 4: return shift_along<2, zero>(a, T(r[2]));
    default: for_axes<T>(present, r, [&](auto k, T x) { shift_along<k, 3>(a, x); });
  }
}

/// Changes the reference point of an articulated inertia from r to the origin, for any r.
template <class T>
UGOKI_INLINE void shift(Articulated<T>& a, const V3<T>& r) {
  const Mat3T<T>& H = a.H;
  const Mat3T<T> G = H + Mat3T<T>::columns(cross(r, V3<T>{a.M.xx, a.M.xy, a.M.xz}), cross(r, V3<T>{a.M.xy, a.M.yy, a.M.yz}),
                                           cross(r, V3<T>{a.M.xz, a.M.yz, a.M.zz}));
  // I_ij <- I_ij + (r x row j of H)_i + (r x row i of G)_j, where G is the new H
  a.I.xx += r.y * (H.xz + G.xz) - r.z * (H.xy + G.xy);
  a.I.yy += r.z * (H.yx + G.yx) - r.x * (H.yz + G.yz);
  a.I.zz += r.x * (H.zy + G.zy) - r.y * (H.zx + G.zx);
  a.I.xy += (r.y * H.yz - r.z * H.yy) + (r.z * G.xx - r.x * G.xz);
  a.I.xz += (r.y * H.zz - r.z * H.zy) + (r.x * G.xy - r.y * G.xx);
  a.I.yz += (r.z * H.zx - r.x * H.zz) + (r.x * G.yy - r.y * G.yx);
  a.H = G;
  a.n += cross(r, a.f);
}

}  // namespace
}  // namespace ugoki::dynamics
